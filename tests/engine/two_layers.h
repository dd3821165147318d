// A cylinder's flow in two layers that touch.
#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <memory>
#include <string>
#include <utility>

#include "data/dataset/analytic.h"
#include "engine/picture/extract_scene.h"

namespace isostrata {

inline SceneInterval interval(std::uint32_t id, double lower, double upper, std::string map = "") {
  SceneInterval one;
  one.id = id;
  one.lower = lower;
  one.upper = upper;
  one.color_map = std::move(map);
  return one;
}

class TwoLayers : public ::testing::Test {
 protected:
  std::shared_ptr<const ExtractedScene> extract(const Scene& scene, const std::shared_ptr<const ExtractedScene>& previous = nullptr) {
    return extract_scene(dataset_, scene, previous, Task{});
  }
  Scene scene() const {
    Scene scene;
    scene.array = dataset_->arrays[0].name;
    scene.intervals = {interval(1, 1.0, 1.5), interval(2, 1.5, 2.0)};
    return scene;
  }
  std::shared_ptr<const Dataset> dataset_ = make_analytic("cylinder:12x10x8", {}, Task{});
};

}  // namespace isostrata
