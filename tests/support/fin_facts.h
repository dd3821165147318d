// The facts of a dataset that nobody has to load.
#pragma once

#include "engine/data/dataset_facts.h"

namespace isostrata {

/// A first view of these intervals of the array, as a dataset in this box would have it.
inline FirstView first_view_of(const std::string& array, const std::vector<Interval>& intervals, const Box3d& box) {
  FirstView view;
  view.array = array;
  view.lower = intervals.front().lower;
  view.upper = intervals.back().upper;
  for (const Interval& interval : intervals) {
    const std::size_t i = view.layers.size();
    view.layers.push_back({interval.lower, interval.upper, default_interval_color(i), 0.1 + 0.2 * static_cast<double>(i), {}, "", "a test"});
  }
  for (int c = 0; c < 8; ++c)
    view.outline.push_back({c & 1 ? box.upper.x : box.lower.x, c & 2 ? box.upper.y : box.lower.y, c & 4 ? box.upper.z : box.lower.z});
  return view;
}

/// "fin": two arrays with values, one without any, four first layers, three time steps.
inline DatasetFacts fin_facts() {
  DatasetFacts facts;
  facts.id = "fin";
  facts.name = "fin";
  facts.grid = "curvilinear";
  facts.bounds.include({-1, -1, -1});
  facts.bounds.include({1, 2, 3});
  facts.arrays = {{"Empty", "point", "float32", 1, 1, -1, 5},
                  {"Density", "point", "float32", 1, 0, 8, 0},
                  {"Energy", "point", "float64", 1, -100, 300, 0}};
  facts.first_view = first_view_of("Density", {{0, 2}, {2, 4}, {4, 6}, {6, 8}}, facts.bounds);
  facts.times = {0, 1, 2};
  return facts;
}

}  // namespace isostrata
