// What there is at each value of a field: how much of it, how steep it is there, how well it holds together.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "data/derived/proxy_grid.h"

namespace isostrata {

/// Values are shares of the proxy's range, shares are of the samples that have a value. Made in one pass.
class ValueCurves {
 public:
  static constexpr int kBins = 256;
  using Curve = std::array<double, kBins>;

  explicit ValueCurves(const ProxyGrid& proxy);
  /// Of the field turned over: 1 - f.
  ValueCurves mirrored() const;

  static double middle(int bin) { return (bin + 0.5) / kBins; }
  static int bin_of(double t) { return std::clamp(static_cast<int>(t * kBins), 0, kBins - 1); }

  /// The share of the samples at or above t.
  double share_above(double t) const;
  /// The value that `share` of the samples lie above.
  double value_above(double share) const;

  /// [kBins] share of the samples in each bin.
  const Curve& histogram() const { return histogram_; }
  /// Gradient-weighted: in proportion to the area of the isosurface. Smoothed, as the next one.
  const Curve& area() const { return area_; }
  /// Mean gradient on the isosurface: sum |grad|^2 / sum |grad|.
  const Curve& strength() const { return strength_; }
  double area_at(double t) const { return at(area_, t); }
  double strength_at(double t) const { return at(strength_, t); }
  /// Of the pairs of neighbours of which one end lies in {f >= t} (high) or {f <= t}: the share that has both ends there. 1:
  /// large smooth bodies; noise: about the share of the samples. 0 if there are too few to tell.
  double coherence(double t, bool high) const { return at(high ? coherent_high_ : coherent_low_, t); }

  /// The same of the samples at the domain's end alone.
  const std::vector<float>& rim() const { return rim_; }  // sorted
  double share_of_rim(double from, double to) const;
  double rim_value(double quantile) const;

  static double at(const Curve& curve, double t);

 private:
  ValueCurves() = default;
  static constexpr int kSteps = 1 << 16;
  Curve histogram_{}, area_{}, strength_{}, coherent_high_{}, coherent_low_{};
  std::vector<std::int64_t> below_;  // [kSteps + 1] samples in all steps below
  std::vector<float> rim_;
};

/// A Gaussian of two bins.
ValueCurves::Curve smoothed(const ValueCurves::Curve& curve);

/// Bins at which the curve is higher than on both sides and falls by at least `prominence` before it rises higher again.
std::vector<int> peaks(const ValueCurves::Curve& curve, double prominence);

}  // namespace isostrata
