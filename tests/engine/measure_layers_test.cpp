// Layers that are drawn from bricks are measured within --max-memory.
#include <gtest/gtest.h>

#include "engine/engine/engine.h"
#include "engine/heard_events.h"
#include "engine/picture/without_mesh.h"

namespace isostrata {
namespace {

class MeasureLayers : public ::testing::Test, protected HeardEvents {
 protected:
  /// Nearly all of 16 million cells, as 80 million tetrahedra: some 2 GB as a mesh.
  LayersMeasured measured(std::uint64_t max_memory) {
    EngineOptions options;
    options.catalogue = Catalogue::from_sources({"torus:256"});
    options.store.max_bytes = max_memory;
    options.renderer_choice = {"native", "native"};
    Engine engine(std::move(options), [this](EngineEvent event) { note(std::move(event)); });
    const Scene of = scene(++revision_, 1.2, "torus-256");
    engine.post(SceneUpdate{1, of});
    engine.post(frame(1, ++request_, true));
    tetrahedra_ = frame_of(request_).tetrahedra;
    engine.post(MeasureRequest{1, ++request_, of});
    return wait_for<LayersMeasured>([&](const LayersMeasured& r) { return r.request == request_; });
  }

  std::uint64_t revision_ = 0;
  RequestId request_ = 0;
  std::int64_t tetrahedra_ = 0;
};

TEST_F(MeasureLayers, WhatWouldNotFitIsToldByTheBricksWithoutAnEstimate) {
  const LayersMeasured bounded = measured(600 << 20), free = measured(std::uint64_t{16} << 30);
  EXPECT_GT(tetrahedra_, kLeastInBricksOfFrames) << "not drawn from bricks: the test shows nothing";
  ASSERT_EQ(bounded.intervals.size(), 1u);
  ASSERT_EQ(free.intervals.size(), 1u);
  EXPECT_FALSE(bounded.intervals[0].volume_error);
  EXPECT_TRUE(free.intervals[0].volume_error);
  EXPECT_NEAR(bounded.intervals[0].volume, free.intervals[0].volume, 1e-5 * free.intervals[0].volume);
  EXPECT_EQ(bounded.intervals[0].tetrahedra, free.intervals[0].tetrahedra);
}

}  // namespace
}  // namespace isostrata
