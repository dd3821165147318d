// The bricks that layers of a structured grid lie in, in place of a mesh of tetrahedra: all that drawing constant colours needs, and all that a
// renderer that makes the mesh on its device asks for.
//
// A large mesh costs its memory: each megabyte that is written for the first time takes about a millisecond. So what bounds the layers is made
// slab by slab, from the cells' cases, by whoever looks at it, and whoever looks keeps what he sees of it.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/task.h"
#include "data/dataset/dataset.h"
#include "extraction/bricks/active_bricks.h"
#include "extraction/bricks/brick_writer.h"
#include "extraction/cells/iso_rules.h"
#include "extraction/mesh/interval_mesh.h"

namespace isostrata {

class BrickMemory;

/// Immutable; any thread.
class LayerBricks {
 public:
  /// A layer of bricks along z. Its memory is kept from slab to slab.
  struct Slab {
    explicit Slab(const LayerBricks& of) : scratch(of.writer_) {}
    BrickWriter::Scratch scratch;
    IntervalMesh mesh;  // positions and origins of what the facets use, others mean nothing; facets, without `tetrahedron`
  };
  using Wanted = std::function<bool(const Box3d& brick)>;

  LayerBricks(std::shared_ptr<const Dataset> dataset, const PointArray& array, IsoRules rules, std::shared_ptr<const ActiveBricks> active);
  LayerBricks(const LayerBricks&) = delete;
  LayerBricks& operator=(const LayerBricks&) = delete;

  const std::shared_ptr<const Dataset>& dataset() const { return dataset_; }
  const Grid& grid() const { return dataset_->grid; }
  const PointArray& array() const { return array_; }
  std::vector<Interval> intervals() const;  // with ends that are finite
  const ActiveBricks& active() const { return *active_; }
  std::int64_t slabs() const { return active_->layout().bricks[2]; }
  /// The facets that structured_facets gives for the slab's bricks, in its order, on the very same positions. `wanted`: bricks for which it says no
  /// are left out (grids of boxes only; null: none).
  void write(std::int64_t slab, const Wanted& wanted, Slab& out) const;
  /// [intervals] what the facets enclose: the sum of the tetrahedra's signed volumes. Parallel; the same for any number of threads.
  std::vector<double> signed_volumes(const Task& task) const;
  /// [intervals] what lies in the cells that owns() says yes to, which may be called from any thread: active_cells, tetrahedra, and signed_volume.
  /// The sums of owners of all cells are those of the whole: numbers exactly, volumes to rounding. Parallel. Throws cancelled.
  std::vector<IntervalSummary> summaries_of(const std::function<bool(std::int64_t cell)>& owns, const Task& task) const;
  std::uint64_t bytes() const { return active_->bytes(); }

 private:
  using Owns = std::function<bool(std::int64_t cell)>;
  /// Whether all of the brick's cells are owned, and those around it; no if that is not easily told.
  bool owns_all(const BrickLayout::Place& place, const Owns& owns) const;
  void write(std::int64_t slab, const Wanted& wanted, const Owns* owns, Slab& out) const;
  void write_facets(std::size_t b, std::uint32_t base, const Owns* owns, Slab& out) const;
  std::vector<double> signed_volumes(const Owns* owns, const Task& task) const;
  bool is_wanted(const ActiveBrick& brick, const Wanted& wanted) const;

  const std::shared_ptr<const Dataset> dataset_;
  const PointArray& array_;
  const IsoRules rules_;
  const std::shared_ptr<const ActiveBricks> active_;
  const BrickWriter writer_;
  bool any_absent_ = false;
};

/// The bricks and, as a mesh without points, the summaries that extract_structured gives; their absolute volumes and inverted tetrahedra are 0.
struct FoundLayers {
  std::shared_ptr<const LayerBricks> bricks;
  IntervalMesh mesh;
};
/// Nothing if the intervals hold fewer than `least_tetrahedra` (then a mesh is cheaper to draw again and again), the grid is not structured or
/// is flat or meets itself at a seam, there are more than 256 intervals, or the grid's cells are turned over (a negative volume). `memory` keeps what was found, also where
/// nothing is returned. Throws what extract_intervals throws. Any thread.
std::optional<FoundLayers> find_layer_bricks(const std::shared_ptr<const Dataset>& dataset, const PointArray& array,
                                             std::span<const Interval> intervals, BrickMemory& memory, std::int64_t least_tetrahedra,
                                             std::uint64_t max_bytes, const Task& task);

}  // namespace isostrata
