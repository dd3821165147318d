// The rows of `isostrata-peer-bench render`.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "render_row.h"

namespace isostrata::peers {

struct RenderBenchOptions {
  std::vector<std::string> data;     // empty: the standard rows
  std::optional<Interval> interval;  // for `data`; none: the middle tenth of the first array's range
  std::vector<int> sizes;            // of square pictures; empty: 512 and 1024
  std::vector<std::string> peers;    // of "pt", "bunyk", "zsweep", "raster"; empty: as the rows need
  std::string renderer = "native";   // ours
  bool full = false;                 // the long rows too, and more frames of each
  double budget_s = 45;              // without full: frames and then rows are left out as this passes
  double seconds = 0.7;              // for our frames of one row, before and after the peer's; at least three frames (full: 4)
  int threads = 2;
};

struct RenderBenchReport {
  std::vector<RenderRow> rows;
  std::vector<std::string> left_out;  // what was not run, and why
  std::string vtk;                    // version, back end, threads, device
};

/// Runs the rows, and gives each to `done` as soon as it is there. Throws what the renderers throw.
RenderBenchReport run_render_bench(const RenderBenchOptions& options, const std::function<void(const RenderRow&)>& done);

}  // namespace isostrata::peers
