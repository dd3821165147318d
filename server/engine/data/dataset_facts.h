// What a viewer may know of a dataset without holding it: plain data that can cross a process boundary.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/vec.h"
#include "data/dataset/dataset.h"
#include "data/derived/series_ranges.h"
#include "engine/first/first_view.h"

namespace isostrata {

struct ArrayFacts {
  std::string name;
  std::string association;  // "point" or "cell_averaged"
  std::string type;         // "float32", ...
  int components = 1;
  double lower = 0, upper = 0;         // of the finite values of all steps that are known; lower > upper if there is none
  std::int64_t nan_count = 0;          // at the known step that has most of them
  std::vector<ValueRange> steps = {};  // ArrayRanges::steps; may be empty
  std::optional<ValueRange> cells = {};  // of cell_averaged: of the cells themselves, at the step that was opened
  std::string unit = {};                 // PointArray::unit

  ValueRange range() const { return {lower, upper}; }
  /// Of what is taken: of whole cells theirs.
  ValueRange range(FieldValues values) const { return values == FieldValues::whole && cells ? *cells : range(); }
};

/// What has become of the files since they were read.
enum class OnDisk : std::uint8_t { as_read, changed, gone };

struct DatasetFacts {
  std::string id;    // of the catalogue
  std::string name;  // what a person reads; never a path
  std::string grid;  // "uniform", "rectilinear", "curvilinear", "unstructured"
  std::int64_t points = 0;
  std::int64_t cells = 0;
  std::map<std::string, std::int64_t> cell_types;
  Box3d bounds;
  std::vector<Axis> axes;  // three
  std::vector<ArrayFacts> arrays;
  std::vector<double> times;
  int missing_steps = 0;  // whose values the arrays' ranges leave out, because nobody has read them yet
  std::vector<std::string> notes;

  OnDisk on_disk = OnDisk::as_read;
  FirstView first_view;  // what is shown before anybody has chosen

  /// Null if there is none of that name.
  const ArrayFacts* find_array(std::string_view array) const;
};

/// Everything but first_view. The ranges are those of `ranges`, which knows this step.
DatasetFacts dataset_facts(std::string id, std::string name, const Dataset& dataset, const SeriesRanges& ranges);
inline DatasetFacts dataset_facts(std::string id, std::string name, const Dataset& dataset) {
  return dataset_facts(std::move(id), std::move(name), dataset, SeriesRanges(dataset));
}

}  // namespace isostrata
