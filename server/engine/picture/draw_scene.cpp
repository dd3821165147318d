#include "engine/picture/draw_scene.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "base/stopwatch.h"
#include "extraction/bricks/layer_bricks.h"
#include "extraction/cells/structured_points.h"
#include "extraction/intervals/extract_intervals.h"
#include "extraction/laws/volume_error.h"
#include "extraction/layers/extract_at_time.h"
#include "extraction/layers/join_meshes.h"
#include "extraction/layers/own_points.h"
#include "extraction/surfaces/gradient_normals.h"
#include "rendering/picture/lit_surfaces.h"
#include "scene/color_range.h"

namespace isostrata {
namespace {

const std::string& first_array(const Dataset& dataset) {
  if (dataset.arrays.empty()) throw Error(ErrorCode::not_found, dataset.name + ": no point array; expected at least one");
  return dataset.arrays.front().name;
}

bool uses_color_values(const Scene& scene) {
  return std::any_of(scene.intervals.begin(), scene.intervals.end(),
                     [](const SceneInterval& of) { return !of.color_map.empty() || of.opacity_upper; }) ||
         std::any_of(scene.terms.begin(), scene.terms.end(), [](const SceneTerm& of) { return !of.color_map.empty(); });
}

bool uses_texture(const Scene& scene) {
  return std::any_of(scene.intervals.begin(), scene.intervals.end(),
                     [](const SceneInterval& of) { return of.surface.drawn() && !of.surface.texture.empty(); });
}

/// The layers are ranges of one array at one step, and what the table makes of them.
bool of_plain_ranges(const Scene& scene) {
  return !scene.intervals.empty() && scene.terms.empty() && !scene.time && scene.mode != SceneMode::smear && scene.values == FieldValues::interpolated &&
         scene.triangulation == Triangulation::table;
}

bool brings_in(const SceneTerm& term) {
  return term.term.op == RangeOperator::unite || term.term.op == RangeOperator::exclusive_or;
}

/// Whether another array can be brought to the finished mesh: its points know what they lie on, in the grid of one step.
bool can_carry(const ExtractedScene& extracted) {
  const IntervalMesh& mesh = *extracted.mesh;
  return extracted.time.first == extracted.time.second && extracted.request.values == FieldValues::interpolated &&
         mesh.origins.size() + mesh.inner.first.size() - 1 == mesh.positions.size();
}

/// The dataset is immutable and one object per time step, so the identity of those that were used stands for dataset and steps.
bool same_mesh(const ExtractedScene& previous, const LayerRequest& request, const StepSource& steps, const Task& task) {
  LayerRequest wanted = request;
  wanted.facets = wanted.facets || previous.request.facets;  // more than is asked for does no harm
  wanted.normals = wanted.normals || previous.request.normals;
  wanted.tetrahedra = wanted.tetrahedra || previous.request.tetrahedra;
  return previous.request == wanted && std::all_of(previous.steps.begin(), previous.steps.end(),
                                                   [&](const auto& used) { return steps(used->step, task) == used; });
}

using Values = std::shared_ptr<const std::vector<float>>;

/// Values at the points of a mesh whose cells have points of their own.
std::vector<float> at_own_points(const OwnPoints& own, const MeshArray& array) {
  std::vector<float> values(own.point.size());
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = array.values[array.in_cells ? own.simplex[i] : own.point[i]];
  return values;
}

/// Returns the carried arrays, in the order of the request.
std::vector<Values> extract(ExtractedScene& made, const LayerRequest& request, const StepSource& steps, const Task& task,
                            LayerAids aids) {
  if (request.intervals.empty()) {
    made.dataset = steps(request.step, task);
    made.time.first = made.time.second = request.step;
    made.dataset->array(request.array);
    auto mesh = std::make_shared<IntervalMesh>();
    mesh->cells = made.dataset->grid.cell_count();
    made.mesh = std::move(mesh);
    return std::vector<Values>(request.carry.size(), std::make_shared<const std::vector<float>>());
  }
  if (made.kept) aids.kept = made.kept.get();
  Layers layers = extract_layers(request, steps, task, aids);
  made.dataset = std::move(layers.dataset);
  made.time = layers.time;
  if (std::any_of(layers.carried.begin(), layers.carried.end(), [](const MeshArray& array) { return array.in_cells; })) {
    OwnPoints own = with_own_points(layers.mesh, request.max_bytes);
    for (MeshArray& array : layers.carried) array = {array.name, at_own_points(own, array), false};
    layers.mesh = std::move(own.mesh);
  }
  made.mesh = std::make_shared<const IntervalMesh>(std::move(layers.mesh));
  made.normals_wanted = request.normals;
  if (!layers.normals.empty()) made.normals = std::make_shared<const std::vector<Vec3f>>(std::move(layers.normals));
  std::vector<Values> carried;
  for (MeshArray& array : layers.carried) carried.push_back(std::make_shared<const std::vector<float>>(std::move(array.values)));
  return carried;
}

/// The gradient of an array that is not in the dataset at that time (a slice's, say) is not known.
void add_normals(ExtractedScene& made, const Task& task) {
  made.normals_wanted = true;
  const auto& arrays = made.dataset->arrays;
  const auto found = std::find_if(arrays.begin(), arrays.end(), [&](const PointArray& a) { return a.name == made.array; });
  if (found == arrays.end()) return;
  std::vector<Vec3f> normals = gradient_normals(made.dataset->grid, *found, *made.mesh, task);
  if (!normals.empty()) made.normals = std::make_shared<const std::vector<Vec3f>>(std::move(normals));
}

/// Of what is drawn: of whole cells theirs, which points' means do not reach.
void set_range(const PointArray& array, FieldValues values, double& lower, double& upper) {
  const bool whole = values == FieldValues::whole && array.cells;
  const double least = whole ? array.cells->lower : array.lower, most = whole ? array.cells->upper : array.upper;
  if (!(least <= most)) return;
  lower = least;
  upper = most;
}

template <class T>
std::shared_ptr<const std::vector<T>> joined(std::span<const std::shared_ptr<const ExtractedScene>> parts,
                                             std::shared_ptr<const std::vector<T>> ExtractedScene::*member) {
  std::vector<T> all;
  for (const auto& part : parts) {
    const auto& values = (*part).*member;
    if (!values) return nullptr;
    all.insert(all.end(), values->begin(), values->end());
  }
  return std::make_shared<const std::vector<T>>(std::move(all));
}

bool same_shape(const Grid& a, const Grid& b) {
  const auto* ua = std::get_if<UniformGrid>(&a.shape);
  const auto* ub = std::get_if<UniformGrid>(&b.shape);
  if (ua && ub) return ua->dims == ub->dims && ua->origin == ub->origin && ua->spacing == ub->spacing;
  const auto* ra = std::get_if<RectilinearGrid>(&a.shape);
  const auto* rb = std::get_if<RectilinearGrid>(&b.shape);
  return ra && rb && ra->axes == rb->axes;
}

struct ArrayNames {
  std::string color_by, texture;
};
/// Of a scene whose layers are those of `array`.
ArrayNames names_of(const Scene& scene, const std::string& array) {
  const std::string& color_by = scene.color_by.empty() ? array : scene.color_by;
  return {color_by, scene.texture.empty() ? color_by : scene.texture};
}

/// layer_request of the array that a scene without one stands for.
LayerRequest request_for(const Scene& scene, const std::string& array) {
  LayerRequest request;
  request.array = array;
  for (const SceneInterval& interval : scene.intervals) request.intervals.push_back({interval.lower, interval.upper});
  for (const SceneTerm& term : scene.terms) request.terms.push_back(term.term);
  request.time = scene.time;
  if (scene.time)
    request.time_mode = scene.time_mode;
  else
    request.step = scene.step;
  request.triangulation = scene.triangulation;
  request.values = scene.values;
  const auto [color_by, texture] = names_of(scene, array);
  if (uses_color_values(scene)) request.carry.push_back(color_by);
  if (uses_texture(scene) && (request.carry.empty() || texture != color_by)) request.carry.push_back(texture);
  request.facets = draws_surfaces(scene) || !uses_color_values(scene);
  request.normals = lights_along_gradient(scene) && !scene.terms.empty();
  if (const std::vector<SmearMoment> moments = smear_moments(scene); !moments.empty()) {
    request.step = moments.front().step;
    request.time = moments.front().time;
    request.time_mode = request.time ? scene.time_mode : TimeMode::step;
  }
  return request;
}

std::int64_t tetrahedra_of(const ExtractedScene& extracted) {
  std::int64_t sum = 0;
  for (const IntervalSummary& summary : extracted.summaries()) sum += summary.tetrahedra;
  return sum;
}

std::shared_ptr<const ExtractedScene> extract_smear(const StepSource& source, const Scene& scene,
                                                    const std::vector<SmearMoment>& wanted,
                                                    const std::shared_ptr<const ExtractedScene>& previous, const Task& task,
                                                    SceneAids aids) {
  const Stopwatch watch;
  aids.bricks = nullptr;  // it remembers one array, not one a step
  if (previous && previous->parts.size() == wanted.size() &&
      std::equal(wanted.begin(), wanted.end(), previous->parts.begin(),
                 [](const SmearMoment& moment, const SmearPart& part) { return moment == part.moment; })) {
    LayerRequest request = request_for(scene, scene.array.empty() ? previous->request.array : scene.array);
    const ArrayNames names = names_of(scene, request.array);
    const std::string& texture = names.texture;
    const bool colored = !uses_color_values(scene) || (previous->color_values && names.color_by == previous->color_by);
    const bool textured = !uses_texture(scene) || (previous->texture_values && texture == previous->texture);
    request.carry.clear();
    if (colored && textured && same_mesh(*previous, request, source, task)) {
      if (previous->extract_ms == 0) return previous;
      auto again = std::make_shared<ExtractedScene>(*previous);
      again->extract_ms = 0;
      return again;
    }
  }

  std::vector<std::shared_ptr<const ExtractedScene>> parts;
  const std::uint64_t max_bytes = std::min(layer_request(scene).max_bytes, aids.max_bytes);
  std::uint64_t bytes = 0;
  for (const SmearMoment& moment : wanted) {
    Scene one = scene;
    one.mode = SceneMode::sorted;
    one.step = moment.step;
    one.time = moment.time;
    parts.push_back(extract_scene(source, one, nullptr, task, aids));
    bytes += mesh_bytes(*parts.back()->mesh);
    // All parts and the joined mesh are there at once. Steps are much alike, so the first ones tell of the others.
    const std::uint64_t foreseen = 2 * (bytes / parts.size()) * wanted.size();
    if (foreseen > max_bytes)
      throw Error(ErrorCode::too_large, "a smear of " + std::to_string(wanted.size()) + " steps or times needs about " +
                                            std::to_string(foreseen >> 20) + " MiB; " + std::to_string(max_bytes >> 20) +
                                            " MiB are allowed");
  }
  auto made = std::make_shared<ExtractedScene>(*parts.front());
  made->steps.clear();
  std::vector<const IntervalMesh*> meshes;
  for (std::size_t i = 0, summaries = 0; i < parts.size(); ++i) {
    made->steps.insert(made->steps.end(), parts[i]->steps.begin(), parts[i]->steps.end());
    made->parts.push_back({wanted[i], summaries});
    summaries += parts[i]->mesh->summaries.size();
    made->bounds.include(parts[i]->bounds.lower);
    made->bounds.include(parts[i]->bounds.upper);
    made->same_grid = made->same_grid && same_shape(parts[i]->dataset->grid, made->dataset->grid);
    meshes.push_back(parts[i]->mesh.get());
  }
  made->mesh = std::make_shared<const IntervalMesh>(join_meshes(meshes, max_bytes));
  made->color_values = joined(parts, &ExtractedScene::color_values);
  made->texture_values = joined(parts, &ExtractedScene::texture_values);
  made->normals = joined(parts, &ExtractedScene::normals);
  made->extract_ms = watch.elapsed_ms();
  return made;
}

/// Whether only the ends of the intervals were moved since `last`, as in a drag.
bool ends_moved(const ExtractedScene* last, LayerRequest request) {
  if (!last) return false;
  request.tetrahedra = last->request.tetrahedra;
  request.facets = last->request.facets;
  request.normals = last->request.normals;
  request.intervals = last->request.intervals;
  return last->request == request;
}

/// Fills `made` with the grid of tetrahedra as it is, where the renderer can cut the intervals out of it and that is wanted.
bool cut_instead(ExtractedScene& made, const Scene& scene, const LayerRequest& request,
                 const std::shared_ptr<const ExtractedScene>& last, const StepSource& steps, const SceneAids& aids,
                 const Task& task) {
  if (!aids.bases || aids.tetrahedra == TetrahedraWay::split || !cuts_exactly(scene, request.array)) return false;
  const auto dataset = steps(request.step, task);
  if (!only_tetrahedra(*dataset)) return false;
  if (aids.tetrahedra == TetrahedraWay::automatic) {
    if (!ends_moved(last.get(), request)) return false;
    made.base = aids.bases->find(dataset, request.array);
  } else {
    made.base = aids.bases->make(dataset, request.array, task);
  }
  const auto is_resolved = [&](const Interval& interval) { return resolves(*made.base, interval); };
  if (!made.base || !std::all_of(request.intervals.begin(), request.intervals.end(), is_resolved)) {
    made.base = nullptr;
    return false;
  }
  made.dataset = dataset;
  made.time.first = made.time.second = request.step;
  made.mesh = made.base->mesh;
  made.color_values = made.base->values;
  made.cut_summaries = measure_intervals(*made.base, request.intervals);
  set_range(dataset->array(made.color_by), request.values, made.color_lower, made.color_upper);
  set_range(dataset->array(made.texture), request.values, made.texture_lower, made.texture_upper);
  made.bounds = dataset->bounds;
  made.request = request;
  return true;
}

/// From how many tetrahedra on the scene's layers are left to the renderer as bricks; nothing if they never are.
std::optional<std::int64_t> least_in_bricks(const Scene& scene, const std::string& array, const Grid& grid, const SceneAids& aids) {
  if (!aids.bricks) return std::nullopt;
  if (aids.extracts_there && grid.rectilinear() && draws_where_extracted(scene, array)) return kLeastExtractedThere;
  if (aids.least_in_bricks == std::numeric_limits<std::int64_t>::max() || !draws_from_bricks(scene)) return std::nullopt;
  return aids.least_in_bricks;
}

/// Fills `made` with the bricks that the layers lie in, where the renderer needs no more and a mesh would be large.
bool bricks_instead(ExtractedScene& made, const Scene& scene, const LayerRequest& request, const ExtractedScene* last, const StepSource& steps,
                    const SceneAids& aids, const Task& task) {
  const auto dataset = steps(request.step, task);
  const PointArray& array = dataset->array(request.array);
  const auto least = least_in_bricks(scene, request.array, dataset->grid, aids);
  if (!least) return false;
  const std::uint64_t bytes = std::visit([](auto values) { return values.size_bytes(); }, array.values);
  if (!draws_from_bricks(scene) && bytes > kMostSentAtOnce && !ends_moved(last, request)) return false;
  auto found = find_layer_bricks(dataset, array, request.intervals, *aids.bricks, *least, std::min(request.max_bytes, aids.max_bytes), task);
  if (!found) return false;
  made.dataset = dataset;
  made.time.first = made.time.second = request.step;
  made.mesh = std::make_shared<const IntervalMesh>(std::move(found->mesh));
  made.bricks = std::move(found->bricks);
  set_range(dataset->array(made.color_by), request.values, made.color_lower, made.color_upper);
  set_range(dataset->array(made.texture), request.values, made.texture_lower, made.texture_upper);
  made.bounds = dataset->bounds;
  made.request = request;
  return true;
}

/// own_array: its ends are ends of the colours' values.
IntervalStyle style_of(const Scene& scene, const SceneInterval& interval, const ExtractedScene& extracted, bool own_array) {
  IntervalStyle style;
  style.color = interval.color;
  SceneInterval closed = interval;  // an end that is open is where the array's range ends
  if (!std::isfinite(closed.lower)) closed.lower = std::min(extracted.color_lower, closed.upper);
  if (!std::isfinite(closed.upper)) closed.upper = std::max(extracted.color_upper, closed.lower);
  if (closed.whole && !(std::isfinite(closed.whole->lower) && std::isfinite(closed.whole->upper)))
    closed.whole = Interval{closed.lower, closed.upper};
  set_colors(style, closed, scene.color_range, extracted.color_lower, extracted.color_upper, own_array);
  style.priority = interval.priority;
  style.visible = interval.visible;
  style.surface = interval.surface;
  style.surface.texture_lower = extracted.texture_lower;
  style.surface.texture_upper = extracted.texture_upper;
  return style;
}

IntervalStyle style_of(const Scene& scene, const SceneTerm& term, const SceneInterval& first, const ExtractedScene& extracted) {
  SceneInterval like = first;
  if (term.color || !term.color_map.empty()) like.color_map = term.color_map;
  if (term.color) like.color = *term.color;
  if (scene.color_range.log && !like.own_range && !like.whole) like.whole = {{like.lower, like.upper}};
  // Its values lie anywhere, not between the first interval's ends.
  IntervalStyle style = style_of(scene, like, extracted, false);
  if (term.opacity) style.opacity = *term.opacity, style.opacity_upper.reset();
  if (term.priority) style.priority = *term.priority;
  style.visible = term.visible;
  return style;
}

/// An area is drawn as a surface: as opaque as the interval, in its very colours if the grid lies in a plane along two axes,
/// shaded if it is bent. A surface that was asked for keeps its looks.
SurfaceStyle area_surface(const IntervalStyle& style, const Box3d& bounds) {
  SurfaceStyle surface = style.surface;
  surface.domain = true;
  if (style.surface.drawn()) return surface;
  const Vec3d size = bounds.upper - bounds.lower;
  const bool plane = std::min({size.x, size.y, size.z}) <= 1e-9 * bounds.diagonal();
  surface.opacity = style.opacity;
  surface.ambient = plane ? 1 : 0.35;
  surface.diffuse = plane ? 0 : 0.65;
  surface.specular = 0;
  return surface;
}

/// Of the intervals and of what terms bring in, as one step has them.
std::vector<IntervalStyle> styles_of(const Scene& scene, const ExtractedScene& extracted, std::span<const IntervalSummary> of) {
  std::vector<IntervalStyle> styles;
  for (const SceneInterval& interval : scene.intervals)
    styles.push_back(style_of(scene, interval, extracted, extracted.color_by == extracted.array));
  for (std::size_t i = scene.intervals.size(); i < of.size(); ++i) {
    const auto term = static_cast<std::size_t>(of[i].term);
    styles.push_back(style_of(scene, scene.terms.at(term), scene.intervals.front(), extracted));
  }
  return styles;
}

/// Whether the i-th and the one before it are parts of one interval (drawn_scene).
bool continues(const Scene& scene, std::size_t i) {
  return i > 0 && i < scene.intervals.size() && scene.intervals[i].id == scene.intervals[i - 1].id;
}

/// Leaves one of the visible intervals visible.
void show_phase(const Scene& scene, std::vector<IntervalStyle>& styles) {
  const double phase = scene.cycle.phase;
  std::ptrdiff_t visible = 0;
  for (std::size_t i = 0; i < styles.size(); ++i) visible += styles[i].visible && !continues(scene, i) ? 1 : 0;
  if (visible == 0) return;
  auto shown = static_cast<std::ptrdiff_t>(std::fmod(std::floor(std::isfinite(phase) ? phase : 0), static_cast<double>(visible)));
  if (shown < 0) shown += visible;
  std::ptrdiff_t at = -1;
  for (std::size_t i = 0; i < styles.size(); ++i) {
    if (!styles[i].visible) continue;
    if (!continues(scene, i)) ++at;
    styles[i].visible = at == shown;
  }
}

/// The parts of a transfer function as one entry, with a ramp of as many colours as a ramp may have.
LegendEntry joined_entry(std::span<const LegendEntry> parts) {
  constexpr std::size_t kColors = 16;
  LegendEntry whole = parts.front();
  whole.upper = parts.back().upper;
  IntervalStyle& style = whole.style;
  if (std::all_of(parts.begin(), parts.end(),
                  [&](const LegendEntry& of) { return of.style.color_map.empty() && of.style.color == style.color; }))
    return whole;
  if (whole.log) return whole;  // all parts have its map and its range
  style.color_map.clear();
  for (std::size_t i = 0, part = 0; i < kColors; ++i) {
    const double value = whole.lower + (whole.upper - whole.lower) * static_cast<double>(i) / (kColors - 1);
    while (part + 1 < parts.size() && value > parts[part].upper) ++part;
    const IntervalStyle& of = parts[part].style;
    const double t = std::clamp((value - parts[part].lower) / (parts[part].upper - parts[part].lower), 0.0, 1.0);
    const Rgb color = of.color_map.empty() ? of.color : sample(color_map(of.color_map), static_cast<float>(t));
    style.color_map += (i ? "-" : "") + format_rgb(color);
  }
  style.color_lower = whole.lower;
  style.color_upper = whole.upper;
  return whole;
}

std::string moment_name(const SmearMoment& moment) {
  if (!moment.time) return "step " + std::to_string(moment.step);
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "t = %g", *moment.time);
  return text.data();
}

/// Each step or time in one colour, over those before it.
std::vector<IntervalStyle> smear_styles(const Scene& scene, const ExtractedScene& extracted) {
  std::vector<IntervalStyle> all;
  const std::span<const IntervalSummary> summaries = extracted.summaries();
  for (std::size_t part = 0; part < extracted.parts.size(); ++part) {
    const std::size_t first = extracted.parts[part].first_summary;
    const std::size_t end = part + 1 < extracted.parts.size() ? extracted.parts[part + 1].first_summary : summaries.size();
    for (IntervalStyle& style : styles_of(scene, extracted, summaries.subspan(first, end - first))) {
      style.color = part < scene.smear.colors.size() ? scene.smear.colors[part] : default_interval_color(part);
      style.color_map.clear();
      style.surface.own_color = false;
      style.priority = static_cast<int>(part);
      all.push_back(std::move(style));
    }
  }
  return all;
}

}  // namespace

std::vector<SmearMoment> smear_moments(const Scene& scene) {
  if (scene.mode != SceneMode::smear) return {};
  std::vector<SmearMoment> moments;
  for (const double time : scene.smear.times) moments.push_back({scene.step, time});
  if (!moments.empty()) return moments;
  for (const int step : scene.smear.steps) moments.push_back({step, {}});
  if (moments.empty()) moments.push_back({scene.step, {}});
  return moments;
}

std::size_t cycle_length(const Scene& scene) {
  const auto visible = [](const auto& of) { return of.visible; };
  return static_cast<std::size_t>(
      std::count_if(scene.intervals.begin(), scene.intervals.end(), visible) +
      std::count_if(scene.terms.begin(), scene.terms.end(), [](const SceneTerm& of) { return of.visible && brings_in(of); }));
}

std::vector<IntervalSummary> interval_summaries(const ExtractedScene& extracted, const Scene& scene) {
  const auto& all = extracted.summaries();
  const std::size_t n = std::min(scene.intervals.size(), all.size());
  std::vector<IntervalSummary> sums(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(n));
  for (std::size_t part = 1; part < extracted.parts.size(); ++part)
    for (std::size_t i = 0; i < n; ++i) {
      const IntervalSummary& more = all[extracted.parts[part].first_summary + i];
      sums[i].active_cells += more.active_cells;
      sums[i].tetrahedra += more.tetrahedra;
      sums[i].volume += more.volume;
      sums[i].signed_volume += more.signed_volume;
      sums[i].inverted += more.inverted;
      sums[i].area += more.area;
    }
  return sums;
}

bool draws_from_bricks(const Scene& scene) { return of_plain_ranges(scene) && !uses_color_values(scene) && !uses_texture(scene); }

bool draws_where_extracted(const Scene& scene, const std::string& array) {
  return of_plain_ranges(scene) && 2 * scene.intervals.size() <= StructuredPoints::kMaxIsovalues && uses_color_values(scene) && names_of(scene, array).color_by == array &&
         !draws_surfaces(scene);
}

std::vector<IntervalFacts> interval_facts(const ExtractedScene& extracted, const Scene& scene, bool errors, const Task& task) {
  const auto summaries = interval_summaries(extracted, scene);
  std::vector<double> of_each;
  const bool whole = extracted.request.values == FieldValues::whole;
  const bool plain = extracted.parts.empty() && !whole && extracted.whole_summaries.empty() && extracted.request.terms.empty() && extracted.time.mode != TimeMode::spacetime;
  if (errors && (extracted.base || (whole && !extracted.dataset->grid.flat())))
    of_each.resize(summaries.size());  // cut exactly, or not at all
  else if (errors && plain && !summaries.empty() && !extracted.dataset->grid.flat())  // an area has no volume to be wrong about
    of_each = volume_errors(extracted.dataset->grid, extracted.dataset->array(extracted.array), *extracted.mesh, task);
  std::vector<IntervalFacts> facts;
  for (std::size_t i = 0; i < summaries.size(); ++i) {
    const std::uint32_t id = scene.intervals[i].id;
    if (facts.empty() || facts.back().id != id) facts.push_back({id, 0, 0, 0, std::nullopt, std::nullopt});
    IntervalFacts& of = facts.back();
    of.active_cells += summaries[i].active_cells;
    of.tetrahedra += summaries[i].tetrahedra;
    of.volume += summaries[i].signed_volume;
    if (i < of_each.size()) of.volume_error = of.volume_error.value_or(0) + of_each[i];
    if (extracted.dataset->grid.flat()) of.area = of.area.value_or(0) + summaries[i].area;
  }
  return facts;
}

bool draws_surfaces(const Scene& scene) {
  return std::any_of(scene.intervals.begin(), scene.intervals.end(), [](const SceneInterval& of) { return of.surface.drawn(); });
}

bool lights_along_gradient(const Scene& scene) {
  if (scene.values == FieldValues::whole) return false;  // its surfaces are faces of cells
  if (scene.mode == SceneMode::cycled || scene.mode == SceneMode::smear) return draws_surfaces(scene);  // what is drawn changes from picture to picture
  bool any = false, domain = false;
  const auto take = [&](const SurfaceStyle& surface, bool visible) {
    if (!visible || !surface.drawn()) return;
    any = true;
    domain = domain || surface.domain;
  };
  for (const SceneInterval& of : scene.intervals) take(of.surface, of.visible);
  for (const SceneTerm& of : scene.terms)
    if (brings_in(of) && !scene.intervals.empty()) take(scene.intervals.front().surface, of.visible);
  return any && !domain;
}

bool cuts_exactly(const Scene& scene, const std::string& array) {
  constexpr std::size_t kMostIntervals = 64;  // each is held against each block of tetrahedra
  // Where two intervals are at one place, their order within a ray's segment depends on how the mesh is split.
  std::vector<Interval> sorted;
  for (const SceneInterval& interval : scene.intervals) sorted.push_back({interval.lower, interval.upper});
  std::sort(sorted.begin(), sorted.end(), [](const Interval& a, const Interval& b) { return a.lower < b.lower; });
  for (std::size_t i = 1; i < sorted.size(); ++i)
    if (sorted[i].lower < sorted[i - 1].upper) return false;
  return scene.values == FieldValues::interpolated && !scene.intervals.empty() && scene.intervals.size() <= kMostIntervals && scene.terms.empty() && !scene.time &&
         scene.mode != SceneMode::smear && (!draws_surfaces(scene) || (!uses_color_values(scene) && !uses_texture(scene))) &&
         (!uses_color_values(scene) || scene.color_by.empty() || scene.color_by == array) &&
         std::all_of(scene.intervals.begin(), scene.intervals.end(), [](const SceneInterval& interval) {
           return interval.lower < interval.upper && std::isfinite(interval.lower) && std::isfinite(interval.upper);
         });
}

LayerRequest layer_request(const Scene& scene) { return request_for(scene, scene.array); }

bool same_extraction(const Scene& a, const Scene& b) {
  return a.dataset == b.dataset && layer_request(a) == layer_request(b) && smear_moments(a) == smear_moments(b) &&
         lights_along_gradient(a) == lights_along_gradient(b);
}

std::shared_ptr<const ExtractedScene> extract_scene(const StepSource& source, const Scene& scene,
                                                    const std::shared_ptr<const ExtractedScene>& previous, const Task& task,
                                                    const SceneAids& aids) {
  if (const std::vector<SmearMoment> smeared = smear_moments(scene); !smeared.empty())
    return extract_smear(source, scene, smeared, previous, task, aids);
  const std::shared_ptr<const ExtractedScene> last = previous && previous->parts.empty() ? previous : nullptr;
  const Stopwatch watch;
  auto made = std::make_shared<ExtractedScene>();
  const StepSource steps = [&](int step, const Task& of) {
    auto dataset = source(step, of);
    if (std::find(made->steps.begin(), made->steps.end(), dataset) == made->steps.end()) made->steps.push_back(dataset);
    return dataset;
  };
  LayerRequest request = request_for(scene, scene.array.empty() ? first_array(*steps(scene.step, task)) : scene.array);
  // A renderer that draws constant colours by facets needs no more of whole cells, of which a segmentation has millions.
  request.tetrahedra = scene.values == FieldValues::interpolated || uses_color_values(scene) || uses_texture(scene) || scene.mode == SceneMode::smear ||
                       !aids.bricks || aids.least_in_bricks == std::numeric_limits<std::int64_t>::max();
  const auto names = names_of(scene, request.array);
  const std::string &color_by = names.color_by, &texture = names.texture;
  const bool colored = uses_color_values(scene), textured = uses_texture(scene), lit = lights_along_gradient(scene);
  LayerRequest plain = request;
  plain.carry.clear();

  const bool keep = last && !last->base && !last->bricks && same_mesh(*last, plain, source, task);
  const Values kept_colors = keep && last->color_by == color_by ? last->color_values : nullptr;
  const Values kept_texture = keep && last->texture == texture ? last->texture_values : nullptr;
  const bool has_values = (kept_colors || !colored) && (kept_texture || !textured);
  const bool same_split =
      keep && last->color_by == color_by && last->texture == texture && has_values && (last->normals_wanted || !lit);
  const bool same_cut = last && last->base && aids.tetrahedra != TetrahedraWay::split && cuts_exactly(scene, request.array) &&
                        last->color_by == color_by && same_mesh(*last, plain, source, task);
  const auto least = last && last->bricks ? least_in_bricks(scene, request.array, last->dataset->grid, aids) : std::nullopt;
  const bool same_bricks = least && *least <= tetrahedra_of(*last) && same_mesh(*last, plain, source, task);
  if (same_split || same_cut || (same_bricks && last->color_by == color_by && last->texture == texture)) {
    if (last->extract_ms == 0) return last;
    *made = *last;
    made->extract_ms = 0;
    return made;
  }
  made->array = request.array;
  made->color_by = color_by;
  made->texture = texture;
  if (!keep && cut_instead(*made, scene, plain, last, steps, aids, task)) {
    made->extract_ms = watch.elapsed_ms();
    return made;
  }
  if (!keep && bricks_instead(*made, scene, plain, last.get(), steps, aids, task)) {
    made->extract_ms = watch.elapsed_ms();
    return made;
  }
  if (keep && (has_values || can_carry(*last))) {
    made->steps = last->steps;
    made->dataset = last->dataset;
    made->time = last->time;
    made->kept = last->kept;
    made->mesh = last->mesh;
    made->normals = last->normals;
    made->normals_wanted = last->normals_wanted;
    const auto carried = [&](const std::string& name) {
      return std::make_shared<const std::vector<float>>(carry_array(*made->mesh, made->steps.front()->array(name)));
    };
    if (colored) made->color_values = kept_colors ? kept_colors : carried(color_by);
    if (textured)
      made->texture_values = kept_texture ? kept_texture : colored && texture == color_by ? made->color_values : carried(texture);
    plain.facets = last->request.facets;
    plain.tetrahedra = last->request.tetrahedra;
    plain.normals = last->request.normals;
  } else {
    if (request.time_mode == TimeMode::spacetime)
      made->kept = last && last->kept ? last->kept : std::make_shared<KeptSpaceTime>();
    LayerRequest limited = request;
    limited.max_bytes = std::min(limited.max_bytes, aids.max_bytes);
    const std::vector<Values> carried = extract(*made, limited, steps, task, aids);
    if (colored) made->color_values = carried.front();
    if (textured) made->texture_values = carried.back();
  }
  if (lit && !made->normals_wanted && !made->dataset->grid.flat()) add_normals(*made, task);
  set_range(made->steps.front()->array(color_by), scene.values, made->color_lower, made->color_upper);
  set_range(made->steps.front()->array(texture), scene.values, made->texture_lower, made->texture_upper);
  made->bounds = made->dataset->bounds;
  made->request = std::move(plain);
  made->extract_ms = watch.elapsed_ms();
  return made;
}

std::shared_ptr<const ExtractedScene> extract_scene(std::shared_ptr<const Dataset> dataset, const Scene& scene,
                                                    const std::shared_ptr<const ExtractedScene>& previous, const Task& task) {
  const StepSource one = [dataset](int step, const Task&) {
    if (step != dataset->step)
      throw Error(ErrorCode::not_found, dataset->name + ": step " + std::to_string(step) + " is asked for; only step " +
                                            std::to_string(dataset->step) + " is at hand");
    return dataset;
  };
  return extract_scene(one, scene, previous, task);
}

std::uint64_t scene_bytes(const ExtractedScene& extracted) {
  const auto bytes = [](const auto& values) -> std::uint64_t { return values ? values->size() * sizeof((*values)[0]) : 0; };
  if (extracted.base) return 0;  // everybody's
  if (extracted.bricks) return extracted.bricks->bytes();
  // What is drawn is the mesh's points and tetrahedra, or its facets, once more.
  return 2 * mesh_bytes(*extracted.mesh) + bytes(extracted.color_values) + bytes(extracted.texture_values) + bytes(extracted.normals) +
         extracted.time.bytes;
}

DrawInput draw_input(const ExtractedScene& extracted, const Scene& scene, int width, int height) {
  DrawInput input;
  input.grid = extracted.same_grid ? &extracted.dataset->grid : nullptr;
  input.bounds = extracted.bounds;
  input.mesh = extracted.mesh;
  input.color_values = extracted.color_values;
  input.base = extracted.base;
  input.bricks = extracted.bricks;
  if (extracted.base) input.cut_intervals = extracted.request.intervals;
  input.styles = extracted.parts.empty() ? styles_of(scene, extracted, extracted.summaries()) : smear_styles(scene, extracted);
  if (extracted.dataset->grid.flat())
    for (IntervalStyle& style : input.styles) style.surface = area_surface(style, extracted.dataset->bounds);
  if (scene.mode == SceneMode::cycled) show_phase(scene, input.styles);
  input.mode =
      scene.mode == SceneMode::prioritized || scene.mode == SceneMode::smear ? RenderMode::prioritized : RenderMode::sorted;
  input.integral = scene.integral;
  if (lit_along_gradient(input)) input.normals = extracted.normals;
  input.texture_values = extracted.texture_values;
  input.camera = scene.camera ? *scene.camera : view_of(input.bounds, "reset", static_cast<double>(width) / height);
  input.width = width;
  input.height = height;
  input.unit_distance = scene.unit_distance;
  input.background = scene.background;
  input.clip_planes = scene.clip_planes;
  return input;
}

AnnotationInput annotation_input(const ExtractedScene& extracted, const Scene& scene, const DrawInput& input) {
  AnnotationInput out;
  out.show = scene.annotations;
  out.bounds = input.bounds;
  out.camera = input.camera;
  out.width = input.width;
  out.height = input.height;
  out.background = input.background;
  out.transparent = input.transparent;
  out.array = extracted.array;
  out.color_by = extracted.color_by;
  std::vector<LegendEntry> parts_of_last;
  const auto end_last = [&] {
    if (!parts_of_last.empty())
      out.entries.push_back(parts_of_last.size() == 1 ? parts_of_last.front() : joined_entry(parts_of_last));
  };
  for (std::size_t i = 0; i < input.styles.size() && i < extracted.summaries().size(); ++i) {
    const IntervalSummary& summary = extracted.summaries()[i];
    LegendEntry entry{summary.interval.lower, summary.interval.upper, {}, input.styles[i]};
    std::size_t of = i;  // within its step
    const SmearPart* part = nullptr;
    for (const SmearPart& candidate : extracted.parts)
      if (i >= candidate.first_summary) part = &candidate, of = i - candidate.first_summary;
    if (of < scene.intervals.size()) {
      entry.name = scene.intervals[of].name;
      const ColorRange colors =
          colors_shown(scene.intervals[of], scene.color_range, extracted.color_lower, extracted.color_upper);
      if (colors.log) {  // the map itself, over all that the logarithm runs over
        entry.style.color_map = scene.intervals[of].color_map;
        entry.style.color_lower = colors.lower;
        entry.style.color_upper = colors.upper;
        entry.log = true;
      }
    }
    if (of >= scene.intervals.size() && summary.term >= 0)
      entry.name = scene.terms.at(static_cast<std::size_t>(summary.term)).term.array;
    if (part) entry.name += (entry.name.empty() ? "" : ", ") + moment_name(part->moment);
    if (continues(scene, of))
      parts_of_last.push_back(std::move(entry));
    else
      end_last(), parts_of_last = {std::move(entry)};
  }
  end_last();
  return out;
}

}  // namespace isostrata
