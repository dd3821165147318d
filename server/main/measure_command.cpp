// measure: what each layer, or each of its pieces, holds; components: its pieces, the largest first.
#include <algorithm>
#include <boost/json.hpp>
#include <cmath>
#include <cstdio>
#include <memory>
#include <numeric>
#include <string>
#include <vector>

#include "base/parallel.h"
#include "extraction/laws/volume_error.h"
#include "extraction/layers/extract_layers.h"
#include "extraction/measure/measure_layers.h"
#include "main/arguments.h"
#include "main/commands.h"
#include "main/json_number.h"
#include "main/mesh_arguments.h"

namespace isostrata {
namespace {

namespace json = boost::json;

struct MeasureArguments : MeshArguments {
  std::string by;
  std::vector<std::string> of;
  double min_volume = 0;
  bool all_steps = false, csv = false;
};

/// The layers of one step, measured.
struct Measured {
  Layers layers;
  std::vector<Interval> intervals;  // of the rows' intervals
  Components components;
  std::vector<LayerMeasure> rows;
  std::vector<double> errors;  // [intervals] of the volumes, if they can be told
};

Measured measure(LayerRequest request, const StepSource& steps, bool by_component, bool warn = true) {
  open_for(request, steps, warn);
  Measured made;
  made.layers = extract_layers(request, steps, command_task());
  const IntervalMesh& mesh = made.layers.mesh;
  for (const IntervalSummary& summary : mesh.summaries) made.intervals.push_back(summary.interval);
  if (by_component) made.components = find_components(mesh, command_task());
  made.rows = measure_layers(mesh, made.layers.carried, by_component ? &made.components : nullptr, command_task());
  const bool plain = request.terms.empty() && !request.time && request.values == FieldValues::interpolated && request.triangulation == Triangulation::table;
  if (plain && !by_component && !mesh.tetrahedra.empty()) {
    const Dataset& of = *made.layers.dataset;
    made.errors = volume_errors(of.grid, of.array(request.array), mesh, command_task());
  }
  return made;
}

json::array place_json(Vec3d v) { return {json_number(v.x), json_number(v.y), json_number(v.z)}; }
json::value box_json(const Box3d& box) {
  if (box.empty()) return nullptr;
  return json::array{json::array{box.lower.x, box.upper.x}, json::array{box.lower.y, box.upper.y}, json::array{box.lower.z, box.upper.z}};
}

json::object to_json(const Measured& made, const LayerMeasure& row, const std::vector<std::string>& names) {
  json::object of;
  for (std::size_t i = 0; i < names.size(); ++i)
    of[names[i]] = json::object{{"min", json_number(row.of[i].min)}, {"mean", json_number(row.of[i].mean)}, {"max", json_number(row.of[i].max)}, {"deviation", json_number(row.of[i].deviation)}, {"integral", json_number(row.of[i].integral)}};
  const Interval& interval = made.intervals[row.interval];
  return {{"lower", json_number(interval.lower)},
          {"upper", json_number(interval.upper)},
          {"component", row.component ? json::value(*row.component + 1) : json::value(nullptr)},
          {"tetrahedra", row.tetrahedra},
          {"volume", row.volume},
          {"volume_error", made.errors.empty() ? json::value(nullptr) : json::value(made.errors[row.interval])},
          {"area", json::object{{"lower", row.area.lower}, {"upper", row.area.upper}, {"domain", row.area.domain}, {"contact", row.area.contact}}},
          {"centroid", row.bounds.empty() ? json::value(nullptr) : json::value(place_json(row.centroid))},
          {"axes", json::array{place_json(row.axes[0]), place_json(row.axes[1]), place_json(row.axes[2])}},
          {"bounds", box_json(row.bounds)},
          {"of", std::move(of)}};
}

std::string csv_name(const std::string& name) {
  std::string text = "\"";
  for (const char letter : name) text += letter == '"' ? std::string("\"\"") : std::string(1, letter);
  return text + "\"";
}

void print_csv_head(const std::vector<std::string>& names) {
  std::printf("time,lower,upper,component,tetrahedra,volume,volume_error,area_lower,area_upper,area_domain,area_contact,centroid_x,centroid_y,centroid_z,x_min,x_max,y_min,y_max,z_min,z_max");
  for (const std::string& name : names)
    for (const char* what : {" min", " mean", " max", " deviation", " integral"}) std::printf(",%s", csv_name(name + what).c_str());
  std::printf("\n");
}

/// A number, or nothing if there is none.
void print_csv(double value) {
  if (std::isfinite(value))
    std::printf(",%.17g", value);
  else
    std::printf(",");
}

void print_csv(const Measured& made, double time) {
  for (const LayerMeasure& row : made.rows) {
    const Interval& interval = made.intervals[row.interval];
    std::printf("%.17g,%.17g,%.17g,", time, interval.lower, interval.upper);
    if (row.component) std::printf("%u", *row.component + 1);
    std::printf(",%lld", static_cast<long long>(row.tetrahedra));
    const double none = std::nan("");
    const bool empty = row.bounds.empty();
    for (const double value : {row.volume, made.errors.empty() ? none : made.errors[row.interval], row.area.lower, row.area.upper, row.area.domain, row.area.contact})
      print_csv(value);
    for (int axis = 0; axis < 3; ++axis) print_csv(empty ? none : row.centroid[axis]);
    for (int axis = 0; axis < 3; ++axis) print_csv(row.bounds.lower[axis]), print_csv(row.bounds.upper[axis]);
    for (const ArrayMeasure& of : row.of)
      for (const double value : {of.min, of.mean, of.max, of.deviation, of.integral}) print_csv(value);
    std::printf("\n");
  }
}

void print_text(const Measured& made, double time, const std::vector<std::string>& names) {
  std::printf("time %.12g\n", time);
  for (const LayerMeasure& row : made.rows) {
    const Interval& interval = made.intervals[row.interval];
    std::printf("  %g:%g", interval.lower, interval.upper);
    if (row.component) std::printf(", piece %u", *row.component + 1);
    if (row.bounds.empty()) {
      std::printf(": nothing lies in it\n");
      continue;
    }
    std::printf(": volume %.10g", row.volume);
    if (!made.errors.empty()) std::printf(" (cut straight; the interpolated field's differs by about %.2g)", made.errors[row.interval]);
    std::printf(", %lld tetrahedra\n    area      lower %.8g, upper %.8g, domain %.8g, of which %.8g touches another layer\n", static_cast<long long>(row.tetrahedra), row.area.lower,
                row.area.upper, row.area.domain, row.area.contact);
    Vec3d centroid = row.centroid;
    for (int axis = 0; axis < 3; ++axis)  // what rounding leaves of a middle at 0
      if (std::abs(centroid[axis]) < 1e-12 * row.bounds.diagonal()) centroid[axis] = 0;
    std::printf("    centroid  %.8g, %.8g, %.8g\n    bounds    x [%g, %g]  y [%g, %g]  z [%g, %g]\n", centroid.x, centroid.y, centroid.z, row.bounds.lower.x, row.bounds.upper.x,
                row.bounds.lower.y, row.bounds.upper.y, row.bounds.lower.z, row.bounds.upper.z);
    for (std::size_t i = 0; i < names.size(); ++i)
      std::printf("    %-9s min %.8g, mean %.8g (standard deviation %.4g), max %.8g, integral %.8g\n", names[i].c_str(), row.of[i].min, row.of[i].mean, row.of[i].deviation, row.of[i].max, row.of[i].integral);
  }
}

void run_measure(const MeasureArguments& arguments) {
  if (arguments.threads > 0) set_thread_count(arguments.threads);
  LayerRequest request = mesh_request(arguments);
  request.carry = arguments.of;
  const StepSource steps = step_source(arguments.file);
  int first = request.step, last = request.step;
  if (arguments.all_steps) {
    if (request.time) throw Error(ErrorCode::invalid_argument, "--all-steps and --time: expected one of them");
    first = 0;
    last = static_cast<int>(steps(request.step, command_task())->times.size()) - 1;
  }
  json::array documents;
  if (arguments.csv) print_csv_head(arguments.of);
  for (request.step = first; request.step <= last; ++request.step) {
    const Measured made = measure(request, steps, arguments.by == "component", !arguments.all_steps);
    const double time = made.layers.time.time;
    if (arguments.csv) {
      print_csv(made, time);
    } else if (!arguments.json) {
      print_text(made, time, arguments.of);
    } else {
      json::array rows;
      for (const LayerMeasure& row : made.rows) rows.push_back(to_json(made, row, arguments.of));
      documents.push_back(json::object{{"time", time}, {"layers", std::move(rows)}});
    }
  }
  if (arguments.json) print_json(json::object{{"steps", std::move(documents)}});
}

/// A place inside: the middle of its first tetrahedron, or triangle.
Vec3d anchor(const Measured& made, std::uint32_t piece) {
  const IntervalMesh& mesh = made.layers.mesh;
  const std::uint32_t first = made.components.first_tetrahedron[piece];
  const auto middle = [&](const auto& points) {
    Vec3d sum{};
    for (const std::uint32_t point : points) sum = sum + mesh.positions[point];
    return sum / static_cast<double>(points.size());
  };
  return mesh.tetrahedra.empty() ? middle(mesh.facets[first].points) : middle(mesh.tetrahedra[first]);
}

void run_components(const MeasureArguments& arguments) {
  if (arguments.threads > 0) set_thread_count(arguments.threads);
  const StepSource steps = step_source(arguments.file);
  const Measured made = measure(mesh_request(arguments), steps, true);
  const bool flat = made.layers.mesh.tetrahedra.empty();
  const auto size = [flat](const LayerMeasure& row) { return flat ? row.area.domain : row.volume; };
  std::vector<std::size_t> order(made.rows.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return size(made.rows[a]) > size(made.rows[b]); });
  const auto kept = std::partition_point(order.begin(), order.end(), [&](std::size_t i) { return size(made.rows[i]) >= arguments.min_volume; });
  const auto dropped = order.end() - kept;
  order.erase(kept, order.end());
  json::array components;
  if (!arguments.json) std::printf("%zu pieces%s\n%6s %16s %12s  %s\n", order.size(), dropped ? (", " + std::to_string(dropped) + " smaller ones left out").c_str() : "", "id", flat ? "area" : "volume", "tetrahedra", "a place inside");
  for (const std::size_t i : order) {
    const LayerMeasure& row = made.rows[i];
    const Vec3d place = anchor(made, *row.component);
    if (arguments.json)
      components.push_back(json::object{{"id", *row.component + 1},
                                        {"volume", row.volume},
                                        {"area", row.area.lower + row.area.upper + row.area.domain},
                                        {"centroid", place_json(row.centroid)},
                                        {"bounds", box_json(row.bounds)},
                                        {"tetrahedra", row.tetrahedra},
                                        {"anchor", place_json(place)}});
    else
      std::printf("%6u %16.10g %12lld  %.6g, %.6g, %.6g\n", *row.component + 1, size(row), static_cast<long long>(row.tetrahedra), place.x, place.y, place.z);
  }
  if (arguments.json) print_json(json::object{{"components", std::move(components)}});
}

}  // namespace

void add_measure_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand("measure", "Says what each layer holds: volume, areas, centroid, axes, and of any array minimum, mean, standard deviation, maximum and integral");
  const auto arguments = std::make_shared<MeasureArguments>();
  add_mesh_options(*command, *arguments);
  command->add_option("--of", arguments->of, "An array to integrate over each layer; may be repeated")->allow_extra_args(false);
  command->add_option("--by", arguments->by, "component: a row for each connected piece of a layer")->check(CLI::IsMember({"component"}));
  command->add_flag("--all-steps", arguments->all_steps, "Every step of a series, one after the other");
  command->add_flag("--csv", arguments->csv, "Print a table of values with commas between them");
  command->callback([arguments] { run_measure(*arguments); });
}

void add_components_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand("components", "Lists the connected pieces of a layer, the largest first");
  const auto arguments = std::make_shared<MeasureArguments>();
  add_mesh_options(*command, *arguments);
  command->get_option("--interval")->description("LOWER:UPPER, of which -inf and inf leave an end open")->expected(1);
  command->add_option("--min-volume", arguments->min_volume, "Leaves out pieces of a smaller volume (of a flat grid: of a smaller area)");
  command->callback([arguments] { run_components(*arguments); });
}

}  // namespace isostrata
