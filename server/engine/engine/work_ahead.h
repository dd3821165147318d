// What is made before anybody waits for it: the next step of a series, meshes that layers will be cut out of, scenes of every n-th point,
// and how far those may be off.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>

#include "base/task.h"
#include "engine/engine/lanes.h"
#include "engine/engine/open_datasets.h"
#include "engine/engine/shared_meshes.h"
#include "engine/messages/activity.h"
#include "engine/messages/messages.h"
#include "engine/picture/extracted_scene.h"

namespace isostrata {

/// Who goes from one step to the next will go on: the step after `scene`'s. Nothing: `before` was not the step beside it, or there is none.
std::optional<int> step_ahead(const Scene& scene, const Scene& before, int steps);

/// What is made of a mesh.
struct Preparation {
  // Of tetrahedra the mesh that a renderer cuts, or what extraction splits sooner; of other cells the faces that extraction need not look for.
  enum class What { nothing, base, order, faces } what = What::nothing;
  bool waited_for = false;  // by a hand that moves; else it is for later, and yields to everything

  bool operator==(const Preparation&) const = default;
};
struct GridFacts {
  bool renderer_cuts = false;         // the renderer of now cuts intervals
  std::uint64_t max_bytes = 0;        // --max-memory
  std::function<bool()> has_base;     // it has been made; all are asked only if that matters
  std::function<bool()> knows_order;  // likewise
  std::function<bool()> knows_faces;  // likewise
};
/// Whoever looks at layers will move their ends, and steps on one mesh will be followed by others: a series is laid out for both. Before a hand has moved, only if it takes little of the
/// memory. extracted: the scene's. previous: what was there before, or null.
Preparation to_prepare(const ExtractedScene& extracted, const Scene& scene, const ExtractedScene* previous, const GridFacts& facts);

struct WorkAheadOptions {
  std::uint64_t max_bytes = 0;               // --max-memory
  std::int64_t least_coarse_tetrahedra = 0;  // as EngineOptions
  bool by_ranks = false;                     // then nobody has all points
  ActivityBoard* board = nullptr;            // as EngineOptions
};

/// Any thread may call any function but the destructor, which waits for what has begun; what was given by reference must outlive it. Whatever cannot be
/// made is left out: whoever needs it makes it, or is told why not. Lock: mutex_.
class WorkAhead {
 public:
  using Extracted = std::shared_ptr<const ExtractedScene>;
  /// Who knows the sessions. Called on any thread, without a lock.
  struct Ports {
    /// Whether the session still shows `of`, of which it has nothing coarser, and so many bytes are free.
    std::function<bool(SessionKey session, const Extracted& of, std::uint64_t bytes)> wants_coarse;
    /// Of every n-th point of `of`, which is the scene's.
    std::function<void(SessionKey session, const Extracted& of, Extracted coarse, const Scene& scene)> take_coarse;
  };

  WorkAhead(WorkAheadOptions options, OpenDatasets& datasets, SharedMeshes& shared, Ports ports);

  /// After an extraction. scene, previous, before: as in to_prepare and step_ahead. renderer_cuts: the renderer of now does.
  void prepare_mesh(SessionKey session, const ExtractedScene& extracted, const Scene& scene, const ExtractedScene* previous, bool renderer_cuts);
  /// Before the extraction of a step that several others will follow: waits for their mesh to be laid out. Throws cancelled, what steps throw.
  void lay_out_played(SessionKey session, const Scene& scene, const ExtractedScene& previous, const Scene& before, const StepSource& steps, const Task& task);
  void read_step(const ExtractedScene& extracted, const Scene& scene, const Scene& before);
  /// Of a scene that rests, or has just been seen for the first time, and takes long to draw, the same of every n-th point, for the next hand that turns it.
  /// Of other scenes on a large mesh the samples of it that a hand which moves its layers cuts. facets_alone: as SceneAids has it.
  void prepare_motion(SessionKey session, const Extracted& extracted, const Scene& scene, bool facets_alone = false);
  /// How far a coarse picture may be from that of all points, beside everything else.
  void find_error(const ExtractedScene& coarse);
  /// Cancels what is being made; nothing is prepared afterwards.
  void stop();

 private:
  std::shared_ptr<Task> begin_preparation(const Preparation& wanted, const Grid& grid);
  void prepare(SessionKey session, const Preparation& wanted, const std::shared_ptr<const Dataset>& dataset, const std::string& array);
  bool is_being_made(Preparation::What what, const Grid& grid) const;  // with mutex_ held
  /// Or its layout is being made by who is in a hurry.
  bool has_order(const Grid& grid);
  void prepare_samples(SessionKey session, const Extracted& extracted, const Scene& scene);

  const WorkAheadOptions options_;
  OpenDatasets& datasets_;
  SharedMeshes& shared_;
  const Ports ports_;
  Task ahead_task_;   // of what nobody waits for
  mutable std::mutex mutex_;  // guards the next two
  bool stopping_ = false;
  struct {
    std::shared_ptr<Task> task;  // null: none
    Preparation of;
    std::weak_ptr<const void> grid;  // its storage
  } preparation_;             // of tetrahedra
  Lanes preparers_{{1, 10}};  // of what may be needed
  Lanes layouts_{{1, 0}};     // of series: who plays one will wait for it, and a nice thread stays nice
  Lanes movers_{{1, 0}};      // of what a hand that moves needs, by session
  Lanes ahead_{{1, 0}};       // of steps that will be asked for, by dataset
};

}  // namespace isostrata
