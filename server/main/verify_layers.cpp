#include "main/verify_layers.h"

#include <cmath>
#include <cstdio>
#include <functional>
#include <limits>
#include <sstream>
#include <string>

#include "extraction/intervals/extract_intervals.h"
#include "extraction/intervals/extract_whole.h"
#include "extraction/laws/volume_error.h"
#include "main/arguments.h"

namespace isostrata {
namespace {

constexpr double kPartitionTolerance = 1e-9;

/// What an interval makes of all cells, with what is outside it or without.
using Parts = std::function<IntervalMesh(const Interval& interval, bool with_rest)>;

/// Each interval with what is outside it against everything: the worst.
std::optional<Partition> worst_partition(const IntervalMesh& mesh, const Interval& everything, bool flat, const Parts& parts) {
  const auto size = [&](const Interval& interval, bool with_rest) {
    double sum = 0;
    for (const IntervalSummary& row : parts(interval, with_rest).summaries) sum += flat ? row.area : row.signed_volume;
    return sum;
  };
  const double all = size(everything, false);
  std::optional<Partition> worst;
  for (const IntervalSummary& row : mesh.summaries) {
    const double sum = size(row.interval, true), error = all != 0 ? std::abs((sum - all) / all) : std::abs(sum);
    if (!worst || error > worst->error) worst = Partition{error, all};
  }
  return worst;
}

std::optional<Partition> partition_of(const LayerRequest& request, const Layers& layers) {
  const Grid& grid = layers.dataset->grid;
  const PointArray& array = layers.dataset->array(request.array);
  ExtractOptions options;
  options.max_bytes = request.max_bytes;
  if (request.values == FieldValues::whole) {
    const double infinity = std::numeric_limits<double>::infinity();
    options.tetrahedra = false;
    return worst_partition(layers.mesh, {-infinity, infinity}, grid.flat(), [&](const Interval& interval, bool with_rest) {
      options.complement = with_rest;
      return extract_whole(grid, *array.cells, {&interval, 1}, options, command_task());
    });
  }
  if (grid.flat()) {
    const double most = std::numeric_limits<double>::max();
    return worst_partition(layers.mesh, {-most, most}, true, [&](const Interval& interval, bool with_rest) {
      options.complement = with_rest;
      return extract_intervals(grid, array, {&interval, 1}, options, command_task());
    });
  }
  if (!request.terms.empty() || request.time) return std::nullopt;
  options.strict = request.triangulation == Triangulation::strict;
  return partition_error(grid, array, layers.mesh, options, command_task());
}

}  // namespace

Proof prove(const LayerRequest& request, const Layers& layers) {
  const Grid& grid = layers.dataset->grid;
  const bool whole = request.values == FieldValues::whole, flat = grid.flat();
  Proof proof;
  proof.partition = partition_of(request, layers);
  if (!whole && !flat && request.terms.empty() && layers.time.mode != TimeMode::spacetime)
    proof.volume_errors = volume_errors(grid, layers.dataset->array(request.array), layers.mesh, command_task());
  LawOptions laws;
  laws.one_range = !whole && request.terms.empty();  // points of whole cells have no values
  laws.strict = request.triangulation == Triangulation::strict;
  if (!flat) proof.broken = check_laws(grid, layers.mesh, laws, command_task());
  if (proof.partition && !(proof.partition->error <= kPartitionTolerance)) {
    std::ostringstream text;
    text << "the intervals and what is outside them differ from the " << (flat ? "area" : "volume") << " of their cells, " << proof.partition->volume << ", by "
         << proof.partition->error << " of it; expected at most " << kPartitionTolerance;
    proof.broken.push_back({"partition", 1, text.str()});
  }
  return proof;
}

void print_errors(const IntervalMesh& mesh, const Proof& proof) {
  for (std::size_t i = 0; i < proof.volume_errors.size(); ++i) {
    const IntervalSummary& row = mesh.summaries[i];
    if (proof.volume_errors[i] == 0)
      std::printf("volume %.8g to %.8g: exactly that of the interpolated field\n", row.interval.lower, row.interval.upper);
    else
      std::printf("volume %.8g to %.8g: estimated to be within %.3g (%.2g %%) of that of the interpolated field\n", row.interval.lower, row.interval.upper,
                  proof.volume_errors[i], 100 * proof.volume_errors[i] / std::abs(row.signed_volume));
  }
}

void judge(const Proof& proof) {
  const auto line = [](const BrokenLaw& law) { return "broken law '" + law.law + "', " + std::to_string(law.count) + " times, first: " + law.first; };
  for (std::size_t i = 0; i + 1 < proof.broken.size(); ++i) std::fprintf(stderr, "isostrata: %s\n", line(proof.broken[i]).c_str());
  if (!proof.broken.empty()) throw Error(ErrorCode::internal, line(proof.broken.back()));
}

}  // namespace isostrata
