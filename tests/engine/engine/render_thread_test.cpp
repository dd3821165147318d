#include "engine/engine/render_thread.h"

#include <gtest/gtest.h>

namespace isostrata {
namespace {

TEST(DeviceFailures, ThreeInARowAreTooMany) {
  DeviceFailures failures;
  EXPECT_FALSE(failures.note("lost"));
  EXPECT_FALSE(failures.note("lost"));
  EXPECT_FALSE(failures.note(std::nullopt)) << "a frame was drawn";
  EXPECT_FALSE(failures.note("lost"));
  EXPECT_FALSE(failures.note("lost"));
  EXPECT_TRUE(failures.note("lost for good"));
  EXPECT_EQ(failures.instead_of("GPU 7"), " in place of GPU 7, which failed 3 frames in a row, the last with: lost for good");
  failures.forget();
  EXPECT_FALSE(failures.note("lost"));
}

TEST(RenderThread, SaysWhyItHasNoRendererAndEnds) {
  RenderThread::Ports ports;  // of which nothing is asked
  const auto make = []() -> std::unique_ptr<Renderer> { throw Error(ErrorCode::unavailable, "no device"); };
  EXPECT_THROW(RenderThread(make, make, nullptr, ports), Error);
}

}  // namespace
}  // namespace isostrata
