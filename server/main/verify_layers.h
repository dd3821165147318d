// extract --verify: whether a mesh keeps the laws, what the sum of its parts differs by, and how far its volumes are from those of the field.
#pragma once

#include <optional>
#include <vector>

#include "extraction/laws/check_laws.h"
#include "extraction/layers/extract_layers.h"

namespace isostrata {

struct Proof {
  std::optional<Partition> partition;  // of plain ranges of one step's array
  std::vector<double> volume_errors;   // of each interval, likewise; also between two steps, but not in space-time
  std::vector<BrokenLaw> broken;
};

/// What --verify finds out about the layers of the request. Throws what extraction throws.
Proof prove(const LayerRequest& request, const Layers& layers);

/// A line for each volume that was judged.
void print_errors(const IntervalMesh& mesh, const Proof& proof);

/// Throws internal if a law is broken, after a line on standard error for each but the last.
void judge(const Proof& proof);

}  // namespace isostrata
