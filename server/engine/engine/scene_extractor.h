// The threads on which scenes are extracted: one extraction of a session at a time, sessions beside each other.
#pragma once

#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>

#include "engine/engine/lanes.h"
#include "engine/engine/latest_extraction.h"
#include "engine/engine/open_datasets.h"
#include "engine/engine/renderer_traits.h"
#include "engine/engine/shared_meshes.h"
#include "engine/engine/work_ahead.h"
#include "engine/messages/activity.h"
#include "engine/messages/messages.h"
#include "engine/messages/operation.h"
#include "engine/picture/scene_ranks.h"

namespace isostrata {

struct ExtractionJob {
  SessionKey session = 0;
  std::shared_ptr<Operation> operation;
  Scene scene;
  Prepared before;      // what is ready
  bool coarse = false;  // of every n-th point of what is ready, at this level; else of all points
  int level = 0;
};

/// Any thread may call any function but the destructor, which drops the jobs that have not begun and waits for those that have; what was given by
/// reference must outlive it. Lock: mutex_.
class SceneExtractor {
 public:
  using Extracted = std::shared_ptr<const ExtractedScene>;
  /// Who knows the sessions. Called on the job's thread, without a lock.
  struct Ports {
    /// What the session's next scene may take. Others make room, or go altogether.
    std::function<std::uint64_t(SessionKey session, bool altogether)> room_for;
    /// Every n-th point of a scene of which there is nothing, until all points are there.
    std::function<void(const ExtractionJob& of, Extracted first_look)> first_look;
    /// What was extracted, or why not; neither, if there is nothing coarser. Called once for each job that has begun.
    std::function<void(const ExtractionJob& of, Extracted extracted, std::exception_ptr failure)> done;
  };

  SceneExtractor(ActivityBoard* board, SceneRanks* ranks, OpenDatasets& datasets, SharedMeshes& shared, WorkAhead& ahead, Ports ports);

  void post(ExtractionJob job);
  RendererTraits renderer();
  /// The renderer from now on.
  void extract_for(const RendererTraits& renderer) {
    const std::lock_guard lock(mutex_);
    renderer_ = renderer;
  }

 private:
  void extract(const ExtractionJob& job);
  Extracted extract_all(const ExtractionJob& job, const RendererTraits& renderer);

  ActivityBoard* const board_;
  SceneRanks* const ranks_;
  OpenDatasets& datasets_;
  SharedMeshes& shared_;
  WorkAhead& ahead_;
  const Ports ports_;
  std::mutex mutex_;
  RendererTraits renderer_;  // guarded by mutex_
  Lanes extractors_;  // by session
};

}  // namespace isostrata
