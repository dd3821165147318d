#include "data/derived/value_curves.h"

#include <algorithm>
#include <cmath>

namespace isostrata {

ValueCurves::ValueCurves(const ProxyGrid& proxy) : below_(kSteps + 1, 0) {
  std::array<std::int64_t, kBins> count{};
  std::array<double, kBins> first{}, second{};
  std::array<std::int64_t, kBins> high_pairs{}, low_pairs{}, own_pairs{};
  for (std::size_t s = 0; s < proxy.size(); ++s) {
    const float t = proxy.values[s];
    if (std::isnan(t)) continue;
    const int bin = bin_of(t);
    const auto b = static_cast<std::size_t>(bin);
    ++count[b];
    ++below_[static_cast<std::size_t>(std::min(static_cast<int>(t * kSteps), kSteps - 1)) + 1];
    const double slope = proxy.slopes[s];
    first[b] += slope;
    second[b] += slope * slope;
    for (const auto& side : proxy.beside) {
      const float other = side[s];
      if (std::isnan(other)) continue;
      ++own_pairs[b];
      ++high_pairs[static_cast<std::size_t>(bin_of(std::min(t, other)))];
      ++low_pairs[static_cast<std::size_t>(bin_of(std::max(t, other)))];
    }
    if (proxy.rim[s]) rim_.push_back(t);
  }
  std::sort(rim_.begin(), rim_.end());
  for (std::size_t i = 1; i < below_.size(); ++i) below_[i] += below_[i - 1];

  const double n = static_cast<double>(std::max<std::int64_t>(proxy.count, 1));
  double steepest = 0;
  for (std::size_t b = 0; b < kBins; ++b) {
    histogram_[b] = static_cast<double>(count[b]) / n;
    first[b] /= n;
    second[b] /= n;
    steepest = std::max(steepest, first[b]);
  }
  Curve slopes{}, squares{};
  std::copy(first.begin(), first.end(), slopes.begin());
  std::copy(second.begin(), second.end(), squares.begin());
  area_ = smoothed(slopes);
  squares = smoothed(squares);
  for (std::size_t b = 0; b < kBins; ++b) strength_[b] = squares[b] / std::max(area_[b], 1e-12 * std::max(steepest, 1e-30));

  constexpr std::int64_t kTooFew = 60;
  std::int64_t own = 0, both = 0;
  for (int b = kBins - 1; b >= 0; --b) {
    const auto i = static_cast<std::size_t>(b);
    own += own_pairs[i], both += high_pairs[i];
    coherent_high_[i] = own > kTooFew ? static_cast<double>(both) / static_cast<double>(own) : 0;
  }
  own = both = 0;
  for (std::size_t i = 0; i < kBins; ++i) {
    own += own_pairs[i], both += low_pairs[i];
    coherent_low_[i] = own > kTooFew ? static_cast<double>(both) / static_cast<double>(own) : 0;
  }
}

ValueCurves ValueCurves::mirrored() const {
  ValueCurves over;
  const auto turned = [](const Curve& curve) {
    Curve out{};
    std::reverse_copy(curve.begin(), curve.end(), out.begin());
    return out;
  };
  over.histogram_ = turned(histogram_);
  over.area_ = turned(area_);
  over.strength_ = turned(strength_);
  over.coherent_high_ = turned(coherent_low_);
  over.coherent_low_ = turned(coherent_high_);
  for (auto below = below_.rbegin(); below != below_.rend(); ++below) over.below_.push_back(below_.back() - *below);
  for (auto t = rim_.rbegin(); t != rim_.rend(); ++t) over.rim_.push_back(1 - *t);
  return over;
}

double ValueCurves::share_above(double t) const {
  const auto step = static_cast<std::size_t>(std::clamp(std::ceil(t * kSteps - 1e-6), 0.0, static_cast<double>(kSteps)));
  const std::int64_t all = below_.back();
  return all ? static_cast<double>(all - below_[step]) / static_cast<double>(all) : 0;
}

double ValueCurves::value_above(double share) const {
  const double rank = std::clamp(1 - share, 0.0, 1.0) * static_cast<double>(std::max<std::int64_t>(below_.back() - 1, 0));
  const auto above = std::upper_bound(below_.begin(), below_.end(), static_cast<std::int64_t>(rank));
  return (static_cast<double>(above - below_.begin()) - 0.5) / kSteps;
}

double ValueCurves::share_of_rim(double from, double to) const {
  if (rim_.empty()) return 0;
  const auto low = std::lower_bound(rim_.begin(), rim_.end(), static_cast<float>(from));
  const auto high = std::upper_bound(rim_.begin(), rim_.end(), static_cast<float>(to));
  return high > low ? static_cast<double>(high - low) / static_cast<double>(rim_.size()) : 0;
}

double ValueCurves::rim_value(double quantile) const {
  if (rim_.empty()) return 0;
  return rim_[static_cast<std::size_t>(std::clamp(quantile, 0.0, 1.0) * static_cast<double>(rim_.size() - 1))];
}

double ValueCurves::at(const Curve& curve, double t) {
  const double x = std::clamp(t * kBins - 0.5, 0.0, kBins - 1.0);
  const auto i = static_cast<std::size_t>(x);
  const std::size_t next = std::min<std::size_t>(i + 1, kBins - 1);
  return curve[i] + (curve[next] - curve[i]) * (x - static_cast<double>(i));
}

ValueCurves::Curve smoothed(const ValueCurves::Curve& curve) {
  constexpr int kReach = 8;
  std::array<double, 2 * kReach + 1> weights{};
  double sum = 0;
  for (int i = -kReach; i <= kReach; ++i) sum += weights[static_cast<std::size_t>(i + kReach)] = std::exp(-i * i / 8.0);
  ValueCurves::Curve out{};
  for (int b = 0; b < ValueCurves::kBins; ++b)
    for (int i = -kReach; i <= kReach; ++i)
      out[static_cast<std::size_t>(b)] += weights[static_cast<std::size_t>(i + kReach)] / sum *
                                          curve[static_cast<std::size_t>(std::clamp(b + i, 0, ValueCurves::kBins - 1))];
  return out;
}

std::vector<int> peaks(const ValueCurves::Curve& curve, double prominence) {
  std::vector<int> found;
  const int n = ValueCurves::kBins;
  const auto y = [&](int i) { return i < 0 || i >= n ? 0.0 : curve[static_cast<std::size_t>(i)]; };
  for (int i = 0; i < n; ++i) {
    int last = i;  // of a plateau
    while (last + 1 < n && y(last + 1) == y(i)) ++last;
    if (y(i) > y(i - 1) && y(i) > y(last + 1)) {
      double left = y(i), right = y(i);
      for (int j = i - 1; j >= -1 && y(j) <= y(i); --j) left = std::min(left, y(j));
      for (int j = last + 1; j <= n && y(j) <= y(i); ++j) right = std::min(right, y(j));
      if (y(i) - std::max(left, right) >= prominence && y(i) > 0) found.push_back((i + last) / 2);
    }
    i = last;
  }
  return found;
}

}  // namespace isostrata
