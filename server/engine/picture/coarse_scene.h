// Pictures of every n-th point of a grid: the first of a large one, while the layers of all points are still being found, and those that move. Of a mesh
// those that move are of as many points of a uniform grid (sampled_mesh.h).
#pragma once

#include <array>
#include <condition_variable>
#include <cstdint>
#include <list>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "base/work.h"
#include "engine/picture/extracted_scene.h"

namespace isostrata {

/// The least stride of each axis that leaves at most `most_points`, and no axis with few; 1, 1, 1 if the grid has no more cells than
/// `least_cells`, or is not structured.
std::array<std::int64_t, 3> coarse_stride(const Grid& grid, std::int64_t least_cells, std::int64_t most_points);

/// The strides of a level from 1 on (coarse_levels.h); 1, 1, 1 if the grid is too small, or not structured.
std::array<std::int64_t, 3> moving_stride(const Grid& grid, int level);

/// Whether extract_for_motion of the scene has something to make, on the grid of `extracted`, which is of all points.
bool can_be_coarse(const ExtractedScene& extracted, const Scene& scene);

/// Lends coarser datasets to scenes, and makes each once for as long as a scene has it: who asks meanwhile waits for it. Any thread may call any function.
/// Lock: mutex_.
class CoarseScenes {
 public:
  /// Grids of more cells have a coarser picture first.
  explicit CoarseScenes(std::int64_t least_cells) : least_cells_(least_cells) {}

  /// As extract_scene, on every n-th point of the grid (coarser, region.h); ExtractedScene::point_stride says of which. Nothing if the grid is not
  /// large, or the scene shows more than one step as it is. The mesh takes 1/n^3 of that of all points, and as much of its time. facets_alone: as
  /// SceneAids has it. Throws what extract_scene throws.
  std::shared_ptr<const ExtractedScene> extract(const StepSource& steps, const Scene& scene, const Task& task, bool facets_alone = false);

  /// The same of whatever can_be_coarse, for moving frames: of a structured grid at moving_stride, of a mesh at samples, of which the levels behind the
  /// first have every second one along each axis.
  std::shared_ptr<const ExtractedScene> extract_for_motion(const std::shared_ptr<const Dataset>& whole, const Scene& scene, int level, const Task& task,
                                                           bool facets_alone = false);

  /// Makes what extract_for_motion samples a mesh for, and keeps it as long as the mesh is there, of the newest meshes. Nothing of other grids: what
  /// they are coarsened to is made in a moment. Throws cancelled.
  void keep_samples(const std::shared_ptr<const Dataset>& whole, const Scene& scene, const Task& task);
  /// Of what is kept so.
  std::uint64_t held_bytes();

  /// Finds how far the field of these scenes' dataset is from that of all points (ExtractedScene::coarse_error), once for each dataset and array, unless
  /// the array takes more than most_bytes: what is larger than memory is not read for it. Throws cancelled; then nobody will find it.
  void find_error(const std::shared_ptr<const Dataset>& coarse, const std::string& array, std::uint64_t most_bytes, const Task& task);

 private:
  using Stride = std::array<std::int64_t, 3>;
  using FoundError = KnownLater<CoarseError>;
  std::shared_ptr<const ExtractedScene> extract_every(const Stride& stride, const std::shared_ptr<const Dataset>& whole, const Scene& scene, const Task& task,
                                                      bool facets_alone);
  struct Lent {
    std::weak_ptr<const Dataset> whole, coarse;
    Stride stride;
    std::vector<std::string> arrays;
    std::vector<std::shared_ptr<FoundError>> errors;  // of each array
    bool making = false;                              // by some thread; there is no coarse one yet
    Work* maker = nullptr;                            // of that thread
    std::shared_ptr<const Dataset> kept;              // in advance; else null
    std::shared_ptr<FoundError> error_of(const std::string& array) const;  // null: it has no such array
  };
  /// Null: it is not lent any more. With mutex_ held.
  const Lent* lent_of(const std::shared_ptr<const Dataset>& coarse) const;
  std::shared_ptr<const Dataset> coarse_of(const std::shared_ptr<const Dataset>& whole, const Stride& stride, const std::vector<std::string>& arrays, const Task& task);
  std::shared_ptr<const Dataset> make_coarse(const std::shared_ptr<const Dataset>& whole, const Stride& stride, const std::vector<std::string>& arrays, const Task& task);
  void drop_what_is_gone();  // with mutex_ held

  const std::int64_t least_cells_;
  std::mutex mutex_;
  std::condition_variable changed_;  // something has been made, or will not be
  std::list<Lent> lent_;
};

}  // namespace isostrata
