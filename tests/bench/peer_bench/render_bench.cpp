#include "render_bench.h"

#include <algorithm>
#include <cstdio>
#include <map>

#include "base/parallel.h"
#include "engine/picture/draw_input.h"
#include "engine/picture/extract_scene.h"
#include "rendering/picture/turn_camera.h"
#include "vtk_threads.h"
#include "vtk_volume.h"
#include "workload.h"

namespace isostrata::peers {
namespace {

constexpr int kViews = 12;  // of the path, one full turn

/// The rows of one dataset.
struct Plan {
  std::string data;
  Interval interval;
  std::vector<std::string> constant_peers, linear_peers;
  double constant_aim = 0;             // against projected tetrahedra
  std::map<int, double> linear_aim;    // by size, against Bunyk's ray caster
  double raster_aim = 0;               // against our own raster
  std::map<int, double> constant_fps;  // by size
  std::map<int, double> linear_fps;
  double fragments = 0;  // per second, constant
};

/// The table of the issue that this bench was made for. The quick and important rows first: on a busy machine the last are left
/// out.
std::vector<Plan> standard_plans(bool full) {
  std::vector<Plan> plans;
  // 350 K tetrahedra.
  plans.push_back(
      {"torus:128", {0.242, 0.258}, {"pt", "raster"}, {"bunyk", "raster"}, 40, {{512, 40}, {1024, 80}}, 15, {}, {}, 0});
  // As many as the paper's Table 2 has of the tapered cylinder.
  plans.push_back({"cylinder",
                   {0.9934, 0.9949},
                   {"pt", "bunyk"},
                   {"pt", "bunyk", "zsweep"},
                   0,
                   {},
                   0,
                   {{512, 60}, {1024, 30}},
                   {{512, 60}, {1024, 30}},
                   0});
  // Large tetrahedra: fragments decide.
  plans.push_back({"torus:24", {0.05, 0.45}, {}, {}, 0, {}, 0, {}, {}, 1.2e9});
  // As many as the paper's Table 2 has of the torus.
  Plan large{"torus:256", {0.2425, 0.2575}, {}, {}, 0, {}, 0, {{1024, 15}}, {}, 0};
  if (full) {
    plans[0].constant_peers = plans[0].linear_peers = {"pt", "bunyk", "zsweep", "raster"};
    plans[1].constant_peers = plans[1].linear_peers = {"pt", "bunyk", "zsweep", "raster"};
    large.constant_peers = large.linear_peers = {"pt", "bunyk", "zsweep", "raster"};
  }
  plans.push_back(large);
  return plans;
}

VtkMapper mapper_of(const std::string& peer) {
  if (peer == "pt") return VtkMapper::projected_tetrahedra;
  if (peer == "bunyk") return VtkMapper::bunyk_ray_cast;
  if (peer == "zsweep") return VtkMapper::zsweep;
  throw Error(ErrorCode::invalid_argument, "peer '" + peer + "': expected pt, bunyk, zsweep or raster");
}

class RenderBench {
 public:
  RenderBench(const RenderBenchOptions& options, const std::function<void(const RenderRow&)>& done)
      : options_(options), done_(done) {
    set_thread_count(options.threads);
    report_.vtk = prepare_vtk(options.threads);
    renderer_ = make_renderer({options.renderer, "auto"});
  }

  RenderBenchReport run() {
    for (const std::string& peer : options_.peers)
      if (peer != "raster") mapper_of(peer);
    std::vector<Plan> plans;
    if (options_.data.empty()) plans = standard_plans(options_.full);
    for (const std::string& data : options_.data) {
      Plan plan;
      plan.data = data;
      plan.constant_peers = plan.linear_peers = {"pt", "bunyk"};
      plans.push_back(plan);
    }
    for (Plan& plan : plans) {
      if (!options_.peers.empty()) plan.constant_peers = plan.linear_peers = options_.peers;
      measure(plan);
    }
    return std::move(report_);
  }

 private:
  double left_s() const { return options_.full ? 1e9 : options_.budget_s - watch_.elapsed_ms() / 1e3; }

  bool out_of_time(const std::string& what) {
    if (left_s() > 0) return false;
    report_.left_out.push_back(what + ": out of time; --full runs it");
    return true;
  }

  void measure(const Plan& plan) {
    if (out_of_time(plan.data)) return;
    std::fprintf(stderr, "%s ...\n", plan.data.c_str());
    const auto dataset = open_workload(plan.data, "", task_).dataset;
    const PointArray& array = dataset->arrays.front();
    Interval interval = plan.interval;
    if (!options_.data.empty()) {
      const double span = array.upper - array.lower;
      interval = options_.interval.value_or(Interval{array.lower + 0.45 * span, array.lower + 0.55 * span});
    }
    Scene scene;
    scene.array = array.name;
    SceneInterval layer;
    layer.lower = interval.lower;
    layer.upper = interval.upper;
    layer.color = {0.9f, 0.35f, 0.2f};
    layer.color_map = "viridis";
    layer.opacity = 0.6;
    scene.intervals = {layer};
    scene.background = {0, 0, 0};
    const auto extracted = extract_scene(dataset, scene, nullptr, task_);
    for (const int size : options_.sizes.empty() ? std::vector<int>{512, 1024} : options_.sizes)
      for (const std::string mode : {"constant", "linear"}) {
        DrawInput input = draw_input(*extracted, scene, size, size);
        IntervalStyle& style = input.styles.front();
        style.color_lower = interval.lower;  // the whole colour map within the layer
        style.color_upper = interval.upper;
        if (mode == "constant") {
          style.color_map.clear();
          input.color_values = nullptr;
        }
        measure(plan, input, mode);
      }
  }

  void measure(const Plan& plan, const DrawInput& input, const std::string& mode) {
    const std::string what = plan.data + ", " + mode + ", " + std::to_string(input.width);
    if (out_of_time(what)) return;
    const bool constant = mode == "constant";
    const auto by_size = [&](const std::map<int, double>& aims) {
      const auto found = aims.find(input.width);
      return found == aims.end() ? 0.0 : found->second;
    };
    RenderRow row;
    row.data = plan.data;
    row.mode = mode;
    row.interval = input.mesh->summaries.front().interval;
    row.size = input.width;
    row.aim_fps = by_size(constant ? plan.constant_fps : plan.linear_fps);
    row.aim_fragments = constant ? plan.fragments : 0;
    std::vector<Sample> ours;
    const Image picture = std::get<Image>(time_ours(*renderer_, input, ours, &row).image);
    count_fragments(input, row);
    const std::vector<std::string>& peers = constant ? plan.constant_peers : plan.linear_peers;
    if (peers.empty()) {
      row.ours = spread_of(ours);
      finish(row);
    }
    for (const std::string& peer : peers) {
      if (out_of_time(what + ", " + peer)) continue;
      RenderRow against = row;
      std::vector<Sample> theirs;
      if (peer == "raster") {
        if (!raster_) raster_ = make_renderer({"raster", "surfaceless"});
        against.peer = "our gl raster";
        against.apart = difference(picture, std::get<Image>(time_ours(*raster_, input, theirs, nullptr).image));
        against.aim = plan.raster_aim;
      } else {
        against.peer = name_of(mapper_of(peer));
        against.apart = difference(picture, time_vtk(mapper_of(peer), input, theirs));
        against.aim = peer == "pt" && constant ? plan.constant_aim : peer == "bunyk" && !constant ? by_size(plan.linear_aim) : 0;
      }
      time_ours(*renderer_, input, ours, nullptr);  // before and after: a neighbour's noise falls on both
      against.ours = spread_of(ours);
      against.theirs = spread_of(theirs);
      finish(against);
    }
  }

  void finish(const RenderRow& row) {
    done_(row);
    report_.rows.push_back(row);
  }

  static Camera view(const DrawInput& input, int frame) { return turned(input.camera, 360.0 / kViews * frame + 7); }

  /// Frames around the path, the first untimed; the picture of the path's first view.
  DrawResult time_ours(Renderer& renderer, DrawInput input, std::vector<Sample>& samples, RenderRow* facts) const {
    input.camera = view(input, 0);
    const Camera start = input.camera;
    DrawResult first = renderer.draw(input);  // compiles shaders, makes buffers
    if (facts) {
      facts->tetrahedra = first.facts.tetrahedra;
      facts->renderer = first.facts.renderer;
      facts->order = first.facts.order;
    }
    int frame = 0;
    sample(
        {3, 2 * kViews, options_.full ? 4000.0 : options_.seconds * 1e3}, [&] { renderer.draw(input); },
        [&] { input.camera = turned(start, 360.0 / kViews * ++frame); }, samples);
    return first;
  }

  Image time_vtk(VtkMapper mapper, const DrawInput& input, std::vector<Sample>& samples) {
    VtkVolume volume(mapper, input, options_.threads);
    if (report_.vtk.find(volume.device()) == std::string::npos) report_.vtk += ", " + volume.device();
    Camera camera = view(input, 0);
    const Stopwatch watch;
    Image first = volume.draw(camera);
    const double once_s = watch.elapsed_ms() / 1e3;  // with what it derives once
    int frame = 0;
    const int least = left_s() > 6 * once_s ? 2 : 1;
    sample(
        {least, kViews, options_.full ? 6000.0 : std::clamp(left_s() * 1e3 / 12, 0.0, 3000 * options_.seconds)}, [&] { volume.draw(camera); },
        [&] { camera = turned(view(input, 0), 360.0 / kViews * ++frame); }, samples);
    return first;
  }

  /// In a frame of its own: counting costs something.
  void count_fragments(DrawInput input, RenderRow& row) {
    input.camera = view(input, 0);
    input.count_fragments = true;
    input.float_image = true;
    const DrawResult result = renderer_->draw(input);
    const FloatImage& image = std::get<FloatImage>(result.image);
    std::int64_t covered = 0;
    for (std::size_t i = 3; i < image.rgba.size(); i += 4) covered += image.rgba[i] > 0;
    const auto fragments = static_cast<double>(result.facts.fragments);
    if (row.tetrahedra > 0) row.fragments_per_tetrahedron = fragments / static_cast<double>(row.tetrahedra);
    if (covered > 0) row.depth_complexity = fragments / static_cast<double>(covered);
  }

  const RenderBenchOptions& options_;
  const std::function<void(const RenderRow&)>& done_;
  RenderBenchReport report_;
  std::unique_ptr<Renderer> renderer_, raster_;
  Stopwatch watch_;
  Task task_;
};

}  // namespace

RenderBenchReport run_render_bench(const RenderBenchOptions& options, const std::function<void(const RenderRow&)>& done) {
  return RenderBench(options, done).run();
}

}  // namespace isostrata::peers
