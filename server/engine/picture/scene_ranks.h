// The door to processes ("ranks") that hold one dataset together and draw it together. Whoever draws a scene asks here in place of
// extract_scene and make_renderer; there is one such door in a process, or none.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "data/parts/region.h"
#include "data/values/statistics.h"
#include "engine/data/dataset_store.h"
#include "engine/picture/extract_scene.h"
#include "extraction/files/write_mesh.h"
#include "rendering/picture/renderer.h"

namespace isostrata {

/// A dataset as every rank can open it.
struct RankedSource {
  std::string source;  // a path or the name of analytic data
  std::string version;  // what is opened under another one is read anew; equal to `source` where there is only one
};

/// What a mesh file that ranks have written holds.
struct RankedExtraction {
  std::vector<IntervalSummary> summaries;  // of the whole
  std::int64_t cells = 0, active_cells = 0, tetrahedra = 0;
  std::int64_t points = 0;  // of all pieces: those on their common faces count in each
  std::int64_t lower_facets = 0, upper_facets = 0, domain_facets = 0;
  std::int64_t unmatched_facets = 0;  // of each rank's cells with those around them
};

/// What ranks are told once, before anything else.
struct RankSettings {
  DatasetStoreOptions store;  // of which `keep` is this rank's own
  RendererChoice renderer;  // of each rank
  int threads = 0;          // of each rank; 0: the node's cores, shared out among its ranks
  Region region;            // of each structured grid that is opened
};

/// Any thread may call any function.
class SceneRanks {
 public:
  virtual ~SceneRanks() = default;
  virtual int count() const = 0;
  virtual void configure(const RankSettings& settings) = 0;

  /// As DatasetStore::open and open_part, for this rank: the whole dataset, of which it looks at nothing that is mapped where it lies in the file
  /// (source_mapping.h): each rank looks at its part, and the ranges are put together.
  virtual std::shared_ptr<const Dataset> open(const RankedSource& of, int step, const Task& task) = 0;
  /// histogram() and statistics() of what open() gave, each rank of the values that it owns. Counts are those of one process, and mean and deviation
  /// to rounding.
  virtual std::vector<std::uint64_t> histogram(const RankedSource& of, const std::shared_ptr<const Dataset>& whole, const std::string& array,
                                               double lower, double upper, int bins, const Task& task) = 0;
  virtual Statistics statistics(const RankedSource& of, const std::shared_ptr<const Dataset>& whole, const std::string& array, const Task& task) = 0;

  /// As extract_scene, each rank of its region. What comes back is this rank's part, with the summaries of the whole, for make_renderer's
  /// renderer to draw. whole: opens all of the dataset, for this rank's own use. Throws what the first rank that fails throws,
  /// saying which rank, and unsupported (flat grids).
  virtual std::shared_ptr<const ExtractedScene> extract(const RankedSource& of, const StepSource& whole, const Scene& scene,
                                                        const std::shared_ptr<const ExtractedScene>& previous, const Task& task,
                                                        const SceneAids& aids) = 0;

  /// Draws what extract() gave by all ranks and gives the picture of the whole. One at a time; on the thread that made it.
  virtual std::unique_ptr<Renderer> make_renderer() = 0;

  /// As extract_layers, and each rank writes what it owns. path: empty, or of a .pvtu, whose pieces are put beside it.
  virtual RankedExtraction write_pieces(const RankedSource& of, const StepSource& whole, const LayerRequest& request, const std::string& path,
                                        const WriteOptions& options, const Task& task) = 0;
};

/// extract_scene by `ranks`, or by this process alone if that is null.
inline std::shared_ptr<const ExtractedScene> extract_by(SceneRanks* ranks, const RankedSource& of, const StepSource& steps, const Scene& scene,
                                                        const std::shared_ptr<const ExtractedScene>& previous, const Task& task, const SceneAids& aids) {
  return ranks ? ranks->extract(of, steps, scene, previous, task, aids) : extract_scene(steps, scene, previous, task, aids);
}

}  // namespace isostrata
