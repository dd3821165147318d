#include "data/dataset/implicit_flow.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "data/dataset/analytic.h"

namespace isostrata {
namespace {

constexpr double kSphereX = -0.25, kSphereRadius = 0.3;

/// Stokes' stream function: constant along streamlines, whatever the swirl.
double stream_function(Vec3d p) {
  const double r2 = p.y * p.y + p.z * p.z, distance = std::hypot(p.x - kSphereX, std::sqrt(r2));
  return r2 / 2 * (1 - std::pow(kSphereRadius / distance, 3));
}

/// Points outside the sphere, some close to it, none in the thin wake where streamlines that touched it are.
std::vector<Vec3d> points(unsigned seed, int count) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> within(-1, 1);
  std::vector<Vec3d> out;
  while (static_cast<int>(out.size()) < count) {
    const Vec3d p{within(random), within(random), within(random)};
    if (length(p - Vec3d{kSphereX, 0, 0}) > kSphereRadius && stream_function(p) > 1e-3) out.push_back(p);
  }
  return out;
}

/// Follows the flow forwards by many short steps of the midpoint rule: not the method under test.
Vec3d carried(Vec3d p, double time) {
  constexpr int kSteps = 4000;
  for (int i = 0; i < kSteps; ++i) {
    const Vec3d half = p + implicit_flow_velocity(p) * (time / kSteps / 2);
    p = p + implicit_flow_velocity(half) * (time / kSteps);
  }
  return p;
}

TEST(ImplicitFlow, HasNoDivergenceAndDoesNotCrossTheSphere) {
  constexpr double h = 1e-5;
  for (const Vec3d p : points(1, 200)) {
    const auto slope = [&](Vec3d e, int axis) {
      return (implicit_flow_velocity(p + e * h)[axis] - implicit_flow_velocity(p - e * h)[axis]) / (2 * h);
    };
    EXPECT_NEAR(slope({1, 0, 0}, 0) + slope({0, 1, 0}, 1) + slope({0, 0, 1}, 2), 0, 1e-6);
    EXPECT_GT(implicit_flow_velocity(p).x, 0) << "the fluid always goes on";
    const Vec3d normal = normalized(p - Vec3d{kSphereX, 0, 0}), surface = Vec3d{kSphereX, 0, 0} + normal * kSphereRadius;
    EXPECT_NEAR(dot(implicit_flow_velocity(surface), normal), 0, 1e-12);
  }
}

TEST(ImplicitFlow, TheStreamFunctionAtTheInletIsThatOfThePoint) {
  for (const Vec3d p : points(2, 300)) {
    const InletCrossing crossing = trace_to_inlet(p);
    ASSERT_TRUE(crossing.found);
    EXPECT_NEAR(stream_function({-1, crossing.y, crossing.z}), stream_function(p), 1e-6) << p.x << " " << p.y << " " << p.z;
  }
}

TEST(ImplicitFlow, WhatComesInThereArrivesAfterThatTime) {
  for (const Vec3d p : points(3, 100)) {
    const InletCrossing crossing = trace_to_inlet(p);
    ASSERT_TRUE(crossing.found);
    const Vec3d arrived = carried({-1, crossing.y, crossing.z}, crossing.time);
    EXPECT_NEAR(length(arrived - p), 0, 2e-4) << p.x << " " << p.y << " " << p.z;
  }
}

TEST(ImplicitFlow, PlacesAreConstantAlongStreamlinesAndTimeGrowsByDt) {
  for (const Vec3d p : points(4, 200)) {
    const double dt = 0.113;  // no multiple of the step
    const InletCrossing before = trace_to_inlet(p), after = trace_to_inlet(carried(p, dt));
    EXPECT_NEAR(after.y, before.y, 1e-4);
    EXPECT_NEAR(after.z, before.z, 1e-4);
    EXPECT_NEAR(after.time, before.time + dt, 1e-4);
  }
}

TEST(ImplicitFlow, WhatIsInTheSphereOrNeverArrivedHasNoValue) {
  EXPECT_FALSE(trace_to_inlet({kSphereX, 0.1, 0.1}).found);
  EXPECT_FALSE(trace_to_inlet({0.6, 0, 0}).found) << "behind the stagnation point";
  EXPECT_TRUE(trace_to_inlet({-0.9, 0, 0}).found) << "before it";
  const InletCrossing inlet = trace_to_inlet({-1, 0.5, -0.25});
  EXPECT_TRUE(inlet.found);
  EXPECT_EQ(inlet.time, 0);
  EXPECT_EQ(inlet.y, 0.5);
  EXPECT_EQ(inlet.z, -0.25);
}

TEST(ImplicitFlow, ArraysSayWhatTheTracesSay) {
  const auto data = make_analytic("implicit-flow:9", {}, Task());
  EXPECT_EQ(data->grid.point_count(), 729);
  int without = 0;
  for (std::int64_t id = 0; id < data->grid.point_count(); ++id) {
    const auto i = static_cast<std::size_t>(id);
    const InletCrossing crossing = trace_to_inlet(data->grid.point(id));
    const double implicit = data->array("implicit").at(i), time = data->array("advection_time").at(i),
                 streamline = data->array("streamline").at(i);
    EXPECT_EQ(std::isnan(implicit), !crossing.found);
    EXPECT_EQ(std::isnan(time), !crossing.found);
    EXPECT_EQ(std::isnan(streamline), !crossing.found);
    without += !crossing.found;
    if (!crossing.found) continue;
    EXPECT_FLOAT_EQ(static_cast<float>(time), static_cast<float>(crossing.time));
    EXPECT_NEAR(implicit * (1 - 2 * streamline), crossing.z - 0.32, 1e-5);
    EXPECT_NEAR(implicit, std::hypot(crossing.y, crossing.z - 0.32), 1e-6);
  }
  EXPECT_GT(without, 4) << "the sphere and the axis behind it";
  EXPECT_LT(without, 40);
  EXPECT_EQ(data->array("advection_time").lower, 0);
}

}  // namespace
}  // namespace isostrata
