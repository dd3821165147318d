#include "engine/picture/line_values.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "engine/picture/layer_request.h"
#include "engine/picture/ray_layers.h"
#include "engine/picture/ray_stretch.h"

namespace isostrata {
namespace {

/// A straight piece of the curve.
struct Piece {
  double from = 0, to = 0;
  double first = 0, last = 0;  // the values there
  double at(double distance) const { return first + (last - first) * ((distance - from) / (to - from)); }
};

std::vector<Piece> pieces_of(const RayLayers& along, const ViewRay& ray, const std::string& array) {
  std::vector<Piece> pieces;
  for_each_stretch(along.layers().mesh, ray, [&](std::size_t item, std::size_t, const RayStretch& of) {
    if (of.leave <= of.enter) return;
    const auto corners = std::span(of.points).first(of.corners);
    const auto first = along.value(array, item, corners, of.weights(of.enter)), last = along.value(array, item, corners, of.weights(of.leave));
    if (first && last) pieces.push_back({of.enter, of.leave, *first, *last});
  });
  std::sort(pieces.begin(), pieces.end(), [](const Piece& a, const Piece& b) { return a.from != b.from ? a.from < b.from : a.to > b.to; });
  return pieces;
}

/// Neighbours overlap by a hair, and those that share a face on which the line lies by all of it: what was reached is not said again.
void join(const std::vector<Piece>& pieces, double length, CurveFacts& curve) {
  const double hair = 1e-7 * length;
  const auto add = [&](double at, double value) {
    curve.at.push_back(at);
    curve.values.push_back(value);
  };
  double reached = 0;
  for (const Piece& piece : pieces) {
    const double begin = std::max(piece.from, reached);
    if (piece.to - begin <= hair * 1e-3 && !curve.at.empty()) continue;
    const double value = piece.at(begin);
    if (!curve.at.empty() && begin - reached > hair) add(reached, std::numeric_limits<double>::quiet_NaN());
    const double before = curve.at.empty() ? NAN : curve.values.back();
    if (!(std::abs(value - before) <= 1e-6 * (std::abs(value) + std::abs(piece.last - piece.first)))) add(begin, value);
    add(piece.to, piece.last);
    reached = piece.to;
  }
}

/// Of each layer that is shown.
std::vector<ProbedStretch> layers_along(const RayLayers& along, const Scene& scene, const ViewRay& ray) {
  const IntervalMesh& mesh = along.layers().mesh;
  std::map<std::pair<int, std::uint32_t>, std::vector<std::pair<double, double>>> parts;  // by term and interval; those of a transfer function are one
  for_each_stretch(mesh, ray, [&](std::size_t, std::size_t index, const RayStretch& of) {
    const bool interval = index < scene.intervals.size();
    const int term = interval ? -1 : mesh.summaries[index].term;
    if (!(interval ? scene.intervals[index].visible : scene.terms[static_cast<std::size_t>(term)].visible) || of.leave <= of.enter) return;
    parts[{term, interval ? scene.intervals[index].id : 0}].emplace_back(of.enter, of.leave);
  });
  std::vector<ProbedStretch> out;
  const double hair = 1e-7 * (ray.last - ray.first);
  for (auto& [layer, stretches] : parts) {
    std::sort(stretches.begin(), stretches.end());
    const std::size_t first = out.size();
    for (const auto& [from, to] : stretches) {
      if (out.size() > first && from <= out.back().to + hair)
        out.back().to = std::max(out.back().to, to);
      else
        out.push_back({from, to, layer.second, layer.first});
    }
  }
  return out;
}

bool finite(Vec3d p) { return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z); }

}  // namespace

CurveFacts line_values(const StepSource& steps, const Scene& asked, const std::string& array, Vec3d from, Vec3d to, const Task& task) {
  if (!finite(from) || !finite(to) || !std::isfinite(length(to - from)))
    throw Error(ErrorCode::invalid_argument, "an end of the line is not finite; expected two points in the dataset's space");
  if (from == to) throw Error(ErrorCode::invalid_argument, "both ends of the line are the same point; expected two that differ");
  const Scene scene = one_moment(asked);
  ViewRay line{from, normalized(to - from)};
  line.last = length(to - from);
  RayLayers values = whole_field(steps, scene, line, array, task);
  CurveFacts curve;
  curve.array = values.request.array;
  curve.step = values.steps().front()->step;
  curve.time = scene.time;
  values.extract();
  join(pieces_of(values, line, curve.array), line.last, curve);
  thin_curve(curve);
  if (scene.intervals.empty()) return curve;
  RayLayers layers(steps, scene, line, task);
  layers.extract();
  curve.layers = layers_along(layers, scene, line);
  if (curve.layers.size() > kMostCurveSamples) curve.layers.resize(kMostCurveSamples);
  return curve;
}

void thin_curve(CurveFacts& curve) {
  const std::size_t all = curve.at.size();
  if (all <= kMostCurveSamples) return;
  constexpr std::size_t kKept = 6, kStretches = kMostCurveSamples / kKept;
  const double begin = curve.at.front(), wide = (curve.at.back() - begin) / static_cast<double>(kStretches);
  std::vector<double> at, values;
  for (std::size_t i = 0; i < all;) {
    const double stretch = std::floor((curve.at[i] - begin) / wide);
    std::array<std::size_t, kKept> keep;  // first, last, least, greatest, first gap, last gap; `all`: none
    keep.fill(all);
    for (; i < all && std::floor((curve.at[i] - begin) / wide) == stretch; ++i) {
      const double value = curve.values[i];
      const bool gap = std::isnan(value);
      auto& [first, last, least, greatest, first_gap, last_gap] = keep;
      if (gap) {
        if (first_gap == all) first_gap = i;
        last_gap = i;
        continue;
      }
      if (first == all) first = least = greatest = i;
      last = i;
      if (value < curve.values[least]) least = i;
      if (value > curve.values[greatest]) greatest = i;
    }
    std::sort(keep.begin(), keep.end());
    for (std::size_t k = 0; k < kKept; ++k)
      if (keep[k] != all && (k == 0 || keep[k] != keep[k - 1])) {
        at.push_back(curve.at[keep[k]]);
        values.push_back(curve.values[keep[k]]);
      }
  }
  curve.at = std::move(at);
  curve.values = std::move(values);
  curve.thinned = true;
}

}  // namespace isostrata
