// The rows of `isostrata-peer-bench extract`.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "row.h"

namespace isostrata::peers {

struct ExtractBenchOptions {
  std::vector<std::string> data;     // empty: the standard rows
  std::string array;                 // for `data`; empty: the first
  std::optional<Interval> interval;  // for `data`; none: chosen by share
  double share = 0.07;               // of the cells, for `data`
  bool full = false;                 // all repeats, and ParaView where pvpython is found
  double budget_s = 45;              // without full: repeats are left out as this passes, then whole rows
  int threads = 2;
  std::string paraview_script;  // empty: no ParaView row
};

struct ExtractBenchReport {
  std::vector<Row> rows;
  std::vector<std::string> left_out;  // what was not run, and why
  std::string vtk;                    // version, back end, threads
};

/// Runs the rows, saying on standard error what it is at. Throws Error{internal} where ours and the peer's volumes differ by more
/// than 1e-6 on tetrahedra (where both are exact) or 10 % elsewhere (the two cut ambiguous faces and faces that are not plane
/// differently).
ExtractBenchReport run_extract_bench(const ExtractBenchOptions& options);

}  // namespace isostrata::peers
