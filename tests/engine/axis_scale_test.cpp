// Scenes whose axes are drawn longer or shorter.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <variant>

#include "data/dataset/analytic.h"
#include "data/derived/scaled_dataset.h"
#include "engine/engine/engine.h"
#include "engine/heard_events.h"
#include "engine/picture/draw_input.h"
#include "engine/picture/extract_scene.h"
#include "engine/picture/interval_facts.h"
#include "rendering/choice/native_renderer.h"
#include "scene/axis_scale.h"

namespace isostrata {
namespace {

constexpr int kSide = 120;

struct Drawn {
  FloatImage picture;
  std::vector<IntervalFacts> facts;
};

Drawn draw(const std::shared_ptr<const Dataset>& dataset, const Scene& scene) {
  ScaledDatasets scaled;
  const auto extracted = extract_scene(scaled.scaled(dataset, scene.axis_scale), scene, nullptr, Task{});
  DrawInput input = draw_input(*extracted, scene, kSide, kSide);
  input.float_image = true;
  return {std::get<FloatImage>(make_native_renderer()->draw(input).image), interval_facts(*extracted, scene, true, Task{})};
}

double largest_difference(const FloatImage& a, const FloatImage& b) {
  double largest = 0;
  for (std::size_t i = 0; i < a.rgba.size(); ++i) largest = std::max(largest, std::abs(static_cast<double>(a.rgba[i]) - b.rgba[i]));
  return largest;
}

Scene two_layers(const Dataset& dataset) {
  Scene scene;
  const PointArray& array = dataset.arrays.front();
  scene.array = array.name;
  const auto at = [&](double t) { return array.lower + t * (array.upper - array.lower); };
  scene.intervals.push_back({1, at(0.1), at(0.3), {1, 0.2f, 0.1f}, "", 0.3, 0, true});
  scene.intervals.push_back({2, at(0.4), at(0.8), {0.1f, 0.4f, 1}, "", 0.6, 0, true});
  return scene;
}

/// Along parallel rays everything is so many times as deep, and so are the lengths over which opacity is meant: the picture stays.
TEST(AxisScale, AlongParallelRaysIsADepthAlone) {
  for (const char* name : {"torus:16", "tets:10"}) {
    const auto dataset = make_analytic(name, {}, Task{});
    Scene scene = two_layers(*dataset);
    scene.unit_distance = 0.1 * dataset->bounds.diagonal();
    scene.clip_planes = {{{1, 0.3, 0}, 0.05}, {{0, -0.5, 1}, -0.4}};
    scene.camera = view_of(dataset->bounds, "+y", 1, true);
    const Drawn plain = draw(dataset, scene);
    Scene longer = scene;
    longer.axis_scale = {1, 40, 1};
    longer.unit_distance *= 40;
    longer.camera = view_of(scaled(dataset->bounds, longer.axis_scale), "+y", 1, true);
    Camera& camera = *longer.camera;  // as large in the picture as before
    camera.at = scaled(scene.camera->at, longer.axis_scale);
    camera.eye = camera.at + (scene.camera->eye - scene.camera->at);
    const Drawn stretched = draw(dataset, longer);
    EXPECT_GT(*std::max_element(plain.picture.rgba.begin(), plain.picture.rgba.end()), 0.1f);
    EXPECT_LT(largest_difference(plain.picture, stretched.picture), 2e-3) << name;
    longer.clip_planes.clear();
    EXPECT_GT(largest_difference(plain.picture, draw(dataset, longer).picture), 0.1) << "the planes cut nothing";
  }
}

TEST(AxisScale, LeavesVolumesAsTheyAre) {
  for (const char* name : {"torus:16", "tets:10"}) {
    const auto dataset = make_analytic(name, {}, Task{});
    Scene scene = two_layers(*dataset);
    const Drawn plain = draw(dataset, scene);
    scene.axis_scale = {0.02, 3, 700};
    const Drawn drawn = draw(dataset, scene);
    ASSERT_EQ(drawn.facts.size(), 2u);
    for (std::size_t i = 0; i < 2; ++i) {
      EXPECT_EQ(drawn.facts[i].tetrahedra, plain.facts[i].tetrahedra);
      EXPECT_NEAR(drawn.facts[i].volume, plain.facts[i].volume, 1e-5 * plain.facts[i].volume);
      EXPECT_NEAR(drawn.facts[i].volume_error.value_or(-1), plain.facts[i].volume_error.value_or(-2), 1e-4 * plain.facts[i].volume);
    }
  }
}

class ScaledFrames : public ::testing::Test, protected HeardEvents {
 protected:
  ScaledFrames() {
    EngineOptions options;
    options.catalogue = Catalogue::from_sources({"torus:32"});
    options.renderer_choice = {"native", "native"};
    engine_ = std::make_unique<Engine>(std::move(options), [this](EngineEvent event) { note(std::move(event)); });
  }
  FrameReady shown(Vec3d axis_scale) {
    Scene of = scene(++revision_, 1.2, "torus-32");
    of.axis_scale = axis_scale;
    engine_->post(SceneUpdate{1, of});
    engine_->post(frame(1, ++request_, true));
    return frame_of(request_);
  }
  LayersMeasured measured(Vec3d axis_scale) {
    Scene of = scene(revision_, 1.2, "torus-32");
    of.axis_scale = axis_scale;
    engine_->post(MeasureRequest{1, ++request_, of});
    return wait_for<LayersMeasured>([&](const LayersMeasured& r) { return r.request == request_; });
  }

  std::uint64_t revision_ = 0;
  RequestId request_ = 0;
  std::unique_ptr<Engine> engine_;
};

TEST_F(ScaledFrames, AreOtherPicturesOfTheSameVolumesAndComeBack) {
  const FrameReady plain = shown(kUnscaled);
  const double volume = measured(kUnscaled).intervals.at(0).volume;
  const FrameReady longer = shown({1, 1, 3});
  EXPECT_NE(*longer.bytes, *plain.bytes);
  EXPECT_EQ(longer.tetrahedra, plain.tetrahedra);
  EXPECT_NEAR(measured({1, 1, 3}).intervals.at(0).volume, volume, 1e-5 * volume);
  EXPECT_EQ(*shown(kUnscaled).bytes, *plain.bytes);
  EXPECT_EQ(*shown({1, 1, 3}).bytes, *longer.bytes);
}

}  // namespace
}  // namespace isostrata
