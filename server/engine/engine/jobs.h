// What only answers a question, and draws no frame: what a dataset is, histograms, statistics, measured layers, values at a place and along a line, exported meshes, small pictures for lists.
//
// Questions of one kind and one session are answered one after the other, those of different sessions beside each other (lanes.h). What of a dataset
// nobody's session asks has the dataset's own lane, so that a file that cannot be read holds up whoever asks for it and nobody else.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "base/work.h"
#include "engine/engine/lanes.h"
#include "engine/engine/open_datasets.h"
#include "engine/messages/activity.h"
#include "engine/messages/frame_engine.h"
#include "engine/messages/running_operations.h"
#include "engine/picture/extracted_scene.h"
#include "engine/picture/scene_ranks.h"

namespace isostrata {

/// Who lends jobs memory beside datasets and scenes. A loan lasts as long as what is returned is held. All are called on any thread, without a lock.
struct MemoryForJobs {
  /// Scenes that nobody looks at make way. `what` needs it. Throws too_large, with the numbers, if there is not enough.
  std::function<std::shared_ptr<void>(SessionKey session, std::uint64_t bytes, const std::string& what)> lend;
  /// Nothing makes way. Throws unavailable if there is not enough.
  std::function<std::shared_ptr<void>(std::uint64_t bytes)> lend_what_is_free;
  /// What a work of which nobody knows what it takes may ask for.
  std::function<std::uint64_t()> quarter_of_free;
  /// What an export may ask for.
  std::function<std::uint64_t(const ExportRequest& request)> for_export;
};

struct JobOptions {
  std::uint64_t max_bytes = 0;     // of datasets and everything else: --max-memory
  ActivityBoard* board = nullptr;  // as EngineOptions
  SceneRanks* ranks = nullptr;     // likewise
};

/// Each question is answered by its Ready event or by RequestFailed, on a thread of its lane. Nothing is answered after RunningOperations::cancel_all() but what
/// is being answered then. Any thread may call post. The destructor drops the questions that nobody has begun to answer, and waits for the others; what
/// was given by reference must outlive it.
class Jobs {
 public:
  Jobs(JobOptions options, OpenDatasets& datasets, RunningOperations& operations, MemoryForJobs memory, FrameEngine::Sink sink);

  void post(const OpenRequest& request);
  void post(const HistogramRequest& request);
  void post(const StatisticsRequest& request);
  void post(const ExportRequest& request);
  /// ready: what the scene's pictures were made of; null if that is not at hand. Its layers are not extracted again.
  void post(const MeasureRequest& request, std::shared_ptr<const ExtractedScene> ready);
  void post(const ThumbnailRequest& request);
  void post(const ProbeRequest& request);
  /// Over many steps it reports which is read.
  void post(const CurveRequest& request);
  void post(const LayerStatisticsRequest& request);

 private:
  using Running = std::shared_ptr<Operation>;
  template <class Request, class Answer>
  void answer(Lanes& lanes, std::uint64_t lane, WorkClass of, const Request& request, Answer answer);
  template <class Answer>
  void run(WorkClass of, SessionKey session, RequestId request, Operation& operation, const Answer& answer);

  void describe(const OpenRequest& request, Operation& operation, WorkClass of);
  void read_ranges(const OpenRequest& request, const Running& operation);
  HistogramReady histogram(const HistogramRequest& request, const Task& task);
  std::vector<IntervalFacts> measured(const MeasureRequest& request, const std::shared_ptr<const ExtractedScene>& ready, const Task& task);

  const JobOptions options_;
  OpenDatasets& datasets_;
  RunningOperations& operations_;
  const MemoryForJobs memory_;
  const FrameEngine::Sink send_;
  Lanes openers_{{0, 10}};     // by session; nice, so that readers of slow files take no picture's time
  Lanes counters_;             // of histograms and the like, by session
  Lanes probers_;              // of places in pictures, by session: a hand waits, and counts may take seconds
  Lanes readers_{{8, 10}};     // of steps for their ranges, by dataset
  Lanes followers_{{2, 10}};   // of places over all steps, by session
  Lanes exporters_{{2, 10}};   // of mesh files, by session
  Lanes thumbnails_{{2, 10}};  // by dataset; two, so that a file that hangs holds up no others
};

}  // namespace isostrata
