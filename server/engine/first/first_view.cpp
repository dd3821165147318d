#include "engine/first/first_view.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <set>

#include "data/dataset/dataset_bytes.h"
#include "data/derived/proxy_grid.h"
#include "data/derived/scaled_dataset.h"
#include "data/derived/series_ranges.h"
#include "data/derived/value_curves.h"
#include "engine/first/choose_array.h"
#include "engine/first/choose_layers.h"
#include "engine/first/find_labels.h"
#include "engine/first/find_missing.h"
#include "engine/first/kept_first_view.h"
#include "engine/first/unlike_axis.h"

namespace isostrata {
namespace {

// M. Okabe, K. Ito, "Color Universal Design", 2002, told apart by everyone; paler where a layer is looked through, since what is
// dark and translucent is lost on a dark background.
constexpr std::string_view kPale = "#8fcdf5", kOrange = "#e69f00", kSky = "#56b4e9", kVermilion = "#d55e00", kYellow = "#f0e442",
                           kGrey = "#8a9aab", kGreen = "#009e73", kBlue = "#4a90d9", kPurple = "#cc79a7", kOutline = "#b8c4cc", kSkin = "#e0a080", kBone = "#f2e6c8";

constexpr double kMostInLayer = 1.5e6;  // tetrahedra: what is extracted and drawn at once on two cores
constexpr double kMostInOutline = 3e6;  // its layer is all of the cells

// ---- ends ----

/// To a half where values are whole numbers, so that no point lies on the surface; else to a thousandth of the range's decade.
double rounded_end(double value, const PointArray& array, const ProxyGrid& proxy) {
  if (array.type != ScalarType::float32 && array.type != ScalarType::float64) return std::floor(value) + 0.5;
  const double wide = proxy.logarithmic ? std::abs(value) * 10 : proxy.upper - proxy.lower;
  const double unit = std::pow(10, std::floor(std::log10(wide)) - 3);
  const double in_units = value / unit;
  if (!std::isfinite(in_units) || std::abs(in_units) > 1e15 || !(unit > 1e-290)) return value;
  return unit < 1 ? std::round(in_units) / std::round(1 / unit) : std::round(in_units) * unit;
}

/// The values of ends between 0 and 1, each once, in order and apart; the range's own ends stand for 0 and 1.
class Ends {
 public:
  Ends(const LayersChoice& choice, const PointArray& array, const ProxyGrid& proxy) : array_(array), proxy_(proxy) {
    std::set<double> all;
    for (const LayerChoice& layer : choice.layers) all.insert({layer.from, layer.to});
    double before = array.lower;
    for (const double t : all) {
      double value = exact(t);
      if (t > 0 && t < 1) {
        const double nice = rounded_end(value, array, proxy);
        if (nice > before && nice < array.upper) value = nice;
      }
      values_.emplace_back(t, value);
      before = value;
    }
  }
  double operator()(double t) const {
    for (const auto& [of, value] : values_)
      if (of == t) return value;
    return exact(t);
  }

 private:
  double exact(double t) const {
    return t <= 0 ? array_.lower : t >= 1 ? array_.upper : std::clamp(proxy_.value_at(t), array_.lower, array_.upper);
  }

  const PointArray& array_;
  const ProxyGrid& proxy_;
  std::vector<std::pair<double, double>> values_;
};

// ---- looks ----

/// Of a layer one unit distance thick, where one `depth` thick, in shares of the diagonal, is to have `opacity`.
double opacity_of(double opacity, double depth) {
  constexpr double kUnit = 1.0 / 20;  // default_unit_distance, of the diagonal
  return std::clamp(1 - std::pow(1 - opacity, kUnit / std::max(depth, 1e-6)), 0.001, 0.98);
}

SurfaceStyle lit(bool lower, bool upper, bool domain, double opacity) {
  SurfaceStyle style;
  style.lower = lower;
  style.upper = upper;
  style.domain = domain;
  style.opacity = opacity;
  return style;
}

FirstLayer looks_of(const LayerChoice& layer, const LayersChoice& choice, const ProxyGrid& proxy, std::size_t index, bool flat) {
  FirstLayer out;
  out.name = layer.name;
  out.reason = layer.reason;
  const bool low_side = layer.rises_inward;
  const auto look = [&](std::string_view color, double opacity, SurfaceStyle surface) {
    out.color = parse_rgb(color);
    out.opacity = opacity;
    out.surface = surface;
  };
  switch (layer.role) {
    case LayerRole::outer:
      look(choice.anatomy ? kSkin : kPale, opacity_of(0.08, 0.3), lit(low_side, !low_side, false, 0.28));
      break;
    case LayerRole::inner:
      look(choice.anatomy ? kBone : kOrange, opacity_of(0.8, 0.1), lit(low_side, !low_side, true, 0.95));
      break;
    case LayerRole::low:
      look(kSky, opacity_of(0.3, 0.1), lit(false, true, true, 0.8));
      break;
    case LayerRole::high:
      look(kVermilion, opacity_of(0.3, 0.1), lit(true, false, true, 0.9));
      break;
    case LayerRole::wall:
      look(kOrange, 0.5, lit(low_side, !low_side, true, 1));
      break;
    case LayerRole::band: {
      constexpr std::array<std::string_view, 4> kBands{kGrey, kSky, kYellow, kVermilion};
      if (flat)
        look(kBands[index % 4], 0.98, {});  // an area is drawn as one
      else
        look(kBands[index % 4], opacity_of(0.97, std::max(proxy.thickness, 0.002)), lit(true, true, true, 0.9));
      break;
    }
    case LayerRole::outline:
      look(kOutline, 0.001, lit(false, false, true, 0.12));
      break;
    case LayerRole::label: {
      constexpr std::array kLabels{kOrange, kSky, kGreen, kVermilion, kYellow, kPurple, kBlue, kGrey};
      look(kLabels[index % kLabels.size()], flat ? 0.98 : opacity_of(0.9, layer.depth), flat ? SurfaceStyle{} : lit(true, true, true, 0.95));
      break;
    }
  }
  return out;
}

// ---- one step ----

FieldHints hints_of(const Dataset& dataset, const PointArray& array) {
  FieldHints hints;
  hints.rests_at_zero = rests_at_zero(array);
  hints.level_set = is_level_set(array.name);
  hints.whole_numbers = array.type != ScalarType::float32 && array.type != ScalarType::float64;
  hints.flat = dataset.grid.flat();
  hints.labels = find_labels(array.cells ? as_array(*array.cells, array.name) : array);
  return hints;
}

/// A sheet is seen from its broad side: it must vary there.
bool varies_on_its_face(const ProxyGrid& proxy) {
  const Vec3d s = proxy.sides();
  const int thin = s.x <= s.y && s.x <= s.z ? 0 : s.y <= s.z ? 1 : 2;
  std::array<double, 3> sorted{s.x, s.y, s.z};
  std::sort(sorted.begin(), sorted.end());
  if (sorted[0] >= 0.12 * sorted[1]) return true;
  const auto axis = static_cast<std::size_t>(thin);
  const std::size_t n = static_cast<std::size_t>(proxy.dims[axis]);
  const std::size_t jump = axis == 0   ? 1
                           : axis == 1 ? static_cast<std::size_t>(proxy.dims[0])
                                       : static_cast<std::size_t>(proxy.dims[0]) * static_cast<std::size_t>(proxy.dims[1]);
  const std::size_t face = n > 2 ? n - 2 : n - 1;
  std::vector<float> on_face;
  for (std::size_t i = 0; i < proxy.size(); ++i)
    if (i / jump % n == face && !std::isnan(proxy.values[i])) on_face.push_back(proxy.values[i]);
  if (on_face.size() < 20) return true;
  std::sort(on_face.begin(), on_face.end());
  const double spread = on_face[on_face.size() * 95 / 100] - on_face[on_face.size() * 5 / 100];
  const ValueCurves curves(proxy);
  return spread >= 0.35 * (curves.value_above(0.02) - curves.value_above(0.98));
}

/// 15 significant digits tell a float's 1e20 from a double's; nobody wants to read them.
std::string shortest(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", value);
  return text;
}

struct Looked {
  std::optional<PointArray> array;  // its range without what stands for no value
  std::optional<MissingValue> missing;
  ProxyGrid proxy;
};

/// The best of the ranked arrays that has something to show.
Looked choose(const Dataset& dataset, const std::vector<ArrayChoice>& ranked, FirstView& view, const Task& task) {
  constexpr std::size_t kTries = 4;
  Looked best;
  std::size_t tries = 0;
  for (const ArrayChoice& candidate : ranked) {
    if (tries++ == kTries || (best.array && candidate.score < -1)) break;
    PointArray array = dataset.array(candidate.name);
    const std::optional<MissingValue> missing = find_missing(array);
    if (missing) array.lower = missing->lower, array.upper = missing->upper;
    ProxyGrid proxy = make_proxy(dataset, array, task, missing ? std::optional(missing->value) : std::nullopt);
    if (proxy.empty()) continue;
    const bool good = dataset.grid.flat() || varies_on_its_face(proxy);
    if (best.array && !good) continue;
    const bool first = !best.array;
    view.array = array.name;
    view.array_reason = candidate.reason + (first ? "" : "; others do not vary on the broad side");
    if (missing) view.array_reason += "; " + shortest(missing->value) + " stands for no value";
    best = {std::move(array), missing, std::move(proxy)};
    if (good) break;
  }
  return best;
}

std::string nothing_to_show(const Dataset& dataset) {
  if (dataset.arrays.empty()) return "the dataset has no array";
  if (dataset.grid.cell_count() == 0) return "the dataset has no cells: one point or one line of points has no inside";
  bool finite = false;
  for (const PointArray& array : dataset.arrays) finite = finite || array.lower <= array.upper;
  if (!finite) return "no array has a finite value";
  const auto differs = std::find_if(dataset.arrays.begin(), dataset.arrays.end(), [](const PointArray& array) { return array.lower < array.upper; });
  if (differs == dataset.arrays.end()) return "every array has one value everywhere";
  if (std::any_of(dataset.arrays.begin(), dataset.arrays.end(), [](const PointArray& array) { return varies(array.lower, array.upper, array.type); })) return "the points' box is not finite, or all cells are hidden or have no value";
  return "every array has nearly one value everywhere: '" + differs->name + "' differs by less than one part in " + shortest(1 / rounding_of(differs->type));
}

/// The share of the domain in which labels lie.
double held_by_labels(const LayersChoice& choice, const ValueCurves& curves) {
  double share = 0;
  for (const LayerChoice& layer : choice.layers)
    if (layer.role == LayerRole::label) share += curves.share_above(layer.from) - (layer.to >= 1 ? 0 : curves.share_above(layer.to));
  return share;
}

/// Layers, light and camera of the array at this step. `range` is what the outer ends reach to.
void look_at(FirstView& view, const Dataset& dataset, const Looked& looked, ValueRange range, bool map) {
  const ProxyGrid& proxy = looked.proxy;
  const ValueCurves curves(proxy);
  FieldHints hints = hints_of(dataset, *looked.array);
  hints.map = map;
  hints.missing_below = looked.missing && looked.missing->value < looked.missing->lower;
  hints.missing_above = looked.missing && looked.missing->value > looked.missing->upper;
  const auto cells = static_cast<double>(dataset.grid.cell_count());
  const auto tets = dataset.cell_types.find("tetrahedron");
  const bool split = tets != dataset.cell_types.end() && dataset.cell_types.size() == 1;
  const double each = split ? 1 : 5.5;  // tetrahedra in a cell
  LayersChoice choice = choose_layers(proxy, curves, hints);
  if (choice.kind == FieldKind::labels && !hints.flat && held_by_labels(choice, curves) * cells * each > kMostSolid) {
    hints.labels.clear();  // bodies cannot be thinned
    choice = choose_layers(proxy, curves, hints);
  }
  thin_layers(choice, proxy, curves, cells, each, kMostInLayer);
  view.kind = to_string(choice.kind);
  view.kind_reason = choice.reason;

  PointArray array = *looked.array;
  if (choice.kind == FieldKind::labels) view.values = FieldValues::whole;  // between labels there are none
  if (view.values == FieldValues::whole && array.cells) range = join(range, {array.cells->lower, array.cells->upper});
  if (!looked.missing) {
    array.lower = std::min(array.lower, range.lower);
    array.upper = std::max(array.upper, range.upper);
  }
  view.lower = array.lower;
  view.upper = array.upper;
  const Ends ends(choice, array, proxy);
  const bool solid = choice.kind != FieldKind::sheet && choice.kind != FieldKind::two_valued && choice.kind != FieldKind::labels &&
                     (proxy.fill < 0.6 || belongs_to_a_solid(array.name));
  const bool outline = solid && cells * each <= kMostInOutline;
  if (outline) {
    const LayerChoice whole{LayerRole::outline, 0, 1, true, "outline", "the domain's own outline, for what lies inside"};
    view.layers.push_back(looks_of(whole, choice, proxy, 0, hints.flat));
    view.layers.back().lower = array.lower;
    view.layers.back().upper = array.upper;
  }
  for (std::size_t i = 0; i < choice.layers.size(); ++i) {
    FirstLayer layer = looks_of(choice.layers[i], choice, proxy, i, hints.flat);
    layer.lower = ends(choice.layers[i].from);
    layer.upper = ends(choice.layers[i].to);
    if (layer.lower < layer.upper) view.layers.push_back(std::move(layer));
  }
  std::stable_sort(view.layers.begin() + (outline ? 1 : 0), view.layers.end(),
                   [](const FirstLayer& a, const FirstLayer& b) { return a.lower < b.lower; });
  view.light_reason = hints.flat ? "areas are drawn as they are" : "boundaries are lit, bodies are faint";

  const UpChoice up = choose_up(proxy, choice, hints);
  const ViewChoice camera = choose_view(proxy, choice, up, outline || choice.kind == FieldKind::sheet);
  view.direction = camera.direction;
  view.up = camera.up;
  view.up_reason = up.reason;
  view.outline = camera.outline;
  view.camera_reason = camera.reason;
}

// ---- the step ----

/// The width of the middle nine tenths of the values.
double middle_width(const PointArray& array) {
  constexpr std::size_t kLooks = 50'000;
  std::vector<double> some;
  std::visit(
      [&](auto values) {
        const std::size_t stride = std::max<std::size_t>(1, values.size() / kLooks);
        for (std::size_t i = 0; i < values.size(); i += stride)
          if (const auto v = static_cast<double>(values[i]); std::isfinite(v)) some.push_back(v);
      },
      array.values);
  if (some.empty()) return 0;
  std::sort(some.begin(), some.end());
  return some[(some.size() - 1) * 95 / 100] - some[(some.size() - 1) * 5 / 100];
}

const PointArray* find(const Dataset& dataset, const std::string& name) {
  for (const PointArray& array : dataset.arrays)
    if (array.name == name) return &array;
  return nullptr;
}

}  // namespace

Camera FirstView::camera(double aspect) const { return camera_on({direction, up, outline, {}}, aspect); }

namespace {

FirstView choose_view(const Dataset& first, const FirstViewSteps& steps, const FirstViewWishes& wishes, const Task& task) {
  const int count = static_cast<int>(std::max<std::size_t>(first.times.size(), 1));
  std::vector<int> wanted{wishes.step >= 0 ? wishes.step : count / 2};
  if (wishes.step < 0 && count > 1 && dataset_bytes(first) <= kFirstViewBytes)
    for (const int step : {0, count / 4, 3 * count / 4, count - 1})
      if (std::find(wanted.begin(), wanted.end(), step) == wanted.end()) wanted.push_back(step);

  std::vector<std::shared_ptr<const Dataset>> held;
  std::vector<const Dataset*> looked_at;
  for (const int step : wanted) {
    task.check();
    if (step == first.step) {
      looked_at.push_back(&first);
      continue;
    }
    try {
      held.push_back(steps(step, task));
      looked_at.push_back(held.back().get());
    } catch (const Error& error) {
      if (error.code() == ErrorCode::cancelled || step == wishes.step)
        throw;  // a step that cannot be read is not a reason to show nothing
    }
  }
  if (looked_at.empty()) looked_at.push_back(&first);

  FirstView view;
  std::vector<ArrayChoice> ranked;
  if (wishes.array.empty()) {
    ranked = rank_arrays(looked_at);
  } else {
    first.array(wishes.array);  // throws, naming those that are there
    ranked.push_back({wishes.array, 0, "as asked for"});
  }
  const Dataset* shown = looked_at.front();
  view.step_reason = wishes.step >= 0 ? "as asked for" : count == 1 ? "the only step" : "the middle one";
  if (!ranked.empty() && looked_at.size() > 1) {
    std::vector<double> spreads;
    for (const Dataset* step : looked_at) {
      const PointArray* array = find(*step, ranked.front().name);
      spreads.push_back(array ? middle_width(*array) : 0);
    }
    const auto widest = std::max_element(spreads.begin(), spreads.end());
    if (spreads.front() < 0.5 * *widest) {
      shown = looked_at[static_cast<std::size_t>(widest - spreads.begin())];
      view.step_reason = "the one of five over which the values spread most";
    }
  }
  view.step = shown->step;
  Looked looked;
  const std::optional<UnlikeAxis> unlike = unlike_axis(*shown);
  const std::optional<Dataset> scaled = unlike ? std::optional(scaled_dataset(*shown, unlike->scale)) : std::nullopt;
  const Dataset& seen = scaled ? *scaled : *shown;
  if (shown->grid.cell_count() > 0) looked = choose(seen, ranked, view, task);
  if (!looked.array) {
    view.array.clear();
    view.array_reason = nothing_to_show(*shown);
    if (!wishes.array.empty() && shown->grid.cell_count() > 0)
      view.array_reason = "array '" + wishes.array + "' has one value everywhere, or none";
    return view;
  }
  ValueRange range;
  for (const Dataset* step : looked_at)
    if (const PointArray* array = find(*step, view.array); array && array->lower <= array->upper)
      range = join(range, {array->lower, array->upper});
  look_at(view, seen, looked, range, unlike.has_value());
  if (unlike) {
    view.axis_scale = unlike->scale;
    const std::string& unit = shown->axes[static_cast<std::size_t>(unlike->axis)].unit;
    view.scale_reason = std::string(1, "xyz"[unlike->axis]) + " is in another unit than the others, " + (axis_of_other_unit(shown->axes) < 0 ? "by its length" : unit.empty() ? "not in degrees" : unit);
  }
  return view;
}

}  // namespace

FirstView first_view(const Dataset& first, const FirstViewSteps& steps, const FirstViewWishes& wishes, const Task& task) {
  const bool free = wishes.array.empty() && wishes.step < 0;
  if (auto kept = free ? kept_first_view(first) : std::nullopt) return std::move(*kept);
  FirstView view = choose_view(first, steps, wishes, task);
  if (free && !view.array.empty()) keep_first_view(first, view);
  return view;
}

FirstView first_view(const Dataset& dataset, const FirstViewWishes& wishes, const Task& task) {
  FirstViewWishes here = wishes;
  here.step = dataset.step;
  FirstView view = first_view(
      dataset,
      [](int, const Task&) -> std::shared_ptr<const Dataset> { throw Error(ErrorCode::internal, "first_view: one step"); }, here,
      task);
  view.step_reason = "the one that is looked at";
  return view;
}

}  // namespace isostrata
