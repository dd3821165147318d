#include "data/dataset/implicit_flow.h"

#include <cmath>
#include <limits>
#include <memory>

#include "base/parallel.h"

namespace isostrata {
namespace {

constexpr double kRadius = 0.3, kSphereX = -0.25;  // the obstacle
constexpr double kTurn = 3;                        // radians per unit of length in the undisturbed stream
constexpr double kInletX = -1;
constexpr double kSeedZ = 0.32;

/// One step of time h by the classical Runge-Kutta method.
Vec3d step(Vec3d p, double h) {
  const Vec3d k1 = implicit_flow_velocity(p);
  const Vec3d k2 = implicit_flow_velocity(p + k1 * (h / 2));
  const Vec3d k3 = implicit_flow_velocity(p + k2 * (h / 2));
  const Vec3d k4 = implicit_flow_velocity(p + k3 * h);
  return p + (k1 + (k2 + k3) * 2.0 + k4) * (h / 6);
}

double from_sphere(Vec3d p) { return length(p - Vec3d{kSphereX, 0, 0}); }

struct FlowStorage {
  std::vector<float> implicit, time, streamline;
};

}  // namespace

Vec3d implicit_flow_velocity(Vec3d p) {
  const double x = p.x - kSphereX, r2 = p.y * p.y + p.z * p.z, distance2 = x * x + r2;
  const double ratio = kRadius * kRadius / distance2, cube = ratio * std::sqrt(ratio);  // (a/R)^3
  // u_x = 1/r d(psi)/dr, u_r = -1/r d(psi)/dx; u_phi = 2 kTurn psi / r, so that u_phi = kTurn r far away, all by the speed below.
  const double along = 1 - cube * (1 - 1.5 * r2 / distance2);
  const double outwards = -1.5 * cube * x / distance2;  // by r
  const double around = kTurn * (1 - cube);             // by r
  const double psi = r2 / 2 * (1 - cube), speed = 0.4 + 0.6 / (1 + psi / 0.06);
  return Vec3d{along, outwards * p.y - around * p.z, outwards * p.z + around * p.y} * speed;
}

InletCrossing trace_to_inlet(Vec3d p) {
  InletCrossing out;
  if (from_sphere(p) < kRadius) return out;
  while (p.x > kInletX) {
    if (out.time >= kFlowLongest) return out;
    const Vec3d next = step(p, -kFlowStep);
    if (next.x > kInletX) {
      p = next;
      out.time += kFlowStep;
      continue;
    }
    // The step that just reaches the plane, by Newton's method: x falls by the speed there for each unit of time.
    double h = kFlowStep * (p.x - kInletX) / (p.x - next.x);
    Vec3d at = next;
    for (int i = 0; i < 4; ++i) {
      at = step(p, -h);
      h += (at.x - kInletX) / implicit_flow_velocity(at).x;
    }
    p = step(p, -h);
    out.time += h;
    break;
  }
  out.found = true;
  out.y = p.y;
  out.z = p.z;
  return out;
}

std::uint64_t implicit_flow_bytes(std::int64_t n) { return static_cast<std::uint64_t>(n * n * n) * 3 * sizeof(float); }

void fill_implicit_flow(Dataset& dataset, std::int64_t n, const Task& task) {
  UniformGrid grid;
  const double spacing = 2.0 / static_cast<double>(n - 1);
  grid.dims = {n, n, n};
  grid.origin = {-1, -1, -1};
  grid.spacing = {spacing, spacing, spacing};
  dataset.grid.shape = grid;

  const auto storage = std::make_shared<FlowStorage>();
  for (auto* values : {&storage->implicit, &storage->time, &storage->streamline})
    values->resize(static_cast<std::size_t>(n * n * n));
  const auto at = [n](std::int64_t i) { return static_cast<double>(2 * i - (n - 1)) / static_cast<double>(n - 1); };
  parallel_for(n * n, 1, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t row = begin; row < end; ++row) {
      task.check();
      for (std::int64_t i = 0; i < n; ++i) {
        const auto id = static_cast<std::size_t>(row * n + i);
        const InletCrossing crossing = trace_to_inlet({at(i), at(row % n), at(row / n)});
        constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
        const double z = crossing.z - kSeedZ;
        storage->implicit[id] = crossing.found ? static_cast<float>(std::hypot(crossing.y, z)) : kNone;
        storage->time[id] = crossing.found ? static_cast<float>(crossing.time) : kNone;
        // 0/0 on the seed itself.
        storage->streamline[id] = crossing.found ? static_cast<float>(0.5 - 0.5 * z / std::hypot(crossing.y, z)) : kNone;
      }
    }
  });
  const auto add = [&](const char* name, const std::vector<float>& values) {
    PointArray array;
    array.name = name;
    array.values = std::span<const float>(values);
    array.storage = storage;
    dataset.arrays.push_back(std::move(array));
  };
  add("implicit", storage->implicit);
  add("advection_time", storage->time);
  add("streamline", storage->streamline);
}

}  // namespace isostrata
