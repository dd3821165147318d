#include "extract_bench.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "base/parallel.h"
#include "data/values/read_once.h"
#include "extraction/intervals/extract_intervals.h"
#include "our_extraction.h"
#include "paraview_peer.h"
#include "vtk_peer.h"
#include "vtk_threads.h"

namespace isostrata::peers {
namespace {

constexpr const char* kClips = "table clip x2";
constexpr const char* kClipsAndSplit = "table clip x2 + tetrahedralise";

struct ClipAims {
  double clips = 0, split = 0;  // ratios wished for
  bool split_row = true;        // report clip + tetrahedralise, too
  double memory = 0;            // peer / ours; 0: memory is not measured
};

class ExtractBench {
 public:
  explicit ExtractBench(const ExtractBenchOptions& options) : options_(options) { report_.vtk = prepare_vtk(options.threads); }

  ExtractBenchReport run() {
    if (options_.data.empty())
      standard_rows();
    else
      for (const std::string& data : options_.data)
        compare(load(data, options_.array, options_.share, options_.interval), data, {});
    return std::move(report_);
  }

 private:
  void standard_rows() {
    // The quick rows first: on a busy machine it is the long ones that are left out.
    compare(load("torus:64", "", 0.25, {}), "torus:64", {0, 60, true, 0});
    compare(load("tets:64", "", 0.07, {}), "tets:64", {20, 0, false, 0});
    const Workload torus = load("torus:256", "", 0.07, {});
    floor_row("torus:256", torus);
    drag_row("torus:256", torus);
    compare(torus, "torus:256", {50, 150, true, 5});
    if (options_.full) paraview_row("torus:256", torus);
    large_bytes_row();
  }

  Workload load(const std::string& data, const std::string& array, double share, const std::optional<Interval>& interval) {
    std::fprintf(stderr, "%s ...\n", data.c_str());
    Workload workload = open_workload(data, array, task_);
    workload.interval = interval ? *interval : interval_through(workload, usual_center(data, workload.values()), share);
    prepare_tables(workload.dataset->grid);
    return workload;
  }

  /// A row that says what ours did; the mesh is counted and measured apart from the timing.
  Row our_row(const std::string& data, const Workload& workload) const {
    Row row;
    row.data = data;
    row.array = workload.array;
    row.interval = workload.interval;
    const IntervalMesh mesh = extract_and_measure(workload, task_);
    row.cells = mesh.cells;
    row.active_cells = mesh.active_cells;
    row.tetrahedra = static_cast<std::int64_t>(mesh.tetrahedra.size());
    row.our_volume = mesh.summaries.front().volume;
    row.setting = "index built inside";
    return row;
  }

  void sample_ours(const Workload& workload, std::vector<Sample>& samples) const {
    IntervalMesh mesh;
    sample(
        {2, 40, 1500}, [&] { mesh = extract_ours(workload, task_); }, [&] { mesh = {}; }, samples);
  }

  /// Beside what it takes to make the layout of tetrahedra, which the engine does behind the first pictures.
  void sample_kept(const Workload& workload, Row& row) const {
    OurMemory memory;
    const Stopwatch making;
    memory.ordered.make(workload.dataset->grid, task_);
    const double made_ms = making.elapsed_ms();
    IntervalMesh mesh = extract_kept(workload, memory, task_);
    if (memory.ordered.bytes() > 0) {
      char text[120];
      std::snprintf(text, sizeof text, "index kept: the layout of the tetrahedra, made in %.0f ms, %.1f MiB", made_ms,
                    static_cast<double>(memory.ordered.bytes()) / 1048576.0);
      row.note = text;
    }
    mesh = {};
    std::vector<Sample> samples;
    sample(
        {2, 40, 1500}, [&] { mesh = extract_kept(workload, memory, task_); }, [&] { mesh = {}; }, samples);
    row.kept = spread_of(samples);
  }

  double left_s() const { return options_.full ? 1e9 : options_.budget_s - watch_.elapsed_ms() / 1e3; }

  bool out_of_time(const std::string& what) {
    if (left_s() > 0) return false;
    report_.left_out.push_back(what + ": out of time; --full runs it");
    return true;
  }

  /// Both rows of a workload: the clips, and the clips with what they leave cut into tetrahedra.
  void compare(const Workload& workload, const std::string& data, const ClipAims& aims) {
    if (out_of_time(data)) return;
    Row clips = our_row(data, workload);
    std::vector<Sample> ours, clip_samples, split_samples;
    sample_ours(workload, ours);

    VtkPeer peer(workload);
    // Both are timed in one pass, and its result gives the volume: a second one would take as long again.
    const auto clip_and_split = [&] {
      const Clock clock;
      peer.clip_twice();
      clip_samples.push_back(clock.elapsed());
      clips.peer_cells = peer.cells();
      peer.tetrahedralise();
      split_samples.push_back(clock.elapsed());
    };
    const Stopwatch whole;
    clip_and_split();
    clips.peer_volume = peer.volume();
    const std::int64_t peer_tetrahedra = peer.cells();
    if (peer.not_tetrahedra() > 0) throw Error(ErrorCode::internal, data + ": the peer left cells that are not tetrahedra");
    peer.forget();
    const double once_ms = whole.elapsed_ms();
    while (split_samples.size() < 3 && (options_.full || once_ms < 3000) && left_s() > 3 * once_ms / 1e3) {
      clip_and_split();
      peer.forget();
    }
    const int missing = std::max<int>(0, 5 - static_cast<int>(clip_samples.size()));
    const double budget_ms = std::clamp(left_s() * 1e3 / 4, 0.0, 9000.0);
    sample(
        {0, missing, budget_ms}, [&] { peer.clip_twice(); }, [&] { peer.forget(); }, clip_samples);
    sample_ours(workload, ours);

    clips.ours = spread_of(ours);
    sample_kept(workload, clips);
    check_volumes(workload, clips);
    Row split = clips;
    split.peer = kClipsAndSplit;
    split.peer_cells = peer_tetrahedra;
    split.theirs = spread_of(split_samples);
    split.aim = aims.split;
    clips.peer = kClips;
    clips.theirs = spread_of(clip_samples);
    clips.aim = aims.clips;
    clips.memory_aim = aims.memory;
    if (aims.memory > 0) measure_memory(clips);
    if (aims.split_row) report_.rows.push_back(std::move(split));
    report_.rows.push_back(std::move(clips));
  }

  void measure_memory(Row& row) {
    if (out_of_time(row.data + ", peak memory")) return;
    row.our_memory = measure_peak_memory(Side::ours, row.data, row.array, row.interval, options_.threads, 0);
    row.peer_memory = measure_peak_memory(Side::vtk, row.data, row.array, row.interval, options_.threads, 0);
    torus_peer_bytes_ = row.peer_memory.peak_bytes;
  }

  static void check_volumes(const Workload& workload, const Row& row) {
    const auto& types = workload.dataset->cell_types;
    const bool exact = types.size() == 1 && types.contains("tetrahedron");
    const double allowed = exact ? 1e-6 : 0.1;
    if (!(row.volume_difference() <= allowed))
      throw Error(ErrorCode::internal, row.data + ": volume " + std::to_string(row.our_volume) + ", the peer's " +
                                           std::to_string(row.peer_volume) + "; expected them within " + std::to_string(allowed));
  }

  /// Against the time that one look at every value takes, with about as many tetrahedra as in the paper's Table 2.
  void floor_row(const std::string& data, Workload workload) {
    if (out_of_time(data + ", reading the array once")) return;
    workload.interval = {0.2425, 0.2575};
    Row row = our_row(data, workload);
    std::vector<Sample> ours, floor;
    for (int round = 0; round < 5; ++round) {  // by turns, so that a neighbour's noise meets both
      sample(
          {3, 3, 0}, [&] { read_once(workload.values()); }, [] {}, floor);
      IntervalMesh mesh;
      sample(
          {3, 3, 0}, [&] { mesh = extract_ours(workload, task_); }, [&] { mesh = {}; }, ours);
    }
    row.ours = spread_of(ours);
    row.peer = "reading the array once";
    row.theirs = spread_of(floor);
    row.aim = 1.0 / 8;
    char text[96];
    std::snprintf(text, sizeof text, "%.1f times the floor by medians, %.1f by minima; aim: at most 8", 1 / row.ratio(),
                  1 / row.ratio_of_minima());
    row.note = text;
    report_.rows.push_back(std::move(row));
  }

  /// A slider's drag: the upper end to and fro by 1 % of the range, with what the last extraction left, against all of it anew.
  void drag_row(const std::string& data, Workload workload) {
    if (out_of_time(data + ", drag")) return;
    Row row = our_row(data, workload);
    row.setting = "upper end moved by 1 % of the range, index and unchanged bricks kept";
    row.peer = "our own full extraction";
    row.aim = 10;
    const double step = (workload.values().upper - workload.values().lower) / 100, upper = workload.interval.upper;
    OurMemory memory;
    IntervalMesh mesh = extract_kept(workload, memory, task_);
    mesh = {};
    std::vector<Sample> drags, full;
    for (int round = 0; round < 10; ++round) {  // by turns, so that a neighbour's noise meets both
      workload.interval.upper = round % 2 == 0 ? upper + step : upper;
      sample(
          {1, 1, 0}, [&] { mesh = extract_kept(workload, memory, task_); }, [&] { mesh = {}; }, drags);
      sample(
          {1, 1, 0}, [&] { mesh = extract_ours(workload, task_); }, [&] { mesh = {}; }, full);
    }
    row.ours = spread_of(drags);
    row.theirs = spread_of(full);
    report_.rows.push_back(std::move(row));
  }

  /// 8-bit data of 512^3 points in their own type: what it takes, and whether the peer could hold its result at all.
  void large_bytes_row() {
    const std::string data = "torus-u8:512";
    if (left_s() < 3) {
      report_.left_out.push_back(data + ": out of time; --full runs it");
      return;
    }
    const Workload workload = load(data, "", 0.07, {});
    Row row = our_row(data, workload);
    row.peer = kClips;
    std::vector<Sample> ours;
    sample_ours(workload, ours);
    row.ours = spread_of(ours);
    row.our_memory = measure_peak_memory(Side::ours, data, row.array, row.interval, options_.threads, 0);
    const std::uint64_t machine = machine_memory(), expected = 8 * torus_peer_bytes_;  // 8 times the points of torus:256
    if (expected == 0) {
      row.note = "the peer was not run: its memory on torus:256 was not measured";
    } else if (!options_.full || expected > machine) {
      row.peer_bytes_estimated = expected;
      row.note = expected > machine ? "the peer was not run: 8 times its peak on torus:256 is more than this machine's " +
                                          std::to_string(machine >> 20) + " MiB"
                                    : "the peer was not run: 8 times its peak on torus:256; --full runs it";
    } else {
      row.peer_memory = measure_peak_memory(Side::vtk, data, row.array, row.interval, options_.threads, machine);
    }
    report_.rows.push_back(std::move(row));
  }

  void paraview_row(const std::string& data, const Workload& workload) {
    if (options_.paraview_script.empty()) {
      report_.left_out.push_back("ParaView IsoVolume: no pvpython, or no script for it");
      return;
    }
    std::fprintf(stderr, "ParaView IsoVolume ...\n");
    Row row = our_row(data, workload);
    std::vector<Sample> ours;
    sample_ours(workload, ours);
    row.ours = spread_of(ours);
    row.aim = 250;
    const ParaviewRun run = run_paraview(options_.paraview_script, workload, options_.threads);
    row.peer = run.version + " IsoVolume";
    row.theirs = spread_of(run.samples);
    row.peer_cells = run.cells;
    row.peer_memory.peak_bytes = run.peak_bytes;
    report_.rows.push_back(std::move(row));
  }

  const ExtractBenchOptions options_;
  const Task task_;
  const Stopwatch watch_;
  ExtractBenchReport report_;
  std::uint64_t torus_peer_bytes_ = 0;
};

}  // namespace

ExtractBenchReport run_extract_bench(const ExtractBenchOptions& options) {
  set_thread_count(options.threads);
  return ExtractBench(options).run();
}

}  // namespace isostrata::peers
