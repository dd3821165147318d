#include "rendering/segments/color_integrals.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace isostrata {
namespace {

using Cubic = std::array<std::array<double, 4>, 3>;  // [channel][power]

/// Through the map at the piece's Chebyshev points.
Cubic fit(const ColorMap& map, int piece, int pieces) {
  std::array<double, 4> x{};
  for (std::size_t k = 0; k < 4; ++k) x[k] = 0.5 - 0.5 * std::cos((2 * static_cast<double>(k) + 1) * std::numbers::pi / 8);
  Cubic cubic{};
  for (std::size_t k = 0; k < 4; ++k) {  // Lagrange's polynomial of point k, multiplied out
    std::array<double, 4> product{1, 0, 0, 0};
    double scale = 1;
    for (std::size_t j = 0; j < 4; ++j) {
      if (j == k) continue;
      for (std::size_t p = 3; p > 0; --p) product[p] = product[p - 1] - x[j] * product[p];
      product[0] *= -x[j];
      scale *= x[k] - x[j];
    }
    const Rgb color = sample(map, static_cast<float>((piece + x[k]) / pieces));
    for (std::size_t c = 0; c < 3; ++c)
      for (std::size_t p = 0; p < 4; ++p) cubic[c][p] += product[p] / scale * static_cast<double>(color[c]);
  }
  return cubic;
}

bool follows(const Cubic& cubic, const ColorMap& map, int piece, int pieces) {
  const int checks = std::max(64, 4 * static_cast<int>(map.rgb.size()) / pieces);
  for (int i = 0; i <= checks; ++i) {
    const double x = static_cast<double>(i) / checks;
    const Rgb color = sample(map, static_cast<float>((piece + x) / pieces));
    for (std::size_t c = 0; c < 3; ++c) {
      const auto& a = cubic[c];
      if (std::abs(a[0] + x * (a[1] + x * (a[2] + x * a[3])) - static_cast<double>(color[c])) > kPieceError) return false;
    }
  }
  return true;
}

/// Of red, green or blue (c) at u: the polynomials of the piece, which go on beyond the map's ends.
double value(const float (&polynomials)[3][5][ColorIntegrals::kMostPieces], std::size_t c, double p, int pieces, bool slope) {
  const int piece = std::clamp(static_cast<int>(std::floor(p)), 0, pieces - 1);
  const double x = p - piece;
  double sum = 0;
  for (std::size_t i = 5; i-- > static_cast<std::size_t>(slope);)
    sum = sum * x + static_cast<double>(polynomials[c][i][piece]) * (slope ? static_cast<double>(i) : 1.0);
  return sum;
}

void tabulate(ColorIntegrals& integrals) {
  const int pieces = static_cast<int>(integrals.pieces);
  for (int i = -ColorIntegrals::kMargin; i <= ColorIntegrals::kSteps + ColorIntegrals::kMargin; ++i) {
    float* const node = integrals.nodes[i + ColorIntegrals::kMargin];
    const double per_step = static_cast<double>(ColorIntegrals::kSteps) / pieces;
    for (std::size_t c = 0; c < 3; ++c)
      node[c] = static_cast<float>(per_step * value(integrals.g0, c, i / per_step, pieces, false));
    node[3] = static_cast<float>(-i);
  }
  for (std::size_t i = 0; i < std::size(integrals.pairs); ++i)
    for (std::size_t c = 0; c < 4; ++c) {
      integrals.pairs[i][2 * c] = integrals.nodes[i][c];
      integrals.pairs[i][2 * c + 1] = integrals.nodes[i + 1][c] - integrals.nodes[i][c];
    }
}

/// By trial, at a fine choice of parts.
float bend_of(const ColorIntegrals& integrals) {
  const int pieces = static_cast<int>(integrals.pieces);
  constexpr int kParts = 64, kInside = 24;
  double most = 0;
  for (int width = 2; width <= kParts; width *= 2)
    for (int first = 0; first + width <= kParts; ++first) {
      const double w = static_cast<double>(width) / kParts, from = static_cast<double>(first) / kParts;
      for (std::size_t c = 0; c < 3; ++c) {
        const auto color = [&](double x) { return value(integrals.g0, c, (from + w * x) * pieces, pieces, true); };
        double moment = 0;
        for (int k = 0; k < kInside; ++k) moment += color((k + 0.5) / kInside) * ((k + 0.5) / kInside - 0.5) / kInside;
        most = std::max(most, std::abs(moment - (color(1) - color(0)) / 12) / w);
      }
    }
  return static_cast<float>(most);
}

std::shared_ptr<const ColorIntegrals> integrate(const ColorMap& map, int pieces) {
  auto out = std::make_shared<ColorIntegrals>();
  out->pieces = static_cast<float>(pieces);
  std::array<double, 3> sum0{}, sum1{};
  for (int k = 0; k < pieces; ++k) {
    const Cubic cubic = fit(map, k, pieces);
    if (!follows(cubic, map, k, pieces)) return nullptr;
    const double from_middle = k - 0.5 * pieces;
    for (std::size_t c = 0; c < 3; ++c) {
      out->g0[c][0][k] = static_cast<float>(sum0[c]);
      out->g1[c][0][k] = static_cast<float>(sum1[c]);
      for (std::size_t p = 0; p < 5; ++p) {
        const auto power = static_cast<double>(p + 1);
        const double a = p < 4 ? cubic[c][p] : 0, below = p > 0 ? cubic[c][p - 1] : 0;
        const double b = from_middle * a + below;
        if (p < 4) out->g0[c][p + 1][k] = static_cast<float>(a / power);
        out->g1[c][p + 1][k] = static_cast<float>(b / power);
        sum0[c] += a / power;
        sum1[c] += b / power;
      }
    }
  }
  tabulate(*out);
  out->bend = bend_of(*out);
  return out;
}

}  // namespace

std::shared_ptr<const ColorIntegrals> make_color_integrals(const ColorMap& map) {
  for (int pieces = ColorIntegrals::kMostPieces; pieces > 0; --pieces)  // fewer: a ramp's corners may then lie between pieces
    if (auto made = integrate(map, pieces)) return made;
  return nullptr;
}

std::shared_ptr<const ColorIntegrals> ColorIntegralMemory::of(const ColorMap& map) {
  constexpr std::size_t kMost = 32;
  const auto found = std::find_if(known_.begin(), known_.end(), [&](const Known& k) { return k.name == map.name; });
  if (found != known_.end()) {
    std::rotate(found, found + 1, known_.end());
    return known_.back().integrals;
  }
  if (known_.size() == kMost) known_.erase(known_.begin());
  known_.push_back({map.name, make_color_integrals(map)});
  return known_.back().integrals;
}

}  // namespace isostrata
