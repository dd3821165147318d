// The bounding box, its numbered axes and the triad of directions.
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "rendering/annotations/annotation_theme.h"
#include "rendering/annotations/axis_ticks.h"
#include "rendering/picture/pixel_grid.h"

namespace isostrata {
namespace {

constexpr const char* kNames[3] = {"x", "y", "z"};
constexpr Rgb kAxisColors[3] = {{0.93f, 0.32f, 0.30f}, {0.26f, 0.69f, 0.39f}, {0.29f, 0.55f, 0.94f}};
constexpr Rgb kAxisColorsOnLight[3] = {{0.80f, 0.16f, 0.15f}, {0.11f, 0.52f, 0.24f}, {0.12f, 0.38f, 0.82f}};

/// World to picture, lines cut just before the eye.
class Screen {
 public:
  explicit Screen(const AnnotationInput& input)
      : camera_(input.camera), view_(view_from_world(input.camera)), grid_(pixel_grid(input.camera, input.width, input.height)) {
    near_ = camera_.orthographic ? -1e300 : 1e-4 * length(camera_.eye - camera_.at);
  }

  Vec3d view(Vec3d p) const {
    const auto v = view_ * std::array<double, 4>{p.x, p.y, p.z, 1};
    return {v[0], v[1], -v[2]};
  }
  bool before_eye(Vec3d p) const { return view(p).z > near_; }
  Point2 at(Vec3d p) const { return project(view(p)); }

  std::optional<std::array<Point2, 2>> line(Vec3d from, Vec3d to) const {
    Vec3d a = view(from), b = view(to);
    if (a.z <= near_ && b.z <= near_) return std::nullopt;
    if (a.z <= near_) a = lerp(a, b, (near_ * 1.0001 - a.z) / (b.z - a.z));
    if (b.z <= near_) b = lerp(b, a, (near_ * 1.0001 - b.z) / (a.z - b.z));
    return std::array<Point2, 2>{project(a), project(b)};
  }

 private:
  Point2 project(Vec3d v) const {
    const double scale = camera_.orthographic ? grid_.per_unit : grid_.focal / v.z;
    return {grid_.axis_x + v.x * scale, grid_.axis_y - v.y * scale};
  }

  Camera camera_;
  Mat4d view_;
  PixelGrid grid_;
  double near_ = 0;
};

struct Edge {
  int axis = 0;
  Vec3d from, to;  // from the lower end to the upper one
  int facing = 0;  // how many of its two faces look at the eye
};

std::array<Edge, 12> edges_of(const AnnotationInput& input) {
  const Box3d& box = input.bounds;
  const Vec3d towards = normalized(input.camera.eye - input.camera.at);
  const auto seen = [&](int axis, int side) {
    if (input.camera.orthographic) return (side ? towards[axis] : -towards[axis]) > 1e-9;
    return side ? input.camera.eye[axis] > box.upper[axis] : input.camera.eye[axis] < box.lower[axis];
  };
  std::array<Edge, 12> edges;
  std::size_t n = 0;
  for (int axis = 0; axis < 3; ++axis)
    for (int side = 0; side < 4; ++side) {
      const int b = (axis + 1) % 3, c = (axis + 2) % 3, sb = side & 1, sc = side >> 1;
      Edge& edge = edges[n++];
      edge.axis = axis;
      edge.from[axis] = box.lower[axis];
      edge.to[axis] = box.upper[axis];
      edge.from[b] = edge.to[b] = sb ? box.upper[b] : box.lower[b];
      edge.from[c] = edge.to[c] = sc ? box.upper[c] : box.lower[c];
      edge.facing = seen(b, sb) + seen(c, sc);
    }
  return edges;
}

bool flat(const Box3d& box, int axis) { return !(box.upper[axis] > box.lower[axis]); }

/// What stands along one edge.
struct AxisLayout {
  std::vector<Stroke> strokes;
  std::vector<Text> texts;
  std::vector<LabelBox> boxes;
  bool crowded = false;  // numbers of this very axis cover each other
};

LabelBox box_of(const Text& text, const Font& font) {
  const double width = font.width(text.text, text.size), height = font.cap_height(text.size);
  const double x = text.at.x - (text.align == Text::Align::left ? 0 : text.align == Text::Align::right ? width : width / 2);
  return {x, text.at.y - height, x + width, text.at.y};
}

/// Puts a text beside a point so that its nearest corner or side is `gap` away in direction `out`.
Text beside(const AnnotationTheme& theme, const Font& font, Point2 at, Point2 out, double gap, const std::string& words,
            double scale = 1) {
  Text text = theme.label({0, 0}, words, Text::Align::middle, scale);
  const double half_width = font.width(words, text.size) / 2, half_height = font.cap_height(text.size) / 2;
  const double reach = gap + std::abs(out.x) * half_width + std::abs(out.y) * half_height;
  text.at = {at.x + out.x * reach, at.y + out.y * reach + half_height};
  return text;
}

std::string axis_name(const Axes& axes, int axis, double scale) { return axis_title(axes, axis) + (scale == 1 ? "" : " ×" + number_text(scale, 3)); }

/// scale: places of this axis for one of its numbers.
AxisLayout lay_out(const AxisTicks& ticks, double scale, const Edge& edge, Point2 out, const Screen& screen, const AnnotationTheme& theme,
                   const Font& font) {
  AxisLayout layout;
  const auto texts = tick_texts(ticks);
  for (std::size_t i = 0; i < ticks.values.size(); ++i) {
    Vec3d point = edge.from;
    point[edge.axis] = ticks.values[i] * scale;
    const Point2 at = screen.at(point);
    const double reach = 0.45 * theme.letter;
    layout.strokes.push_back({at, {at.x + out.x * reach, at.y + out.y * reach}, theme.line, theme.text});
    layout.texts.push_back(beside(theme, font, at, out, 0.75 * theme.letter, texts[i]));
    layout.boxes.push_back(box_of(layout.texts.back(), font));
    for (std::size_t j = 0; j < i; ++j)
      layout.crowded = layout.crowded || layout.boxes[j].overlaps(layout.boxes[i], 0.4 * theme.letter);
  }
  return layout;
}

bool inside(const LabelBox& box, const AnnotationInput& input) {
  return box.x0 >= 1 && box.y0 >= 1 && box.x1 <= input.width - 1 && box.y1 <= input.height - 1;
}

/// Whether it is free, and was put.
bool put_free(const Text& text, const LabelBox& box, const AnnotationInput& input, const AnnotationTheme& theme,
              std::vector<LabelBox>& taken, Drawing& drawing) {
  if (!inside(box, input)) return false;
  for (const LabelBox& other : taken)
    if (other.overlaps(box, 0.5 * theme.letter)) return false;
  taken.push_back(box);
  drawing.over.emplace_back(text);
  return true;
}

}  // namespace

std::vector<Point2> box_outline(const AnnotationInput& input) {
  if (input.bounds.empty()) return {};
  const Screen screen(input);
  std::vector<Point2> corners;
  for (int i = 0; i < 8; ++i) {
    const Box3d& box = input.bounds;
    const Vec3d corner{i & 1 ? box.upper.x : box.lower.x, i & 2 ? box.upper.y : box.lower.y, i & 4 ? box.upper.z : box.lower.z};
    if (!screen.before_eye(corner)) return {};
    corners.push_back(screen.at(corner));
  }
  // The convex hull, by Andrew's chains: the one above from left to right, then the one below back.
  std::sort(corners.begin(), corners.end(), [](Point2 a, Point2 b) { return a.x != b.x ? a.x < b.x : a.y < b.y; });
  std::vector<Point2> outline;
  for (int chain = 0; chain < 2; ++chain) {
    const std::size_t first = outline.size();
    for (const Point2 p : corners) {
      while (outline.size() >= first + 2) {
        const Point2 a = outline[outline.size() - 2], b = outline.back();
        if ((b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x) > 0) break;
        outline.pop_back();
      }
      outline.push_back(p);
    }
    outline.pop_back();  // begins the other chain
    std::reverse(corners.begin(), corners.end());
  }
  return outline;
}

void annotate_box(const AnnotationInput& input, const AnnotationTheme& theme, Drawing& drawing) {
  const Screen screen(input);
  for (const Edge& edge : edges_of(input)) {
    if (flat(input.bounds, edge.axis)) continue;
    const auto line = screen.line(edge.from, edge.to);
    if (!line) continue;
    if (edge.facing == 0)
      drawing.under.emplace_back(Stroke{(*line)[0], (*line)[1], theme.line, theme.faint});
    else
      drawing.over.emplace_back(Stroke{(*line)[0], (*line)[1], theme.line, {theme.strong.color, 0.7}});
  }
}

void annotate_axes(const AnnotationInput& input, const AnnotationTheme& theme, const Font& font, std::vector<LabelBox>& taken,
                   Drawing& drawing) {
  const Screen screen(input);
  const auto edges = edges_of(input);
  if (std::all_of(edges.begin(), edges.end(), [](const Edge& edge) { return edge.facing == 0; })) return;  // the eye is inside
  if (!screen.before_eye(input.bounds.center())) return;
  const Point2 middle = screen.at(input.bounds.center());
  for (int axis = 0; axis < 3; ++axis) {
    if (flat(input.bounds, axis)) continue;
    // Numbers stand on the outline, where they cover nothing of the volume: on the lowest of its edges along this axis, or the
    // left one.
    const Edge* best = nullptr;
    double best_score = 0;
    for (const Edge& edge : edges) {
      if (edge.axis != axis || edge.facing != 1 || !screen.before_eye(edge.from) || !screen.before_eye(edge.to)) continue;
      const Point2 a = screen.at(edge.from), b = screen.at(edge.to);
      const double steep = std::abs(b.y - a.y) > 3 * std::abs(b.x - a.x) ? 1 : 1e-3;
      const double score = (a.y + b.y) / 2 * (steep == 1 ? 1e-3 : 1) - (a.x + b.x) / 2 * steep;
      if (!best || score > best_score) best = &edge, best_score = score;
    }
    if (!best) continue;
    const Point2 a = screen.at(best->from), b = screen.at(best->to);
    const double pixels = std::hypot(b.x - a.x, b.y - a.y);
    if (pixels < 3 * theme.letter) continue;  // seen end on
    Point2 out{(b.y - a.y) / pixels, -(b.x - a.x) / pixels};
    const Point2 half{(a.x + b.x) / 2, (a.y + b.y) / 2};
    if ((half.x - middle.x) * out.x + (half.y - middle.y) * out.y < 0) out = {-out.x, -out.y};
    if (!input.show.box) drawing.over.emplace_back(Stroke{a, b, theme.line, {theme.strong.color, 0.7}});

    AxisLayout layout;
    const double factor = input.axis_scale[axis], scale = input.axes[static_cast<std::size_t>(axis)].downward ? -factor : factor;
    for (int most = 8; most >= 1; --most) {
      const double a_number = input.bounds.lower[axis] / scale, another = input.bounds.upper[axis] / scale;
      const AxisTicks ticks = axis_ticks(std::min(a_number, another), std::max(a_number, another), most);
      layout = lay_out(ticks, scale, *best, out, screen, theme, font);
      if (!layout.crowded && pixels / (static_cast<double>(ticks.values.size()) + 1) > 2 * theme.letter) break;
    }
    double farthest = 0;  // of the numbers from the edge, for the name beyond them
    for (const LabelBox& box : layout.boxes)
      for (const double x : {box.x0, box.x1})
        for (const double y : {box.y0, box.y1}) farthest = std::max(farthest, (x - half.x) * out.x + (y - half.y) * out.y);
    for (const Stroke& stroke : layout.strokes) drawing.over.emplace_back(stroke);
    // Beyond the middle of the numbers, else beyond an end of the axis, else the letter alone.
    const std::string words = axis_name(input.axes, axis, factor);
    const double gap = std::max(farthest, theme.letter) + 0.5 * theme.letter;
    const Point2 along{(b.x - a.x) / pixels, (b.y - a.y) / pixels};
    for (Text name : {beside(theme, font, half, out, gap, words, 1.25), beside(theme, font, b, along, theme.letter, words, 1.25),
                      beside(theme, font, a, {-along.x, -along.y}, theme.letter, words, 1.25), beside(theme, font, half, out, gap, axis_name({}, axis, factor), 1.25)}) {
      name.ink = {theme.dark ? kAxisColors[axis] : kAxisColorsOnLight[axis], 1};
      if (put_free(name, box_of(name, font), input, theme, taken, drawing)) break;
    }
    for (std::size_t i = 0; i < layout.texts.size(); ++i)
      put_free(layout.texts[i], layout.boxes[i], input, theme, taken, drawing);
  }
}

void annotate_triad(const AnnotationInput& input, const AnnotationTheme& theme, const Font& font, std::vector<LabelBox>& taken,
                    Drawing& drawing) {
  const double reach = 2.6 * theme.letter, room = 1.5 * reach;
  if (std::min(input.width, input.height) < 4 * room) return;
  const Point2 origin{room, input.height - room};
  const LabelBox square{0, input.height - 2 * room, 2 * room, static_cast<double>(input.height)};
  for (const LabelBox& other : taken)
    if (other.overlaps(square, 0)) return;
  const Mat4d view = view_from_world(input.camera);
  std::array<int, 3> order{0, 1, 2};  // the one that points away first
  const auto towards = [&](int axis) { return view.m[static_cast<std::size_t>(axis)][2]; };
  std::sort(order.begin(), order.end(), [&](int a, int b) { return towards(a) < towards(b); });
  taken.push_back(square);
  std::vector<Text> names;
  for (const int axis : order) {
    const auto& column = view.m[static_cast<std::size_t>(axis)];
    const double dx = column[0] * reach, dy = -column[1] * reach, pixels = std::hypot(dx, dy);
    const Ink ink{theme.dark ? kAxisColors[axis] : kAxisColorsOnLight[axis], 1};
    const double head = std::min(0.62 * theme.letter, pixels);
    const Point2 tip{origin.x + dx, origin.y + dy};
    if (pixels > 0.15 * theme.letter) {
      const Point2 along{dx / pixels, dy / pixels}, base{tip.x - along.x * head, tip.y - along.y * head};
      drawing.over.emplace_back(Stroke{origin, base, 1.8 * theme.line, ink});
      const double half = 0.42 * head;
      drawing.over.emplace_back(Polygon{
          {tip, {base.x - along.y * half, base.y + along.x * half}, {base.x + along.y * half, base.y - along.x * half}}, ink});
      Text name = beside(theme, font, tip, along, 0.3 * theme.letter, kNames[axis], 1.1);
      name.ink = ink;
      names.push_back(name);
    } else {
      drawing.over.emplace_back(Stroke{origin, origin, 2.4 * theme.line, ink});  // seen end on: a dot
      if (towards(axis) > 0) {
        Text name = beside(theme, font, origin, {-0.7071, 0.7071}, 0.3 * theme.letter, kNames[axis], 1.1);
        name.ink = ink;
        names.push_back(name);
      }
    }
  }
  std::vector<LabelBox> named;  // where two arrows fall together, the nearer one keeps its name
  for (auto name = names.rbegin(); name != names.rend(); ++name) {
    const LabelBox box = box_of(*name, font);
    if (std::any_of(named.begin(), named.end(), [&](const LabelBox& other) { return other.overlaps(box, 0); })) continue;
    named.push_back(box);
    drawing.over.emplace_back(*name);
  }
}

}  // namespace isostrata
