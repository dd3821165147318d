// A dataset's array on a small uniform grid: all that the choice of a first picture looks at.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "base/task.h"
#include "base/vec.h"
#include "data/dataset/dataset.h"

namespace isostrata {

/// At most kMostProxySamples samples along the longest side. Lengths are in shares of that side: world = corner + scale * p.
struct ProxyGrid {
  std::array<int, 3> dims{};
  Vec3d corner{};               // world: the first sample
  double scale = 0;             // world length of the longest side of the dataset's box; 0: there is no place to look at
  double neighbour = 0;         // how far the neighbours in `beside` are along the longest side
  Vec3d step{};                 // between samples, never negative; 0 along an axis of one sample
  double lower = 0, upper = 0;  // the values that 0 and 1 stand for; those beyond them, which are few and far, are clamped
  bool logarithmic = false;     // between them values run with their logarithm
  std::vector<float> values;    // [n] in [0, 1]; NaN if there is no cell or no finite value
  std::vector<float> slopes;    // [n] length of the gradient of `values`, per length
  std::array<std::vector<float>, 6>
      beside;                     // [n] the values of the true neighbours at -x, +x, -y, +y, -z, +z; NaN beyond the end
  std::vector<std::uint8_t> rim;  // [n] 1: a sample at the domain's end
  std::int64_t count = 0;         // of the samples that have a value
  double fill = 0;                // their share of the box
  double thickness = 0;           // of the domain, in mean: 2 volume / area, in shares of the diagonal

  std::size_t size() const { return values.size(); }
  bool empty() const { return count == 0; }
  double value_at(double t) const;
  double share_at(double value) const;  // the other way round; not clamped
  Vec3d world(Vec3d p) const { return corner + p * scale; }
  Vec3d place(std::size_t sample) const;  // p of a sample
  Vec3d sides() const;                    // lengths of the box that the samples stand for
  double diagonal() const { return length(sides()); }
};

inline constexpr int kMostProxySamples = 80, kFewestProxySamples = 12;

/// Of a uniform grid every s-th point, with its neighbours in the whole grid, so that slopes and noise are those of the data.
/// Every other grid is sampled inside its cells, closer than the proxy's samples lie, and each proxy sample gets the mean. That
/// mean is made of whole numbers, so the result depends neither on the order of cells nor on threads. Empty if the array has
/// no two finite values or the points no finite box. A point whose value is `missing` counts as one that has none; array.lower and array.upper are then
/// those of the others. O(cells), parallel. Throws cancelled. Any thread.
ProxyGrid make_proxy(const Dataset& dataset, const PointArray& array, const Task& task, std::optional<double> missing = {});

}  // namespace isostrata
