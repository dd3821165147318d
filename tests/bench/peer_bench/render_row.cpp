#include "render_row.h"

#include <algorithm>
#include <boost/json.hpp>
#include <cmath>
#include <cstdio>

#include "base/error.h"

namespace isostrata::peers {
namespace {

boost::json::object spread_json(const Spread& spread) {
  return {{"runs", spread.runs}, {"min", spread.min}, {"median", spread.median}, {"max", spread.max}, {"cpu", spread.cpu_median}};
}

}  // namespace

PictureDifference difference(const Image& a, const Image& b) {
  if (a.width != b.width || a.height != b.height || a.rgba.size() != b.rgba.size() || a.rgba.empty())
    throw Error(ErrorCode::internal, "two pictures to compare: expected them of one size");
  PictureDifference out;
  double sum = 0;
  const auto shows = [&](const Image& image, std::size_t i) {
    return !std::equal(image.rgba.begin() + static_cast<std::ptrdiff_t>(i),
                       image.rgba.begin() + static_cast<std::ptrdiff_t>(i) + 3, a.rgba.begin());
  };
  for (std::size_t i = 0; i < a.rgba.size(); i += 4) {
    if (!shows(a, i) && !shows(b, i)) continue;
    ++out.pixels;
    for (std::size_t c = 0; c < 3; ++c) {
      const double step = std::abs(static_cast<double>(a.rgba[i + c]) - static_cast<double>(b.rgba[i + c]));
      sum += step;
      out.max = std::max(out.max, step);
    }
  }
  if (out.pixels > 0) out.mean = sum / (3.0 * static_cast<double>(out.pixels));
  return out;
}

boost::json::object to_json(const RenderRow& row) {
  boost::json::object out{{"data", row.data},
                          {"interval", boost::json::array{row.interval.lower, row.interval.upper}},
                          {"size", boost::json::array{row.size, row.size}},
                          {"mode", row.mode},
                          {"tetrahedra", row.tetrahedra},
                          {"fragments_per_tetrahedron", row.fragments_per_tetrahedron},
                          {"depth_complexity", row.depth_complexity},
                          {"renderer", row.renderer},
                          {"order", row.order},
                          {"ours_ms", row.ours.median},
                          {"ours", spread_json(row.ours)},
                          {"fps", row.fps()},
                          {"tetrahedra_per_second", row.tetrahedra_per_second()},
                          {"fragments_per_second", row.fragments_per_second()}};
  if (!row.peer.empty()) {
    out["peer"] = row.peer;
    out["peer_ms"] = row.theirs.median;
    out["theirs"] = spread_json(row.theirs);
    out["ratio"] = row.ratio();
    out["ratio_of_minima"] = row.ratio_of_minima();
    out["difference"] = boost::json::object{{"pixels", row.apart.pixels}, {"mean", row.apart.mean}, {"max", row.apart.max}};
  }
  if (row.aim > 0) out["aim"] = row.aim;
  if (row.aim_fps > 0) out["aim_fps"] = row.aim_fps;
  if (row.aim_fragments > 0) out["aim_fragments_per_second"] = row.aim_fragments;
  return out;
}

void print_text(const RenderRow& row) {
  std::printf("%s %.6g:%.6g, %s, %dx%d: %lld tetrahedra, %.1f fragments each, depth complexity %.1f\n", row.data.c_str(),
              row.interval.lower, row.interval.upper, row.mode.c_str(), row.size, row.size,
              static_cast<long long>(row.tetrahedra), row.fragments_per_tetrahedron, row.depth_complexity);
  std::printf("  %-24s %.1f / %.1f / %.1f ms: %.1f frames/s", row.renderer.c_str(), row.ours.min, row.ours.median, row.ours.max,
              row.fps());
  if (row.aim_fps > 0) std::printf(" (aim %.3g)", row.aim_fps);
  std::printf(", %.1f M tetrahedra/s, %.2f G fragments/s", row.tetrahedra_per_second() / 1e6, row.fragments_per_second() / 1e9);
  if (row.aim_fragments > 0) std::printf(" (aim %.2g G)", row.aim_fragments / 1e9);
  std::printf("; order: %s\n", row.order.c_str());
  if (row.peer.empty()) return;
  std::printf("  %-24s %.1f / %.1f / %.1f ms: ratio %.3g (of minima %.3g)", row.peer.c_str(), row.theirs.min, row.theirs.median,
              row.theirs.max, row.ratio(), row.ratio_of_minima());
  if (row.aim > 0) std::printf(", aim %.3g", row.aim);
  std::printf("; pictures differ by %.2f steps in the mean, %.0f at most\n", row.apart.mean, row.apart.max);
}

}  // namespace isostrata::peers
