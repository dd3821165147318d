// Scenes whose intervals are shares of an array's range.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "data/dataset/dataset.h"
#include "scene/scene.h"

namespace isostrata {

/// Of the dataset's first array; shares: from 0, its least value, to 1. The intervals' ids count from 10.
inline Scene scene_of_shares(const Dataset& dataset, const std::vector<std::array<double, 2>>& shares) {
  Scene scene;
  const PointArray& array = dataset.arrays.front();
  scene.array = array.name;
  for (const auto& [lower, upper] : shares) {
    SceneInterval one;
    one.id = static_cast<std::uint32_t>(10 + scene.intervals.size());
    one.lower = array.lower + lower * (array.upper - array.lower);
    one.upper = array.lower + upper * (array.upper - array.lower);
    scene.intervals.push_back(one);
  }
  return scene;
}

}  // namespace isostrata
