#include "main/draw_case.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdio>
#include <vector>

#include "base/error.h"
#include "base/vec.h"
#include "tables/interval_case.h"

namespace isostrata {
namespace {

constexpr double kScale = 220, kMargin = 46, kApart = 0.16;
constexpr std::array kFills{"#0072b2", "#e69f00", "#009e73", "#cc79a7", "#56b4e9", "#d55e00", "#f0e442", "#999999"};

std::vector<int> classes_of(const LatticeCell& cell, std::int64_t case_index) {
  std::vector<int> classes;
  for (int v = 0; v < cell.vertex_count(); ++v, case_index /= 3) classes.push_back(static_cast<int>(case_index % 3));
  return classes;
}

/// Of the cell's first three coordinates; the fourth and fifth move the whole.
Vec3d position(const LatticeCell& cell, const LatticePoint& point) {
  Vec3d at;
  for (int i = 0; i < std::min(3, cell.dimension); ++i) at[i] = static_cast<double>(point[i]);
  if (cell.dimension > 3) at = at * 0.62 + Vec3d{1.05, 0.1, 0.35} * static_cast<double>(point[3]);
  if (cell.dimension > 4) at = at * 0.7 + Vec3d{0.15, 0.1, 0.95} * static_cast<double>(point[4]);
  return at;
}

/// Where an isovertex lies if classes are values and the interval is from a half to one and a half.
Vec3d position(const LatticeCell& cell, const std::vector<int>& classes, IsoVertex v) {
  const int n = cell.vertex_count(), e = cell.edge_count();
  if (v < n) return position(cell, cell.vertices[v]);
  const auto [a, b] = cell.edges[(v - n) % e];
  const double isovalue = v < n + e ? 0.5 : 1.5;
  return lerp(position(cell, cell.vertices[a]), position(cell, cell.vertices[b]), (isovalue - classes[a]) / (classes[b] - classes[a]));
}

struct Drawn {
  double x, y, depth;
};

/// A parallel view from the right, above and before. Two-dimensional cells are seen from straight above.
Drawn project(const LatticeCell& cell, const Vec3d& p) {
  if (cell.dimension == 2) return {p.x, -p.y, 0};
  return {p.x + 0.42 * p.y, -(p.z + 0.26 * p.y), p.y - 0.3 * p.z - 0.2 * p.x};
}

class SvgDrawing {
 public:
  void polygon(const std::vector<Drawn>& corners, const char* fill) {
    std::string points;
    for (const Drawn& c : corners) points += number(c.x) + "," + number(c.y) + " ", include(c);
    body_ += "<polygon points=\"" + points + "\" fill=\"" + fill + "\" fill-opacity=\"0.5\" stroke=\"#222\" stroke-width=\"1\"/>\n";
  }
  void line(const Drawn& a, const Drawn& b, const std::string& color) {
    include(a), include(b);
    body_ += "<line x1=\"" + number(a.x) + "\" y1=\"" + number(a.y) + "\" x2=\"" + number(b.x) + "\" y2=\"" + number(b.y) +
             "\" stroke=\"" + color + "\" stroke-width=\"2\"/>\n";
  }
  void dot(const Drawn& at, const char* fill) {
    include(at);
    body_ += "<circle cx=\"" + number(at.x) + "\" cy=\"" + number(at.y) + "\" r=\"7\" fill=\"" + fill +
             "\" stroke=\"black\" stroke-width=\"1.5\"/>\n";
  }
  std::string finish(const std::string& title) const {
    const double x = x0_ * kScale - kMargin, y = y0_ * kScale - kMargin;
    const double width = (x1_ - x0_) * kScale + 2 * kMargin, height = (y1_ - y0_) * kScale + 2 * kMargin;
    std::array<char, 200> head;
    std::snprintf(head.data(), head.size(),
                  "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"%.1f %.1f %.1f %.1f\" width=\"%.0f\" height=\"%.0f\">\n", x, y,
                  width, height, width, height);
    return head.data() + ("<title>" + title + "</title>\n") + "<rect x=\"" + std::to_string(x) + "\" y=\"" + std::to_string(y) +
           "\" width=\"100%\" height=\"100%\" fill=\"white\"/>\n" + body_ + "</svg>\n";
  }

 private:
  static std::string number(double v) {
    std::array<char, 32> text;
    std::snprintf(text.data(), text.size(), "%.2f", v * kScale);
    return text.data();
  }
  void include(const Drawn& at) {
    x0_ = std::min(x0_, at.x), x1_ = std::max(x1_, at.x);
    y0_ = std::min(y0_, at.y), y1_ = std::max(y1_, at.y);
  }
  std::string body_;
  double x0_ = 1e9, y0_ = 1e9, x1_ = -1e9, y1_ = -1e9;
};

struct Face {
  std::vector<Drawn> corners;
  double depth = 0;
  const char* fill;
};

/// Farthest first.
std::vector<Face> faces_of(const LatticeCell& cell, std::int64_t case_index) {
  const std::vector<int> classes = classes_of(cell, case_index);
  Vec3d middle;
  for (const LatticePoint& v : cell.vertices) middle = middle + position(cell, v) / static_cast<double>(cell.vertex_count());
  std::vector<Face> faces;
  std::size_t number = 0;
  for (const IsoSimplex& simplex : interval_case(cell, case_index)) {
    const int corners = cell.dimension + 1;
    std::vector<Vec3d> at;
    Vec3d center;
    for (int i = 0; i < corners; ++i) {
      at.push_back(position(cell, classes, simplex.vertex[static_cast<std::size_t>(i)]));
      center = center + at.back() / static_cast<double>(corners);
    }
    const Vec3d moved = cell.dimension == 3 ? (center - middle) * kApart : Vec3d{};
    const char* fill = kFills[number++ % kFills.size()];
    for (int left_out = 0; left_out < (cell.dimension == 3 ? 4 : 1); ++left_out) {
      Face face{{}, 0, fill};
      for (int i = 0; i < corners; ++i) {
        if (cell.dimension == 3 && i == left_out) continue;
        face.corners.push_back(project(cell, at[static_cast<std::size_t>(i)] + moved));
        face.depth += face.corners.back().depth;
      }
      faces.push_back(std::move(face));
    }
  }
  std::stable_sort(faces.begin(), faces.end(), [](const Face& a, const Face& b) { return a.depth > b.depth; });
  return faces;
}

std::string edge_color(const LatticeCell& cell, int a, int b) {
  if (cell.dimension < 4) return "#444";
  const auto &p = cell.vertices[static_cast<std::size_t>(a)], &q = cell.vertices[static_cast<std::size_t>(b)];
  if (p[3] != q[3]) return "maroon";
  return p[3] == 0 ? "green" : "blue";
}

}  // namespace

std::int64_t parse_case(const LatticeCell& cell, std::string_view text) {
  const auto n = static_cast<std::size_t>(cell.vertex_count());
  const bool digits = std::all_of(text.begin(), text.end(), [](char c) { return c >= '0' && c <= '2'; });
  std::int64_t index = 0;
  if (digits && text.size() == n) {
    for (std::size_t v = n; v-- > 0;) index = 3 * index + (text[v] - '0');
    return index;
  }
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), index);
  if (error != std::errc{} || end != text.data() + text.size() || index < 0 || index >= case_count(cell.vertex_count()))
    throw Error(ErrorCode::invalid_argument, "case '" + std::string(text) + "' of the " + cell.name + ": expected " + std::to_string(n) +
                                                 " digits 0, 1 or 2, one a vertex, or a number from 0 to " +
                                                 std::to_string(case_count(cell.vertex_count()) - 1));
  return index;
}

std::string draw_case(const LatticeCell& cell, std::int64_t case_index) {
  const std::vector<int> classes = classes_of(cell, case_index);
  SvgDrawing drawing;
  const auto at = [&](int v) { return project(cell, position(cell, cell.vertices[static_cast<std::size_t>(v)])); };
  for (const auto& [a, b] : cell.edges) drawing.line(at(a), at(b), edge_color(cell, a, b));
  if (cell.dimension <= 3)
    for (const Face& face : faces_of(cell, case_index)) drawing.polygon(face.corners, face.fill);
  for (int v = 0; v < cell.vertex_count(); ++v) {
    constexpr std::array kClassFills{"white", "#aaa", "black"};
    drawing.dot(at(v), kClassFills[static_cast<std::size_t>(classes[static_cast<std::size_t>(v)])]);
  }
  return drawing.finish(cell.name + ", case " + std::to_string(case_index));
}

std::string describe_case(const LatticeCell& cell, std::int64_t case_index) {
  const int n = cell.vertex_count(), e = cell.edge_count();
  std::string text;
  for (const IsoSimplex& simplex : interval_case(cell, case_index)) {
    for (int i = 0; i <= cell.dimension; ++i) {
      const int v = simplex.vertex[static_cast<std::size_t>(i)];
      if (i > 0) text += ", ";
      if (v < n) {
        text += "v" + std::to_string(v);
        continue;
      }
      const auto [a, b] = cell.edges[static_cast<std::size_t>((v - n) % e)];
      text += std::to_string(a) + "-" + std::to_string(b) + (v < n + e ? " lower" : " upper");
    }
    text += "\n";
  }
  return text;
}

}  // namespace isostrata
