// How much memory each side takes: measured in a process of its own, so that neither side's heap nor the data's making counts for
// the other.
#pragma once

#include <cstdint>
#include <string>

#include "extraction/mesh/interval_mesh.h"

namespace isostrata::peers {

enum class Side {
  ours,  // extraction to labelled tetrahedra
  vtk    // clip twice, mixed cells
};

struct PeakMemory {
  std::uint64_t peak_bytes = 0;  // the process's largest resident size from the moment the data was loaded
  std::uint64_t data_bytes = 0;  // its resident size at that moment
};

/// Starts this program again as `peak-memory` on the data. Throws unavailable if the child fails, with what it said; a child
/// that would use more than max_bytes of address space ends with such an error.
PeakMemory measure_peak_memory(Side side, const std::string& data, const std::string& array, Interval interval, int threads,
                               std::uint64_t max_bytes);

/// The child's part: loads the data, does the side's work once, and prints "peak data" in bytes on standard output.
void print_peak_memory(Side side, const std::string& data, const std::string& array, Interval interval, int threads);

/// MemTotal of /proc/meminfo; 0 if it cannot be read.
std::uint64_t machine_memory();

}  // namespace isostrata::peers
