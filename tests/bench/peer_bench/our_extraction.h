// Our way: explicit, indexed, conforming tetrahedra with their intervals, ready to be written or drawn.
#pragma once

#include "base/task.h"
#include "extraction/bricks/brick_memory.h"
#include "extraction/mesh/interval_mesh.h"
#include "extraction/unstructured/ordered_memory.h"
#include "workload.h"

namespace isostrata::peers {

/// One extraction from nothing but the grid and the array: whatever is built to find cells quickly is built inside.
IntervalMesh extract_ours(const Workload& workload, const Task& task);

/// What the engine keeps of a field between extractions.
struct OurMemory {
  BrickMemory bricks;                                 // of structured grids
  OrderedMemory ordered{std::uint64_t{16} << 30};  // of tetrahedra: what make() left
};

/// The same with what earlier extractions of this field left in `memory`.
IntervalMesh extract_kept(const Workload& workload, OurMemory& memory, const Task& task);

/// The same with the sums of volumes, which cost time that the peer does not spend either.
IntervalMesh extract_and_measure(const Workload& workload, const Task& task);

}  // namespace isostrata::peers
