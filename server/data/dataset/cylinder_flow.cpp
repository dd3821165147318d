#include "data/dataset/cylinder_flow.h"

#include <cmath>
#include <memory>
#include <numbers>
#include <vector>

#include "base/parallel.h"

namespace isostrata {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kSpan = 8;  // lengths in mean radii, speeds in free-stream speeds
constexpr double kFarRadius = 10;
constexpr double kMach = 0.15, kGamma = 1.4;
constexpr double kSpacing = 4.3;    // between vortices of one row
constexpr double kHalfWidth = 0.6;  // of the street: half the rows' distance, 0.281 * spacing for von Karman's stable street
constexpr double kDrift = 0.85;     // the vortices' speed
constexpr double kCirculation = 3.0;

double radius_at(double z) { return 1.25 - 0.5 * z / kSpan; }

/// One vortex of the street, growing as it travels.
struct Vortex {
  double x, y, circulation, core;
};

/// Shedding advances by time and, because thinner parts shed faster, by position along the span.
std::vector<Vortex> street(double z, double time) {
  const double a = radius_at(z);
  const double phase = time * kDrift / kSpacing + 0.35 * (z / kSpan - 0.5) / a;
  std::vector<Vortex> vortices;
  for (int row = 0; row < 2; ++row)
    for (int n = 0; n < 5; ++n) {
      const double cycles = n + (phase + 0.5 * row) - std::floor(phase + 0.5 * row);
      const double x = a + cycles * kSpacing * a;
      const double formed = 1 - std::exp(-cycles * 4);  // rolled up within the first quarter of a period
      vortices.push_back({x, (row == 0 ? 1 : -1) * kHalfWidth * a * (1 + 0.15 * cycles),
                          (row == 0 ? -1 : 1) * kCirculation * a * formed, a * (0.35 + 0.12 * cycles)});
    }
  return vortices;
}

struct Flow {
  double density;
  Vec3d momentum;
  double energy;
};

Flow flow_at(double r, double theta, double z, const std::vector<Vortex>& vortices) {
  const double a = radius_at(z), ratio = a * a / (r * r);
  const double x = r * std::cos(theta), y = r * std::sin(theta);
  const double radial = (1 - ratio) * std::cos(theta), around = -(1 + ratio) * std::sin(theta);
  Vec3d u{radial * std::cos(theta) - around * std::sin(theta), radial * std::sin(theta) + around * std::cos(theta), 0};
  double pressure_drop = 0;
  for (const Vortex& vortex : vortices) {
    const double dx = x - vortex.x, dy = y - vortex.y, d2 = dx * dx + dy * dy, core2 = vortex.core * vortex.core;
    // Lamb-Oseen: azimuthal speed G / (2 pi d) (1 - exp(-d^2 / core^2)), written so that d = 0 needs no case of its own.
    const double s = d2 / core2;
    const double swirl = vortex.circulation / (2 * kPi * core2) * (s > 1e-9 ? -std::expm1(-s) / s : 1.0);
    u.x -= swirl * dy;
    u.y += swirl * dx;
    const double speed_at_core = vortex.circulation / (2 * kPi * vortex.core);
    pressure_drop +=
        speed_at_core * speed_at_core * std::exp(-s);  // a vortex is a low of pressure, which Bernoulli alone would miss
  }
  const double layer = 1 - std::exp(-(r - a) / (0.12 * a));  // no slip at the surface
  u = u * layer;
  u.z = 0.08 * layer * std::exp(-(r - a) / (2 * a)) * std::cos(theta / 2) *
        std::cos(theta / 2);  // the taper drives some flow along the span

  const double m2 = kMach * kMach;
  const double ideal = dot(u, u) / std::max(layer * layer, 1e-3);  // across the layer pressure is that of the flow outside it
  const double enthalpy = 1 + 0.5 * (kGamma - 1) * m2 * (1 - std::min(ideal, 6.0) - pressure_drop);
  const double density = std::pow(enthalpy, 1 / (kGamma - 1));
  const double pressure = std::pow(density, kGamma) / (kGamma * m2);
  return {density, u * density, pressure / (kGamma - 1) + 0.5 * density * dot(u, u)};
}

struct Storage {
  std::vector<Vec3f> points;
  std::vector<float> values[6];
};

}  // namespace

std::uint64_t cylinder_bytes(const CylinderSize& size) {
  return static_cast<std::uint64_t>(size.around * size.outward * size.span) * (sizeof(Vec3f) + 6 * sizeof(float));
}

void fill_cylinder(Dataset& dataset, const CylinderSize& size, std::int64_t step, const Task& task) {
  const auto storage = std::make_shared<Storage>();
  const auto count = static_cast<std::size_t>(size.around * size.outward * size.span);
  storage->points.resize(count);
  for (auto& values : storage->values) values.resize(count);

  const double period = kSpacing / kDrift, time_step = period / 20;
  dataset.times.clear();
  for (std::int64_t s = 0; s < size.steps; ++s) dataset.times.push_back(static_cast<double>(s) * time_step);
  const double time = static_cast<double>(step) * time_step;

  parallel_for(size.span, 1, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t k = begin; k < end; ++k) {
      const double z = kSpan * static_cast<double>(k) / static_cast<double>(size.span - 1);
      const double a = radius_at(z);
      const auto vortices = street(z, time);
      for (std::int64_t j = 0; j < size.outward; ++j) {
        task.check();
        // Geometric stretching: cells keep their proportions.
        const double r = a * std::pow(kFarRadius / a, static_cast<double>(j) / static_cast<double>(size.outward - 1));
        for (std::int64_t i = 0; i < size.around; ++i) {
          const bool seam = i == size.around - 1;
          const double theta = seam ? 0.0 : 2 * kPi * static_cast<double>(i) / static_cast<double>(size.around - 1);
          const auto id = static_cast<std::size_t>(i + size.around * (j + size.outward * k));
          storage->points[id] = {static_cast<float>(r * std::cos(theta)), static_cast<float>(r * std::sin(theta)),
                                 static_cast<float>(z)};
          const Flow flow = flow_at(r, theta, z, vortices);
          storage->values[0][id] = static_cast<float>(flow.density);
          storage->values[1][id] = static_cast<float>(length(flow.momentum));
          for (int axis = 0; axis < 3; ++axis) storage->values[2 + axis][id] = static_cast<float>(flow.momentum[axis]);
          storage->values[5][id] = static_cast<float>(flow.energy);
        }
      }
    }
  });

  dataset.grid.shape = CurvilinearGrid{{size.around, size.outward, size.span}, std::span<const Vec3f>(storage->points)};
  dataset.grid.storage = storage;
  const char* const names[6] = {"Density", "Momentum", "Momentum_x", "Momentum_y", "Momentum_z", "Energy"};
  const char* const components[6] = {"", "magnitude", "x", "y", "z", ""};
  for (int a = 0; a < 6; ++a) {
    PointArray array;
    array.name = names[a];
    array.component = components[a];
    array.components = array.component.empty() ? 1 : 3;
    array.values = std::span<const float>(storage->values[a]);
    array.storage = storage;
    dataset.arrays.push_back(std::move(array));
  }
}

}  // namespace isostrata
