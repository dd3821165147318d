// The facts of a dataset that nobody has to load.
#pragma once

#include "engine/data/dataset_facts.h"

namespace isostrata {

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
  facts.first_layers = {{0, 2}, {2, 4}, {4, 6}, {6, 8}};
  facts.times = {0, 1, 2};
  return facts;
}

}  // namespace isostrata
