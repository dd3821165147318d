// Normals along the gradient are made where surfaces are lit by them, and nowhere else.
#include <gtest/gtest.h>

#include "data/dataset/analytic.h"
#include "engine/engine/engine.h"
#include "engine/picture/draw_input.h"
#include "engine/picture/extract_scene.h"
#include "engine/picture/layer_request.h"
#include "rendering/picture/lit_surfaces.h"

namespace isostrata {
namespace {

/// Two intervals and a term that brings something in; each bit of `which` is a choice.
Scene scene_of(unsigned which) {
  const auto bit = [&](unsigned b) { return (which >> b & 1) != 0; };
  Scene scene;
  for (unsigned i = 0; i < 2; ++i) {
    SceneInterval interval;
    interval.id = i + 1;
    interval.lower = 0.2 + 0.3 * i;
    interval.upper = interval.lower + 0.1;
    interval.surface.lower = bit(3 * i);
    interval.surface.domain = bit(3 * i + 1);
    interval.visible = bit(3 * i + 2);
    scene.intervals.push_back(interval);
  }
  if (bit(6)) scene.terms.push_back({{RangeOperator::unite, "distance", {0.8, 0.9}}, {}, "", {}, {}, bit(7)});
  if (bit(8)) scene.mode = SceneMode::cycled;
  return scene;
}

TEST(LitNormals, AreThereWhereverAPictureIsLitAlongTheGradient) {
  const std::shared_ptr<const Dataset> dataset = make_analytic("torus:9", {}, Task{});
  int lit = 0, spared = 0;
  for (unsigned which = 0; which < 1u << 9; ++which) {
    const Scene scene = scene_of(which);
    const auto extracted = extract_scene(dataset, scene, nullptr, Task{});
    const DrawInput input = draw_input(*extracted, scene, 16, 12);
    if (lit_along_gradient(input.styles)) {
      ++lit;
      ASSERT_TRUE(input.normals) << which;
      ASSERT_TRUE(lights_along_gradient(scene)) << which;
    }
    if (draws_surfaces(scene) && !extracted->normals) ++spared;
    EXPECT_EQ(extracted->normals != nullptr, lights_along_gradient(scene)) << which;
  }
  EXPECT_GT(lit, 50);
  EXPECT_GT(spared, 50) << "no pass over the mesh for what nobody sees";
}

TEST(LitNormals, ComeWhenTheSurfaceAtTheDomainsEndGoes) {
  const std::shared_ptr<const Dataset> dataset = make_analytic("torus:9", {}, Task{});
  const Scene with = scene_of(0b000111), without = scene_of(0b000101);
  EXPECT_FALSE(same_extraction(with, without));
  const auto before = extract_scene(dataset, with, nullptr, Task{});
  EXPECT_FALSE(before->normals);
  const auto after = extract_scene(dataset, without, before, Task{});
  EXPECT_TRUE(after->normals);
  EXPECT_EQ(after->mesh, before->mesh) << "the mesh is the same";
}

}  // namespace
}  // namespace isostrata
