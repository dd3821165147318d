#include "rendering/order/boundary_gaps.h"

#include <algorithm>
#include <cmath>

#include "base/parallel.h"

namespace isostrata {
namespace {

constexpr int kBandRows = 8;

/// In units of the rays' spacing, y down; q: nearness, linear on the screen: inverse depth, or minus the depth of parallel rays.
struct ScreenCorner {
  double x, y, q;
};

struct Crossing {
  std::uint32_t face;  // 2 * exterior face + (1 if the ray enters the mesh)
  float q;
};

class Screen {
 public:
  Screen(const Camera& camera, double diagonal, int width, int height, std::int64_t most_rays) : camera_(camera) {
    step_ = 1;
    while (static_cast<std::int64_t>((width + step_ - 1) / step_) * ((height + step_ - 1) / step_) > most_rays) ++step_;
    columns = (width + step_ - 1) / step_;
    rows = (height + step_ - 1) / step_;
    forward_ = normalized(camera.at - camera.eye);
    right_ = normalized(cross(forward_, normalized(camera.up)));
    up_ = cross(right_, forward_);
    const double distance = length(camera.at - camera.eye);
    focal_ = 0.5 * height * (camera.orthographic ? 1.0 : distance) / half_height(camera);
    half_width_ = 0.5 * width;
    half_height_ = 0.5 * height;
    nearest_ = 1e-6 * std::max(diagonal, distance);
  }

  int columns = 0, rows = 0;

  Vec3d view(Vec3d world) const {
    const Vec3d p = world - camera_.eye;
    return {dot(right_, p), dot(up_, p), dot(forward_, p)};
  }
  /// The parts of the face in front of the eye, as a fan around the first corner. Returns how many corners; at most 5.
  int project(const Vec3d* view_corners, int count, ScreenCorner* out) const {
    Vec3d kept[8];
    int n = 0;
    for (int v = 0; v < count; ++v) {
      const Vec3d a = view_corners[v], b = view_corners[(v + 1) % count];
      if (camera_.orthographic || a.z >= nearest_) kept[n++] = a;
      if (!camera_.orthographic && (a.z >= nearest_) != (b.z >= nearest_)) kept[n++] = lerp(a, b, (nearest_ - a.z) / (b.z - a.z));
    }
    for (int v = 0; v < n; ++v) {
      const double scale = camera_.orthographic ? focal_ : focal_ / kept[v].z;
      out[v] = {(half_width_ + kept[v].x * scale - 0.5) / step_, (half_height_ - kept[v].y * scale - 0.5) / step_,
                camera_.orthographic ? -kept[v].z : 1 / kept[v].z};
    }
    return n;
  }

 private:
  const Camera& camera_;
  Vec3d forward_, right_, up_;
  double focal_, half_width_, half_height_, nearest_;
  int step_;
};

struct Piece {
  ScreenCorner corner[3];
  std::uint32_t face;
};

/// What the rays of some rows meet, and what follows from it.
class Band {
 public:
  Band(int columns, int first_row, int rows)
      : columns_(columns),
        first_row_(first_row),
        rows_(rows),
        next_(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows) + 1) {}

  /// Triangles own the rays on their left and upper edges, so that a ray crosses a closed surface once in each place.
  void draw(const Piece& piece) {
    const ScreenCorner &a = piece.corner[0], &b = piece.corner[1], &c = piece.corner[2];
    const double area = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
    if (area == 0 || !std::isfinite(area)) return;
    const double dqx = ((b.q - a.q) * (c.y - a.y) - (c.q - a.q) * (b.y - a.y)) / area;
    const double dqy = ((c.q - a.q) * (b.x - a.x) - (b.q - a.q) * (c.x - a.x)) / area;
    const double top = std::min({a.y, b.y, c.y}), bottom = std::max({a.y, b.y, c.y});
    const int y0 = std::max(first_row_, static_cast<int>(std::ceil(std::max(top, -1.0))));
    const int y1 = std::min(first_row_ + rows_ - 1, static_cast<int>(std::ceil(std::min(bottom, 1e6))) - 1);
    const std::uint32_t face = 2 * piece.face + (area < 0 ? 1 : 0);  // y is down: counter-clockwise outside is negative
    for (int y = y0; y <= y1; ++y) {
      double left = 1e30, right = -1e30;
      for (int e = 0; e < 3; ++e) {
        const ScreenCorner *p = &piece.corner[e], *r = &piece.corner[(e + 1) % 3];
        if ((p->y <= y) == (r->y <= y)) continue;
        if (p->y > r->y) std::swap(p, r);  // the same arithmetic from both sides
        const double x = p->x + (y - p->y) * ((r->x - p->x) / (r->y - p->y));
        left = std::min(left, x);
        right = std::max(right, x);
      }
      const int x0 = static_cast<int>(std::ceil(std::clamp(left, 0.0, 1e6))),
                x1 = static_cast<int>(std::ceil(std::clamp(right, -1.0, static_cast<double>(columns_)))) - 1;
      for (int x = x0; x <= x1; ++x) {
        const double q = a.q + (x - a.x) * dqx + (y - a.y) * dqy;
        met_.push_back({static_cast<std::uint32_t>((y - first_row_) * columns_ + x), {face, static_cast<float>(q)}});
      }
    }
  }

  void find_gaps(const FaceGraph& graph, std::vector<CellGap>& gaps) {
    for (const Met& m : met_) ++next_[m.ray + 1];
    for (std::size_t r = 1; r < next_.size(); ++r) next_[r] += next_[r - 1];
    std::vector<Crossing> crossings(met_.size());
    for (const Met& m : met_) crossings[next_[m.ray]++] = m.crossing;
    std::size_t begin = 0;
    for (std::size_t r = 0; r + 1 < next_.size(); ++r) {
      const std::size_t end = next_[r];
      if (end - begin > 2) follow_ray(graph, crossings.data() + begin, crossings.data() + end, gaps);
      begin = end;
    }
    std::sort(gaps.begin(), gaps.end());
    gaps.erase(std::unique(gaps.begin(), gaps.end()), gaps.end());
  }

 private:
  struct Met {
    std::uint32_t ray;
    Crossing crossing;
  };

  static void follow_ray(const FaceGraph& graph, Crossing* begin, Crossing* end, std::vector<CellGap>& gaps) {
    // Near ones first. Where two parts of the mesh touch but for rounding, the one is left before the other is entered.
    const auto key = [](const Crossing& c) { return (c.face & 1) ? c.q - 3e-7f * std::abs(c.q) : c.q; };
    for (Crossing* at = begin + 1; at < end; ++at) {
      const Crossing moved = *at;
      Crossing* to = at;
      for (; to > begin && key(to[-1]) < key(moved); --to) *to = to[-1];
      *to = moved;
    }
    std::uint32_t left = kNoCell;
    for (const Crossing* at = begin; at < end; ++at) {
      const std::uint32_t cell = graph.exterior[at->face / 2].cell;
      if (!(at->face & 1))
        left = cell;
      else if (left != kNoCell && left != cell && (gaps.empty() || gaps.back() != CellGap{cell, left}))
        gaps.push_back({cell, left});
    }
  }

  int columns_, first_row_, rows_;
  std::vector<Met> met_;
  std::vector<std::uint32_t> next_;  // [rays + 1]
};

}  // namespace

std::vector<CellGap> boundary_gaps(const Grid& grid, const FaceGraph& graph, const Camera& camera, int width, int height,
                                   std::int64_t most_rays) {
  if (graph.convex || graph.exterior.empty()) return {};
  const Screen screen(camera, graph.diagonal, width, height, most_rays);
  const int bands = (screen.rows + kBandRows - 1) / kBandRows;

  // Pieces of the screen by blocks of faces, then by bands of rows, so that both loops are parallel and the result is one.
  constexpr std::int64_t kBlock = 4096;
  const auto faces = static_cast<std::int64_t>(graph.exterior.size());
  std::vector<std::vector<std::vector<Piece>>> pieces(static_cast<std::size_t>((faces + kBlock - 1) / kBlock));
  parallel_for(static_cast<std::int64_t>(pieces.size()), 1, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t block = begin; block < end; ++block) {
      auto& by_band = pieces[static_cast<std::size_t>(block)];
      by_band.resize(static_cast<std::size_t>(bands));
      for (std::int64_t f = block * kBlock; f < std::min(faces, (block + 1) * kBlock); ++f) {
        const auto& points = graph.exterior[static_cast<std::size_t>(f)].points;
        Vec3d corner[4];
        for (std::size_t v = 0; v < 4; ++v) corner[v] = screen.view(grid.point(points[v]));
        ScreenCorner projected[8];
        const int count = screen.project(corner, points[3] == points[2] ? 3 : 4, projected);
        for (int v = 2; v < count; ++v) {
          const Piece piece{{projected[0], projected[v - 1], projected[v]}, static_cast<std::uint32_t>(f)};
          double top = 1e30, bottom = -1e30, left = 1e30, right = -1e30;
          for (const ScreenCorner& c : piece.corner) {
            top = std::min(top, c.y), bottom = std::max(bottom, c.y);
            left = std::min(left, c.x), right = std::max(right, c.x);
          }
          if (!(bottom > 0 && top < screen.rows && right > 0 && left < screen.columns)) continue;
          if (std::ceil(top) > bottom || std::ceil(left) > right) continue;  // between the rays
          const int first = std::max(0, static_cast<int>(top)) / kBandRows;
          const int last = std::min(screen.rows - 1, static_cast<int>(std::min(bottom, 1e6))) / kBandRows;
          for (int b = first; b <= last; ++b) by_band[static_cast<std::size_t>(b)].push_back(piece);
        }
      }
    }
  });
  std::vector<std::vector<CellGap>> found(static_cast<std::size_t>(bands));
  parallel_for(bands, 1, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t b = begin; b < end; ++b) {
      const int first_row = static_cast<int>(b) * kBandRows;
      Band band(screen.columns, first_row, std::min(kBandRows, screen.rows - first_row));
      for (const auto& by_band : pieces)
        for (const Piece& piece : by_band[static_cast<std::size_t>(b)]) band.draw(piece);
      band.find_gaps(graph, found[static_cast<std::size_t>(b)]);
    }
  });
  std::vector<CellGap> gaps;
  for (const auto& part : found) gaps.insert(gaps.end(), part.begin(), part.end());
  std::sort(gaps.begin(), gaps.end());
  gaps.erase(std::unique(gaps.begin(), gaps.end()), gaps.end());
  return gaps;
}

}  // namespace isostrata
