#include "engine/first/choose_camera.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace isostrata {
namespace {

constexpr double kFov = 25, kPart = 0.92;  // of the picture
constexpr std::size_t kMostPoints = 8000;  // of a layer
constexpr int kCells = 48;

struct LayerPoints {
  std::vector<Vec3d> all;     // on the layer's surface
  std::vector<Vec3d> bodies;  // of these, what is not a speck of noise; empty if nearly all of it would be one
  std::vector<Vec3d> some;    // at most kMostPoints, evenly
};

/// Samples in the layer of which a neighbour is not.
LayerPoints surface_points(const ProxyGrid& proxy, const LayerChoice& layer) {
  const std::array<std::size_t, 3> dims{static_cast<std::size_t>(proxy.dims[0]), static_cast<std::size_t>(proxy.dims[1]),
                                        static_cast<std::size_t>(proxy.dims[2])};
  const std::array<std::size_t, 3> jump{1, dims[0], dims[0] * dims[1]};
  const auto inside = [&](std::size_t s) { return proxy.values[s] >= layer.from && proxy.values[s] <= layer.to; };
  LayerPoints points;
  for (std::size_t s = 0; s < proxy.size(); ++s) {
    if (!inside(s)) continue;
    bool surface = false;
    int beside = 0;
    for (std::size_t a = 0; a < 3; ++a) {
      if (dims[a] < 2) continue;
      const std::size_t i = s / jump[a] % dims[a];
      const bool low = i > 0 && inside(s - jump[a]), high = i + 1 < dims[a] && inside(s + jump[a]);
      beside += low + high;
      surface = surface || !low || !high;
    }
    if (!surface) continue;
    points.all.push_back(proxy.place(s));
    if (beside >= 2) points.bodies.push_back(points.all.back());
  }
  if (10 * points.bodies.size() < 9 * points.all.size()) points.bodies.clear();
  const std::size_t n = points.all.size(), some = std::min(n, kMostPoints);
  for (std::size_t i = 0; i < some; ++i) points.some.push_back(points.all[i * n / some]);
  return points;
}

/// The axes of a picture.
struct Frame {
  Vec3d right, up, back;
};
Frame frame_of(Vec3d direction, Vec3d up) {
  const Vec3d back = normalized(direction), right = normalized(cross(up, back));
  return {right, cross(back, right), back};
}

struct Direction {
  Vec3d to_eye;
  int elevation = 0, azimuth = 0;
};

std::vector<Direction> directions(Vec3d up) {
  const Vec3d start = std::abs(up.x) < 0.5 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0};
  const Vec3d x = normalized(start - up * dot(start, up)), y = cross(up, x);
  std::vector<Direction> all;
  for (const int elevation : {25, 40, 60})
    for (int azimuth = 15; azimuth < 360; azimuth += 30) {
      const double e = elevation * std::numbers::pi / 180, a = azimuth * std::numbers::pi / 180;
      all.push_back({std::cos(e) * (std::cos(a) * x + std::sin(a) * y) + std::sin(e) * up, elevation, azimuth});
    }
  return all;
}

/// The axis along which the domain is thin; -1: none.
int thin_axis(const ProxyGrid& proxy) {
  const Vec3d s = proxy.sides();
  const int least = s.x <= s.y && s.x <= s.z ? 0 : s.y <= s.z ? 1 : 2;
  std::array<double, 3> sorted{s.x, s.y, s.z};
  std::sort(sorted.begin(), sorted.end());
  return sorted[0] < 0.2 * sorted[1] ? least : -1;
}

struct Interest {
  double score = -1;
  double depth_of_inner = 0;
};

/// How much a view shows, of all layers together.
double interest(const std::vector<LayerPoints>& layers, Vec3d center, double radius, const Frame& frame) {
  const auto project = [&](Vec3d p) {
    const Vec3d q = p - center;
    return Vec3d{dot(q, frame.right), dot(q, frame.up), dot(q, frame.back)};
  };
  Vec3d low{1e300, 1e300, 1e300}, high = low * -1.0;
  for (const LayerPoints& layer : layers)
    for (const Vec3d& p : layer.some) {
      const Vec3d q = project(p);
      low = {std::min(low.x, q.x), std::min(low.y, q.y), std::min(low.z, q.z)};
      high = {std::max(high.x, q.x), std::max(high.y, q.y), std::max(high.z, q.z)};
    }
  const double width = std::max((high.x - low.x) * 0.75, high.y - low.y) * 1.02 + 1e-30, depth = high.z - low.z + 1e-30;
  double score = 0, first_depth = 0, last_depth = 0;
  std::vector<float> nearest(kCells * kCells);
  bool any = false;
  for (std::size_t i = 0; i < layers.size(); ++i) {
    if (layers[i].some.empty()) continue;
    std::fill(nearest.begin(), nearest.end(), -1.0f);
    double sum = 0;
    for (const Vec3d& p : layers[i].some) {
      const Vec3d q = project(p);
      const int x = std::clamp(static_cast<int>((q.x - low.x) / width * 0.75 * kCells), 0, kCells - 1);
      const int y = std::clamp(static_cast<int>((q.y - low.y) / width * 0.75 * kCells), 0, kCells - 1);
      float& cell = nearest[static_cast<std::size_t>(x * kCells + y)];
      cell = std::max(cell, static_cast<float>((q.z - low.z) / depth));
      sum += q.z;
    }
    std::array<int, 12> bins{};
    int covered = 0;
    for (const float z : nearest)
      if (z >= 0) ++covered, ++bins[static_cast<std::size_t>(std::clamp(static_cast<int>(z * 12), 0, 11))];
    double entropy = 0;
    for (const int count : bins)
      if (count)
        entropy -= static_cast<double>(count) / covered * std::log(static_cast<double>(count) / covered) / std::log(12.0);
    const bool last = i + 1 == layers.size();
    score += std::sqrt(covered / (kCells * kCells * 0.5625)) * (0.5 + 0.5 * entropy) * (last ? 1.5 : 1);
    const double mean = sum / static_cast<double>(layers[i].some.size());
    if (!any) first_depth = mean;
    last_depth = mean;
    any = true;
  }
  return score * (1 + 0.25 * std::clamp((last_depth - first_depth) / std::max(radius, 1e-30), -1.0, 1.0));
}

/// Of many points, those that lie farthest in a few hundred directions.
std::vector<Vec3d> extremes(const std::vector<Vec3d>& points) {
  std::vector<std::size_t> kept;
  constexpr int kDirections = 128;
  for (int i = 0; i < kDirections; ++i) {  // a spiral over the sphere
    const double z = 1 - (2 * i + 1.0) / kDirections, r = std::sqrt(1 - z * z), a = i * std::numbers::pi * (3 - std::sqrt(5.0));
    const Vec3d d{r * std::cos(a), r * std::sin(a), z};
    std::size_t best = 0;
    for (std::size_t p = 1; p < points.size(); ++p)
      if (dot(points[p], d) > dot(points[best], d)) best = p;
    if (std::find(kept.begin(), kept.end(), best) == kept.end()) kept.push_back(best);
  }
  std::vector<Vec3d> out;
  for (const std::size_t p : kept) out.push_back(points[p]);
  return out;
}

/// Corners of the box that a sample stands for.
void add_corners(const ProxyGrid& proxy, Vec3d p, std::vector<Vec3d>& to) {
  for (int c = 0; c < 8; ++c) {
    const Vec3d side{c & 1 ? 0.5 : -0.5, c & 2 ? 0.5 : -0.5, c & 4 ? 0.5 : -0.5};
    to.push_back(proxy.world({p.x + side.x * proxy.step.x, p.y + side.y * proxy.step.y, p.z + side.z * proxy.step.z}));
  }
}

/// Shares of two opposite faces of the box that lie in the layers.
std::array<double, 2> face_shares(const ProxyGrid& proxy, std::size_t axis, double from) {
  const std::array<std::size_t, 3> dims{static_cast<std::size_t>(proxy.dims[0]), static_cast<std::size_t>(proxy.dims[1]),
                                        static_cast<std::size_t>(proxy.dims[2])};
  const std::array<std::size_t, 3> jump{1, dims[0], dims[0] * dims[1]};
  std::array<double, 2> shares{};
  for (std::size_t s = 0; s < proxy.size(); ++s) {
    const std::size_t i = s / jump[axis] % dims[axis];
    if (proxy.values[s] >= from && i == 0) ++shares[0];
    if (proxy.values[s] >= from && i + 1 == dims[axis]) ++shares[1];
  }
  const double face = static_cast<double>(proxy.size() / dims[axis]);
  return {shares[0] / face, shares[1] / face};
}

}  // namespace

UpChoice choose_up(const ProxyGrid& proxy, const LayersChoice& layers, const FieldHints& hints) {
  if (layers.kind == FieldKind::image && hints.whole_numbers && !layers.layers.empty()) {
    double from = 1;
    for (const LayerChoice& layer : layers.layers) from = std::min(from, layer.from);
    if (layers.anatomy) {  // slices are stacked along z; a head's cut through the skull shows more bone than one through the neck
      const auto bone = face_shares(proxy, 2, layers.layers.back().from), all = face_shares(proxy, 2, from);
      if (bone[0] > 0.01 && all[1] > 0.03 && bone[0] > 1.5 * bone[1])
        return {{0, 0, -1}, "more bone is cut at the first slice: it is the upper end"};
      return {{0, 0, 1}, "slices are stacked along z"};
    }
    double most = 0, opposite = 0;
    Vec3d up{0, 0, 1};
    for (std::size_t a = 0; a < 3; ++a) {
      const auto shares = face_shares(proxy, a, from);
      for (const int side : {0, 1}) {
        if (shares[static_cast<std::size_t>(side)] <= most) continue;
        most = shares[static_cast<std::size_t>(side)];
        opposite = shares[static_cast<std::size_t>(1 - side)];
        up = {};
        up[static_cast<int>(a)] = side == 0 ? 1 : -1;
      }
    }
    if (most > 0.03 && opposite < 0.35 * most) return {up, "the object stands on the face that cuts it off"};
  }
  const int thin = thin_axis(proxy);
  if (thin == 2 && layers.kind == FieldKind::sheet) return {{0, 1, 0}, "the domain lies in the plane of x and y"};
  return {{0, 0, 1}, "z, as in most data"};
}

ViewChoice choose_view(const ProxyGrid& proxy, const LayersChoice& layers, const UpChoice& up, bool whole) {
  ViewChoice view;
  view.up = up.up;
  std::vector<LayerPoints> points;
  std::vector<Vec3d> all;
  for (const LayerChoice& layer : layers.layers) {
    points.push_back(surface_points(proxy, layer));
    const std::vector<Vec3d>& of = points.back().bodies.empty() ? points.back().all : points.back().bodies;
    all.insert(all.end(), of.begin(), of.end());
  }
  if (whole || all.empty()) {
    all.clear();
    for (std::size_t s = 0; s < proxy.size(); ++s)
      if (proxy.rim[s]) all.push_back(proxy.place(s));
  }
  for (const Vec3d& p : extremes(all)) add_corners(proxy, p, view.outline);

  Vec3d center;
  std::size_t n = 0;
  for (const LayerPoints& layer : points)
    for (const Vec3d& p : layer.some) center = center + p, ++n;
  if (n > 0) center = center / static_cast<double>(n);
  double radius = 0;
  for (const LayerPoints& layer : points)
    for (const Vec3d& p : layer.some) radius = std::max(radius, length(p - center));

  const int thin = thin_axis(proxy);
  double best = -1;
  Direction chosen;
  if (thin >= 0 &&
      layers.kind == FieldKind::sheet) {  // a little from the side of its broad face, so that it is seen to have a thickness
    const Vec3d s = proxy.sides();
    Vec3d normal{};
    normal[thin] = thin == 2 ? 1 : thin == 1 ? -1 : 1;
    const bool plane = !(s[thin] > 0);
    const Vec3d aside = cross(up.up, normal);
    const Vec3d across = length(aside) > 0.5 ? aside : Vec3d{1, 0, 0};
    const Vec3d above = length(aside) > 0.5 ? up.up : cross(normal, across);
    view.direction = plane ? normal : normalized(normal + across * 0.25 + above * (thin == 2 ? -0.45 : 0.35));
    if (thin == 2 && length(aside) <= 0.5) view.up = above;
    view.reason = plane ? "straight on to the plane" : "from its broad side";
    return view;
  }
  for (const Direction& d : directions(up.up)) {
    const bool along = thin >= 0;
    if (!along && d.elevation > 45) continue;
    if (along && std::abs(d.to_eye[thin]) < 0.75) continue;
    double score = interest(points, center, radius, frame_of(d.to_eye, up.up));
    if (layers.kind == FieldKind::waves)
      score *= d.elevation == 40 ? 1.5 : 1;  // waves are a relief, seen from above
    else if (!along && d.elevation == 25)
      score *= 1.12;
    const double off = std::abs(std::remainder(d.azimuth - 300, 360)) / 180;
    score *= 1 - 0.04 * off;  // ties: from the front, a little from the right
    if (score > best) best = score, chosen = d;
  }
  view.direction = best < 0 ? normalized(Vec3d{0.4, -0.8, 0.45}) : chosen.to_eye;
  view.reason = best < 0    ? "from the front"
                : thin >= 0 ? "from its broad side"
                            : "of 24 views the one that shows the most of the layers";
  return view;
}

Camera camera_on(const ViewChoice& view, double aspect) {
  const Frame frame = frame_of(view.direction, view.up);
  const double up_reach = std::tan(kFov / 2 * std::numbers::pi / 180) * kPart, right_reach = up_reach * std::max(aspect, 1e-3);
  Box3d box;
  for (const Vec3d& p : view.outline) box.include(p);
  Camera camera;
  camera.fov_deg = kFov;
  camera.up = view.up;
  if (view.outline.empty() || !(box.diagonal() > 0)) {
    camera.at = view.outline.empty() ? Vec3d{} : box.center();
    camera.eye = camera.at + frame.back;
    return camera;
  }
  Vec3d center = box.center();
  double distance = 0;
  for (int pass = 0; pass < 12; ++pass) {
    distance = 0;
    for (const Vec3d& p : view.outline) {
      const Vec3d q = p - center;
      const double back = dot(q, frame.back);
      distance =
          std::max({distance, std::abs(dot(q, frame.right)) / right_reach + back, std::abs(dot(q, frame.up)) / up_reach + back});
    }
    double left = 1e300, right = -1e300, low = 1e300, high = -1e300;
    for (const Vec3d& p : view.outline) {
      const Vec3d q = p - center;
      const double away = distance - dot(q, frame.back);
      const double x = dot(q, frame.right) / away, y = dot(q, frame.up) / away;
      left = std::min(left, x), right = std::max(right, x), low = std::min(low, y), high = std::max(high, y);
    }
    if (pass == 11) break;
    center = center + frame.right * ((left + right) / 2 * distance * 0.7) + frame.up * ((low + high) / 2 * distance * 0.7);
  }
  camera.at = center;
  camera.eye = center + frame.back * distance;
  return camera;
}

}  // namespace isostrata
