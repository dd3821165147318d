#include "rank/picture_of_ranks.h"

#include <malloc.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <map>

#include "base/kept_blocks.h"
#include "base/stopwatch.h"
#include "rendering/picture/pixel_grid.h"

namespace isostrata {
namespace {

constexpr int kFailed = 0, kApproximate = 1, kExact = 2;  // what ranks agree on

void add_planes(const Box3d& region, std::vector<ClipPlane>& planes) {
  for (int axis = 0; axis < 3; ++axis) {
    Vec3d normal{};
    normal[axis] = 1;
    if (std::isfinite(region.lower[axis])) planes.push_back({normal, region.lower[axis]});
    if (std::isfinite(region.upper[axis])) planes.push_back({normal * -1.0, -region.upper[axis]});
  }
}

/// The rectangle around the region on the screen; all of it where the region reaches beside or behind the eye.
std::array<int, 4> covered_by(const Box3d& region, const DrawInput& input) {
  const std::array<int, 4> all{0, 0, input.width, input.height};
  const PixelGrid pixels = pixel_grid(input);
  const Mat4d view = view_from_world(input.camera);
  const double near = 1e-6 * length(input.camera.at - input.camera.eye);
  double left = INFINITY, right = -INFINITY, top = INFINITY, bottom = -INFINITY;
  for (int corner = 0; corner < 8; ++corner) {
    Vec3d p;
    for (int axis = 0; axis < 3; ++axis)
      p[axis] = corner >> axis & 1 ? std::min(region.upper[axis], input.bounds.upper[axis]) : std::max(region.lower[axis], input.bounds.lower[axis]);
    const std::array<double, 4> seen = view * std::array<double, 4>{p.x, p.y, p.z, 1};
    const Vec3d v{seen[0], seen[1], seen[2]};
    if (!input.camera.orthographic && !(v.z < -near)) return all;
    const double scale = input.camera.orthographic ? pixels.per_unit : pixels.focal / -v.z;
    left = std::min(left, pixels.axis_x + v.x * scale);
    right = std::max(right, pixels.axis_x + v.x * scale);
    top = std::min(top, pixels.axis_y - v.y * scale);
    bottom = std::max(bottom, pixels.axis_y - v.y * scale);
  }
  const auto pixel = [](double at, int most) { return static_cast<int>(std::clamp(at, 0.0, static_cast<double>(most))); };
  const int x = pixel(std::floor(left) - 2, input.width), y = pixel(std::floor(top) - 2, input.height);
  const int x_end = pixel(std::ceil(right) + 2, input.width), y_end = pixel(std::ceil(bottom) + 2, input.height);
  if (x_end <= x || y_end <= y) return {0, 0, 1, 1};
  return {x, y, x_end - x, y_end - y};
}

std::vector<int> order_of(const RegionTree& regions, const Camera& camera) {
  std::vector<int> order =
      camera.orthographic ? front_to_back_along(regions, camera.at - camera.eye) : front_to_back(regions, camera.eye);
  if (std::strcmp(ranks_control(), "reversed") == 0) std::reverse(order.begin(), order.end());
  return order;
}

void paint_over(const FloatImage& nearer, FloatImage& picture) {
  for (std::size_t i = 0; i < picture.rgba.size(); i += 4) {
    const float through = 1 - nearer.rgba[i + 3];
    for (std::size_t c = 0; c < 4; ++c) picture.rgba[i + c] = nearer.rgba[i + c] + through * picture.rgba[i + c];
  }
}

/// Mean depths, which are over one another like a colour, as the red of one.
FloatImage depths_as_colors(const FloatImage& picture) {
  FloatImage depths{picture.width, picture.height, picture.rgba, {}};
  for (std::size_t i = 0; i < picture.mean_depth.size(); ++i) {
    depths.rgba[4 * i] = picture.mean_depth[i];
    depths.rgba[4 * i + 1] = depths.rgba[4 * i + 2] = 0;
  }
  return depths;
}

void paint_over(const FloatImage& nearer, std::vector<float>& mean_depth) {
  mean_depth.resize(nearer.rgba.size() / 4);
  for (std::size_t i = 0; i < mean_depth.size(); ++i) mean_depth[i] = nearer.rgba[4 * i] + (1 - nearer.rgba[4 * i + 3]) * mean_depth[i];
}

/// The styles of each picture that is painted over the one before, all others invisible.
std::vector<std::vector<IntervalStyle>> painted_styles(const DrawInput& input) {
  if (input.mode == RenderMode::sorted) return {input.styles};
  std::map<int, std::vector<std::size_t>> by_priority;
  for (std::size_t i = 0; i < input.styles.size(); ++i)
    if (input.styles[i].visible) by_priority[input.styles[i].priority].push_back(i);
  std::vector<std::vector<IntervalStyle>> all;
  for (const auto& [priority, members] : by_priority) {
    all.push_back(input.styles);
    for (IntervalStyle& style : all.back()) style.visible = false;
    for (const std::size_t i : members) all.back()[i].visible = true;
  }
  if (all.empty()) all.push_back(input.styles);
  return all;
}

}  // namespace

const char* ranks_control() {
  const char* control = std::getenv("ISOSTRATA_RANKS_CONTROL");
  return control ? control : "";
}

void give_memory_back() {
  free_kept_blocks();
#ifdef __GLIBC__
  malloc_trim(0);
#endif
}

RankedPicture draw_by_ranks(RankLine& line, Compositor& compositor, Renderer& own, const DrawInput& input, const RegionTree& regions) {
  const Box3d region = region_box(regions, line.rank());
  DrawInput part = input;
  add_planes(region, part.clip_planes);
  part.mode = RenderMode::sorted;
  part.transparent = part.float_image = true;
  part.rounded = false;  // what was added up is rounded
  const bool with_depth = input.float_image && !input.rounded;
  part.mean_depth = input.float_image && input.mean_depth;
  const std::array<int, 4> covered = covered_by(region, input);
  const std::vector<int> order = order_of(regions, input.camera);
  RankedPicture picture;
  std::vector<float> depth;
  double wait_ms = 0, composite_ms = 0;
  FloatImage& painted = compositor.painted;
  painted.rgba.clear();
  std::vector<std::vector<IntervalStyle>> groups = painted_styles(input);
  for (std::vector<IntervalStyle>& styles : groups) {
    part.styles = std::move(styles);
    DrawResult drawn;
    std::exception_ptr failure;
    try {
      drawn = own.draw(part);
    } catch (...) {
      failure = std::current_exception();
    }
    const Stopwatch waiting;
    const int all = line.agree(failure ? kFailed : drawn.facts.order_exact ? kExact : kApproximate);
    if (failure) std::rethrow_exception(failure);
    if (all == kFailed) throw Error(ErrorCode::cancelled, "another rank could not draw its region");
    wait_ms += waiting.elapsed_ms();
    const double order_ms = picture.facts.order_ms + drawn.facts.order_ms, draw_ms = picture.facts.draw_ms + drawn.facts.draw_ms,
                 readback_ms = picture.facts.readback_ms + drawn.facts.readback_ms;
    picture.facts = drawn.facts;
    picture.facts.order_ms = order_ms, picture.facts.draw_ms = draw_ms, picture.facts.readback_ms = readback_ms;
    picture.facts.order_exact = all == kExact;
    FloatImage& own_picture = std::get<FloatImage>(drawn.image);
    if (with_depth) {
      if (depth.empty())
        depth = std::move(own_picture.depth);
      else
        for (std::size_t i = 0; i < depth.size(); ++i) depth[i] = std::min(depth[i], own_picture.depth[i]);
    }
    const Stopwatch compositing;
    if (part.mean_depth) paint_over(compositor.blend(depths_as_colors(own_picture), covered, order), picture.mean_depth);
    const FloatImage& whole = compositor.blend(own_picture, covered, order);
    composite_ms += compositing.elapsed_ms();
    if (groups.size() == 1) {
      picture.image = &whole;
      continue;
    }
    if (painted.rgba.empty())
      painted = whole;
    else
      paint_over(whole, painted);
    picture.image = &painted;
  }
  const Stopwatch compositing;
  if (with_depth) line.least(depth);
  if (input.bricks) give_memory_back();  // of what is seen of a large layer, which no mesh holds
  picture.facts.stages = {{"own", picture.facts.order_ms + picture.facts.draw_ms + picture.facts.readback_ms},
                          {"wait", wait_ms},
                          {"composite", composite_ms + compositing.elapsed_ms()}};
  picture.depth = std::move(depth);
  return picture;
}

}  // namespace isostrata
