#include "engine/data/dataset_facts.h"

namespace isostrata {

const ArrayFacts* DatasetFacts::find_array(std::string_view array) const {
  for (const ArrayFacts& facts : arrays)
    if (facts.name == array) return &facts;
  return nullptr;
}

DatasetFacts dataset_facts(std::string id, std::string name, const Dataset& dataset, const SeriesRanges& ranges) {
  DatasetFacts facts;
  facts.id = std::move(id);
  facts.name = std::move(name);
  facts.grid = dataset.grid.kind_name();
  facts.points = dataset.whole ? dataset.whole->points : dataset.grid.point_count();
  facts.cells = dataset.whole ? dataset.whole->cells : dataset.grid.cell_count();
  facts.cell_types = dataset.cell_types;
  facts.bounds = ranges.bounds();
  facts.axes.assign(dataset.axes.begin(), dataset.axes.end());
  std::map<std::string_view, const ArrayRanges*> ranges_of;
  for (const ArrayRanges& known : ranges.arrays()) ranges_of[known.name] = &known;
  for (const PointArray& array : dataset.arrays) {
    ArrayFacts of{array.name, array.association == Association::point ? "point" : "cell_averaged", to_string(array.type),
                  array.components, array.lower, array.upper, array.nan_count, {}, {}, array.unit};
    if (array.cells) of.cells = ValueRange{array.cells->lower, array.cells->upper};
    if (const auto known = ranges_of.find(array.name); known != ranges_of.end()) {
      of.lower = known->second->all.lower;
      of.upper = known->second->all.upper;
      of.nan_count = known->second->nan_count;
      of.steps = known->second->steps;
    }
    facts.arrays.push_back(std::move(of));
  }
  facts.missing_steps = ranges.steps() - ranges.known_steps();
  facts.times = dataset.times;
  facts.notes = dataset.notes;
  return facts;
}

}  // namespace isostrata
