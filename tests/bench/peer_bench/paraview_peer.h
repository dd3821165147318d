// ParaView's IsoVolume filter on the same values, in a pvpython of its own: for the record.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "spread.h"
#include "workload.h"

namespace isostrata::peers {

struct ParaviewRun {
  std::string version;          // "ParaView 5.11.0"
  std::vector<Sample> samples;  // cpu_ms 0: unknown
  std::int64_t cells = 0;
  std::uint64_t peak_bytes = 0;  // of the whole pvpython
};

/// Whether $PATH has a pvpython.
bool paraview_found();

/// Writes the array to a temporary raw file and runs `script` on it. Precondition: a uniform grid. Throws unavailable where
/// pvpython or the script fails.
ParaviewRun run_paraview(const std::string& script, const Workload& workload, int threads);

}  // namespace isostrata::peers
