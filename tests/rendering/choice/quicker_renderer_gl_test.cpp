#include "rendering/choice/quicker_renderer.h"

#include <gtest/gtest.h>

#include "data/dataset/analytic.h"
#include "extraction/intervals/extract_intervals.h"
#include "rendering/choice/device_or_native.h"
#include "rendering/choice/frame_judge.h"
#include "rendering/compute/compute_renderer.h"
#include "support/pictures.h"

namespace isostrata {
namespace {

using namespace testing;

constexpr double kShort = FrameJudge::kLongMs / 2, kLong = 2 * FrameJudge::kLongMs;

TEST(FrameJudge, WhatIsDrawnSoonIsNotTried) {
  FrameJudge judge;
  const auto mesh = std::make_shared<const IntervalMesh>();
  judge.took(mesh, false, kLong);  // the first frame sends the mesh
  for (int i = 0; i < 5; ++i) {
    EXPECT_FALSE(judge.other_is_next(mesh));
    judge.took(mesh, false, kShort);
  }
}

TEST(FrameJudge, OfTwoTheQuickerDrawsOnAfterTwoFramesOfTheOther) {
  for (const bool other_is_quicker : {true, false}) {
    FrameJudge judge;
    const auto mesh = std::make_shared<const IntervalMesh>(), another = std::make_shared<const IntervalMesh>();
    for (int i = 0; i < 2; ++i) judge.took(mesh, false, kLong);
    for (const double ms : {10 * kLong, other_is_quicker ? kShort : 2 * kLong}) {
      EXPECT_TRUE(judge.other_is_next(mesh));
      judge.took(mesh, true, ms);
    }
    EXPECT_EQ(judge.other_is_next(mesh), other_is_quicker);
    EXPECT_FALSE(judge.other_is_next(another)) << "each mesh for itself";
  }
}

TEST(FrameJudge, AMeshThatIsGoneIsForgotten) {
  FrameJudge judge;
  auto mesh = std::make_shared<const IntervalMesh>();
  for (int i = 0; i < 2; ++i) judge.took(mesh, false, kLong);
  EXPECT_TRUE(judge.other_is_next(mesh));
  mesh = std::make_shared<const IntervalMesh>();
  EXPECT_FALSE(judge.other_is_next(mesh));
}

TEST(QuickerRenderer, ConstantColoursAreTheCpusAndRunningOnesTheDevicesAtFirst) {
  const auto renderer = make_quicker_renderer(make_device_or_native(make_compute_renderer(open_context(test_device()), test_device())));
  const auto dataset = make_analytic("torus:12", {}, Task{});
  ExtractOptions options;
  options.values = options.facets = true;
  IntervalMesh mesh = extract_intervals(dataset->grid, dataset->arrays[0], {{{0.1, 0.3}}}, options, Task{});
  const auto values = std::make_shared<const std::vector<float>>(mesh.values.begin(), mesh.values.end());
  DrawInput input = input_of(std::move(mesh), 0.5);
  input.grid = &dataset->grid;
  input.width = 32;
  input.height = 24;
  EXPECT_EQ(renderer->draw(input).facts.renderer, "native");
  input.color_values = values;
  input.styles[0].color_map = "viridis";
  input.styles[0].color_lower = 0.1;
  input.styles[0].color_upper = 0.3;
  EXPECT_EQ(renderer->draw(input).facts.renderer, "compute");
  EXPECT_TRUE(renderer->cuts_intervals());
  EXPECT_TRUE(renderer->draws_bricks());
  EXPECT_TRUE(renderer->extracts());
}

}  // namespace
}  // namespace isostrata
