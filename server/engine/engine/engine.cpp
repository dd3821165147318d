#include "engine/engine/engine.h"

#include <malloc.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <deque>
#include <exception>
#include <future>
#include <map>
#include <mutex>
#include <new>
#include <optional>
#include <set>
#include <thread>
#include <tuple>

#include "base/as_error.h"
#include "base/kept_blocks.h"
#include "base/work.h"
#include "data/histogram.h"
#include "data/look_at_folder.h"
#include "data/source_mapping.h"
#include "engine/data/known_ranges.h"
#include "engine/engine/encoder_threads.h"
#include "engine/engine/kept_renderers.h"
#include "engine/engine/lanes.h"
#include "engine/engine/scene_ledger.h"
#include "engine/messages/operation.h"
#include "engine/picture/coarse_scene.h"
#include "engine/picture/draw_scene.h"
#include "engine/picture/draw_still.h"
#include "engine/picture/export_mesh.h"
#include "extraction/bricks/brick_memory.h"
#include "extraction/unstructured/ordered_memory.h"
#include "rendering/choice/native_renderer.h"

namespace isostrata {
namespace {

// An extraction that a newer scene has overtaken may still run this long. Shorter ones are shown, so a drag is never blind; and
// of two in a row at most one is cancelled, so that a drag over slow data still shows every other one.
constexpr int kDeviceFailures = 3;  // frames in a row before another renderer takes over
constexpr double kSupersededGraceMs = 250;
constexpr auto kIdlePulse = std::chrono::milliseconds(200);

// A drawing that runs in loops of ours has a pulse. One that a device does for us has none, so it gets time by its size.
std::uint32_t patience_for(const FrameRequest& request, const std::string& device) {
  const std::int64_t pixels = std::int64_t{request.width} * request.height;
  return static_cast<std::uint32_t>(1 + pixels / (1 << 22)) * (is_software_device(device) ? 6 : 1);
}

RequestFailed failure_of(const std::exception_ptr& failure, SessionKey session, RequestId request, std::uint64_t revision = 0) {
  const Error error = as_error(failure);
  return {session, request, revision, error.code(), error.what()};
}

// The parts of a scene that a picture of older intervals can still follow. A smear's mesh is another one, so its mode stays with
// what was extracted.
void take_view(Scene& of, const Scene& from) {
  of.camera = from.camera;
  of.background = from.background;
  if ((of.mode == SceneMode::smear) == (from.mode == SceneMode::smear)) of.mode = from.mode;
  of.integral = from.integral;
  of.cycle = from.cycle;
  of.unit_distance = from.unit_distance;
  of.clip_planes = from.clip_planes;
  of.annotations = from.annotations;
  of.color_range = from.color_range;
}

bool same_view(const Scene& a, const Scene& b) {
  return a.camera == b.camera && a.background == b.background && a.mode == b.mode && a.integral == b.integral &&
         a.cycle.phase == b.cycle.phase && a.unit_distance == b.unit_distance && a.clip_planes == b.clip_planes &&
         a.annotations == b.annotations && a.color_range == b.color_range;
}

std::array<std::string, 2> color_arrays(const Scene& scene) { return {scene.color_by, scene.texture}; }

/// Whether all points of the grid went into it.
bool is_whole(const std::shared_ptr<const ExtractedScene>& extracted) { return extracted && extracted->point_stride == 1; }

/// A picture that is being drawn or encoded.
struct Picture {
  std::shared_ptr<Task> task;
  std::uint64_t revision = 0;
  bool until_newer = false;  // a newer scene ends it
};

struct SessionState {
  std::optional<Scene> scene;  // the newest
  std::shared_ptr<const ExtractedScene> ready;
  Scene ready_scene;                      // that it was extracted for
  bool ready_drawn = false;               // its extraction time has been reported
  std::shared_ptr<const ExtractedScene> ready_coarse;  // of every n-th point of the same, for moving frames; null: not at hand
  std::array<std::string, 2> coarse_arrays;            // that colours and textures could run over when it was made
  std::shared_ptr<Operation> extraction;  // running or queued
  Scene extraction_scene;
  bool last_was_cut_short = false;
  std::optional<RequestFailed> extraction_failure;  // of exactly the newest scene
  std::optional<Scene> drawn_meanwhile;             // the last picture of older intervals
  std::deque<FrameRequest> waiting;
  std::map<RequestId, Picture> pictures;
  bool frame_in_lane = false, still_in_lane = false;  // a job that draws one is posted or at work
  std::set<StreamId> streams;  // ordered from and not closed
};

struct DrawOrder {
  FrameRequest request;
  Scene scene;
  std::shared_ptr<const ExtractedScene> extracted;
  double extract_ms = 0;
  std::shared_ptr<Task> task;
  std::shared_ptr<void> room;  // in memory, of a large still
  bool coarse_at_hand = false;
};

/// A script's picture or somebody's screenshot: nobody has a hand on it.
bool is_still(const FrameRequest& request) { return request.still.has_value(); }

WorkClass class_of(const FrameRequest& request) { return is_still(request) ? WorkClass::still : WorkClass::frame; }

}  // namespace

bool same_extraction(const Scene& a, const Scene& b) {
  return a.dataset == b.dataset && layer_request(a) == layer_request(b) && smear_moments(a) == smear_moments(b) &&
         lights_along_gradient(a) == lights_along_gradient(b);
}

class Engine::Impl {
 public:
  Impl(EngineOptions options, Sink sink)
      : options_(std::move(options)),
        sink_(std::move(sink)),
        catalogue_(options_.catalogue),
        store_(options_.store, [this](const std::string& id, int step, const Task& task) { return load(id, step, task); }),
        coarse_(options_.least_coarse_cells),
        bases_(options_.store.max_bytes),
        ordered_(options_.store.max_bytes) {
    make_ = options_.renderer ? options_.renderer : [choice = options_.renderer_choice] { return make_renderer(choice); };
    std::promise<std::string> started;
    auto device = started.get_future();
    render_thread_ = std::thread([this, &started] { render(started); });
    try {
      device_ = device.get();
    } catch (...) {
      render_thread_.join();
      throw;
    }
  }

  ~Impl() {
    {
      std::lock_guard lock(mutex_);
      stopping_ = true;
      for (auto& [id, operation] : operations_)
        if (const auto living = operation.lock()) living->task().cancel();
      for (auto& [key, session] : sessions_)
        for (auto& [request, picture] : session.pictures) picture.task->cancel();
    }
    base_task_.cancel();
    changed_.notify_all();
    render_thread_.join();
  }

  void post(EngineRequest request) {
    std::visit([this](auto& message) { take(message); }, request);
  }

  const Catalogue& catalogue() const { return options_.catalogue; }
  const std::string& device() const { return device_; }

 private:
  void send(EngineEvent event) { sink_(std::move(event)); }

  std::shared_ptr<Operation> begin(SessionKey session, RequestId request) {  // with mutex_ held
    auto operation =
        std::make_shared<Operation>(session, request, next_operation_++, [this](EngineEvent event) { send(std::move(event)); });
    std::erase_if(operations_, [](const auto& entry) { return entry.second.expired(); });
    operations_[operation->id()] = operation;
    return operation;
  }

  CatalogueEntry entry(const std::string& id) const {
    const std::lock_guard lock(catalogue_mutex_);
    const CatalogueEntry* found = catalogue_.find(id);
    if (!found) throw Error(ErrorCode::not_found, "dataset '" + id + "': not in this server's catalogue");
    return *found;
  }

  // One version of a dataset is never mixed with another: what was read is of the files that the catalogue lists, or it is not used.
  std::shared_ptr<const Dataset> load(const std::string& id, int step, const Task& task) const {
    const CatalogueEntry of = entry(id);
    auto dataset = options_.ranks ? options_.ranks->open({of.source, of.id}, step, task) : DatasetStore::open(options_.store, of.source, step, task);
    check_unchanged(of);
    return dataset;
  }

  static void check_unchanged(const CatalogueEntry& of) {
    if (of.mark == 0 || mark_on_disk(of.source, of.parts) == of.mark) return;
    throw Error(ErrorCode::unavailable, of.name + ": has changed on disk since it was opened, or is being written, so that this part of it cannot be read; open it again");
  }

  // A dataset that was read before its series grew knows of fewer times; whoever looks for one begins with the first step.
  std::shared_ptr<const Dataset> acquire(const CatalogueEntry& of, int step, const Task& task) {
    auto dataset = acquire_held(of, step, task);
    const auto known = step == 0 ? ranges_.find(of.id) : std::nullopt;
    if (!known || known->times.size() <= dataset->times.size()) return dataset;
    store_.drop(of.id, 0);
    return acquire_held(of, step, task);
  }

  // Where the file lies is the server's own business: a failure names it as clients know it.
  std::shared_ptr<const Dataset> acquire_held(const CatalogueEntry& of, int step, const Task& task) {
    try {
      auto dataset = store_.acquire(of.id, step, task);
      ranges_.add(of.id, *dataset);
      return dataset;
    } catch (const Error& error) {
      throw Error(error.code(), without_place(error.what(), of));
    }
  }

  static std::string without_place(std::string message, const CatalogueEntry& of) {
    for (auto at = message.find(of.source); at != std::string::npos; at = message.find(of.source, at + of.name.size()))
      message.replace(at, of.source.size(), of.name);
    return message;
  }

  // ---- requests ----

  /// Of a session; of none: of the dataset, so that one that cannot be read holds up whoever asks for it and nobody else.
  static std::uint64_t lane_of(SessionKey session, const std::string& dataset) {
    return session != 0 ? session : std::hash<std::string>()(dataset) | std::uint64_t{1} << 63;
  }

  void take(OpenRequest& request) {
    std::lock_guard lock(mutex_);
    if (stopping_) return;
    auto operation = begin(request.session, request.request);
    if (request.all_ranges)
      readers_.post(std::hash<std::string>()(request.dataset), [this, request, operation] { read_ranges(request, operation); });
    else
      openers_.post(lane_of(request.session, request.dataset), [this, request, operation] { describe(request, operation); });
  }

  void describe(const OpenRequest& request, const std::shared_ptr<Operation>& operation) {
    run(request.all_ranges ? WorkClass::background : WorkClass::scene, request.session, request.request, *operation, [&] {
      const CatalogueEntry source = entry(request.dataset);
      const auto dataset = acquire_held(source, 0, operation->task());
      look_for_steps(source, *dataset, operation->task());
      FirstView view = view_of_series(source, dataset, operation->task());  // may read steps: what is known of the ranges is asked for afterwards
      if (options_.ranks)
        for (const PointArray& array : dataset->arrays) drop_pages(array);  // samples of all of it, which this rank does not keep
      const KnownRanges::Known known = ranges_.find(source.id).value_or(KnownRanges::Known{SeriesRanges(*dataset), {}, {}, {}});
      DatasetFacts facts = dataset_facts(source.id, source.name, *dataset, known.ranges);
      if (known.times.size() > facts.times.size()) {
        facts.times = known.times;
        facts.notes = known.said;
      }
      facts.notes.insert(facts.notes.end(), known.notes.begin(), known.notes.end());
      facts.first_view = std::move(view);
      send(DatasetReady{request.session, request.request, std::move(facts)});
    });
  }

  // Of a series that has grown the first new step says what times there are; it is what somebody will look at next, too.
  void look_for_steps(const CatalogueEntry& source, const Dataset& first_step, const Task& task) {
    {
      const std::lock_guard lock(catalogue_mutex_);
      if (!grown_.contains(source.id)) return;
    }
    const auto known = ranges_.find(source.id);
    const auto steps = static_cast<int>(known ? known->times.size() : first_step.times.size());
    try {
      acquire_held(source, steps, task);
    } catch (const Error& error) {
      if (error.code() != ErrorCode::not_found) throw;  // else what has come is no step
    }
    const std::lock_guard lock(catalogue_mutex_);
    grown_.erase(source.id);
  }

  // Made once for a dataset that is held. A series of which nothing was to be seen is looked at again, for steps may be known by then that
  // have more.
  FirstView view_of_series(const CatalogueEntry& source, const std::shared_ptr<const Dataset>& first_step, const Task& task) {
    {
      std::lock_guard lock(mutex_);
      if (const auto it = views_.find(source.id); it != views_.end() && it->second.first.lock() == first_step) return it->second.second;
    }
    const auto borrow = [&](int step, const Task& of) {
      auto dataset = store_.borrow(source.id, step, of);
      ranges_.add(source.id, *dataset);
      return dataset;
    };
    FirstView view = first_view(*first_step, borrow, {}, task);
    if (view.array.empty()) {
      const auto known = ranges_.find(source.id);
      for (const ArrayRanges& array : known ? known->ranges.arrays() : std::vector<ArrayRanges>{})
        if (array.all.lower < array.all.upper) return first_view(*first_step, borrow, {array.name, known->ranges.widest_step(array.name)}, task);
      return view;
    }
    std::lock_guard lock(mutex_);
    std::erase_if(views_, [](const auto& of) { return of.second.first.expired(); });
    views_[source.id] = {first_step, view};
    return view;
  }

  // One more step, then whoever else waits for the same series: what two sessions show is read once. The importers that are
  // started here are as nice as the thread.
  void read_ranges(const OpenRequest& request, const std::shared_ptr<Operation>& operation) {
    bool more = false;
    try {
      const Doing opening(options_.board, Stage::opening, request.session, request.request, operation->id());
      const Task& task = operation->task();
      const Work work(request.session, WorkClass::background, {&task, true, opening.waiting()});
      task.check();
      const CatalogueEntry& source = entry(request.dataset);
      if (!ranges_.next(source.id)) acquire(source, 0, task);
      if (const int step = *ranges_.next(source.id); step >= 0) {
        const SeriesRanges known = ranges_.find(source.id)->ranges;
        const double steps = known.steps();
        operation->report_part(known.known_steps() / steps, (known.known_steps() + 1) / steps, "reading the ranges of all steps");
        task.report(0, "reading");
        read_step(source, step, task);
        more = true;
      }
    } catch (...) {
      send(failure_of(std::current_exception(), request.session, request.request));
      return operation->finish();
    }
    if (more)
      readers_.post(std::hash<std::string>()(request.dataset), [this, request, operation] { read_ranges(request, operation); });
    else
      describe(request, operation);
  }

  void read_step(const CatalogueEntry& source, int step, const Task& task) {
    try {
      ranges_.add(source.id, *store_.borrow(source.id, step, task));
    } catch (const Error& error) {
      if (error.code() == ErrorCode::cancelled) throw;
      ranges_.skip(source.id, step, without_place(error.what(), source));
    }
  }

  /// Whether each rank looks at its part of the values: this process has them mapped, and keeps none of them in memory.
  bool by_ranks(const PointArray& array) const {
    return options_.ranks && std::visit([](auto values) { return !values.empty() && is_in_source(values.data()); }, array.values);
  }
  RankedSource of_ranks(const std::string& dataset) const {
    const CatalogueEntry source = entry(dataset);
    return {source.source, source.id};
  }

  void take(HistogramRequest& request) {
    std::lock_guard lock(mutex_);
    if (stopping_) return;
    counters_.post(lane_of(request.session, request.dataset), [this, request, operation = begin(request.session, request.request)] {
      run(WorkClass::still, request.session, request.request, *operation, [&] {
        const auto dataset = acquire(entry(request.dataset), request.step, operation->task());
        const PointArray& array = dataset->array(request.array);
        const ValueRange range = join(request.least, {array.lower, array.upper});
        std::vector<std::uint64_t> counts(static_cast<std::size_t>(std::clamp(request.bins, 0, 1 << 20)));
        if (!range.empty())
          counts = by_ranks(array) ? options_.ranks->histogram(of_ranks(request.dataset), dataset, array.name, range.lower, range.upper, request.bins, operation->task())
                                   : kept_histogram(array, range.lower, range.upper, request.bins);
        send(HistogramReady{request.session, request.request, request.dataset, request.step, request.array, range.lower,
                            range.upper, std::move(counts)});
      });
    });
  }

  void take(StatisticsRequest& request) {
    std::lock_guard lock(mutex_);
    if (stopping_) return;
    counters_.post(lane_of(request.session, request.dataset), [this, request, operation = begin(request.session, request.request)] {
      run(WorkClass::still, request.session, request.request, *operation, [&] {
        const auto dataset = acquire(entry(request.dataset), request.step, operation->task());
        const PointArray& array = dataset->array(request.array);
        send(StatisticsReady{request.session, request.request, request.dataset, request.step, request.array,
                             by_ranks(array) ? options_.ranks->statistics(of_ranks(request.dataset), dataset, array.name, operation->task()) : statistics(array)});
      });
    });
  }

  void take(ExportRequest& request) {
    std::lock_guard lock(mutex_);
    if (stopping_) return;
    exporters_.post(request.session, [this, request, operation = begin(request.session, request.request)] {
      run(WorkClass::background, request.session, request.request, *operation, [&] {
        const CatalogueEntry& source = entry(request.scene.dataset);
        const StepSource steps = [&](int step, const Task& task) { return acquire(source, step, task); };
        const std::uint64_t bytes = export_bytes(request);
        const auto room = room_for_work(request.session, bytes, "this export");
        const ExportedMesh mesh = export_mesh(steps, request.scene, request.path, request.options, {.memory = bytes}, operation->task());
        send(ExportReady{request.session, request.request, mesh});
      });
    });
  }

  void take(MeasureRequest& request) {
    std::lock_guard lock(mutex_);
    if (stopping_) return;
    std::shared_ptr<const ExtractedScene> ready;  // what the pictures were made of
    const auto it = sessions_.find(request.session);
    if (it != sessions_.end() && is_whole(it->second.ready) && same_extraction(it->second.ready_scene, request.scene))
      ready = it->second.ready;
    counters_.post(request.session, [this, request, ready, operation = begin(request.session, request.request)] {
      run(WorkClass::still, request.session, request.request, *operation, [&] {
        const CatalogueEntry& source = entry(request.scene.dataset);
        const StepSource steps = [&](int step, const Task& task) { return acquire(source, step, task); };
        // How far a volume may be off is asked of the cells, which are not kept where pictures are made of bricks.
        const auto extracted = ready && !ready->bricks ? ready : extract_from(source, steps, request.scene, nullptr, operation->task(), {});
        send(LayersMeasured{request.session, request.request, request.scene.revision,
                            interval_facts(*extracted, request.scene, true, operation->task())});
      });
    });
  }

  template <class Job>
  void run(WorkClass of, SessionKey session, RequestId request, Operation& operation, const Job& job) {
    try {
      const Doing opening(options_.board, Stage::opening, session, request, operation.id());
      operation.task().check();
      const Work work(session, of, {&operation.task(), true, opening.waiting()});
      job();
    } catch (...) {
      send(failure_of(std::current_exception(), session, request));
    }
    operation.finish();
  }

  void take(CatalogueUpdate& update) {
    std::set<std::string> ids;
    {
      const std::lock_guard lock(catalogue_mutex_);
      for (CatalogueEntry& of : update.entries) {
        ids.insert(of.id);
        const CatalogueEntry* before = catalogue_.find(of.id);
        if (before && before->parts < of.parts) grown_.insert(of.id);
        catalogue_.put(std::move(of));
      }
    }
    // What could not be read while it was being written is tried again.
    const std::lock_guard lock(mutex_);
    for (auto& [key, session] : sessions_) {
      if (!session.scene || !session.extraction_failure || !ids.contains(session.scene->dataset)) continue;
      session.extraction_failure.reset();
      advance(key, session);
    }
  }

  void take(SceneUpdate& update) {
    std::lock_guard lock(mutex_);
    if (stopping_) return;
    SessionState& session = sessions_[update.session];
    const bool same = session.scene && same_extraction(*session.scene, update.scene);
    session.scene = std::move(update.scene);
    if (!same) session.extraction_failure.reset();
    for (auto& [request, picture] : session.pictures)
      if (picture.until_newer && picture.revision < session.scene->revision) picture.task->cancel();
    advance(update.session, session);
    draw_soon(update.session, session);
  }

  // Starts or overtakes the extraction that the newest scene needs. With mutex_ held.
  void advance(SessionKey key, SessionState& session) {
    const Scene& scene = *session.scene;
    if (stopping_ || scene.dataset.empty() || session.extraction_failure) return;
    if (session.extraction) {
      if (same_extraction(session.extraction_scene, scene)) return;
      const bool other_data = session.extraction_scene.dataset != scene.dataset ||
                              session.extraction_scene.array != scene.array || session.extraction_scene.step != scene.step;
      if (other_data)
        session.extraction->supersede(0);
      else if (!session.last_was_cut_short)
        session.extraction->supersede(kSupersededGraceMs);
      return;
    }
    if (is_whole(session.ready) && same_extraction(session.ready_scene, scene)) return;
    session.extraction = begin(key, 0);
    session.extraction_scene = scene;
    extractors_.post(key, [this, key, operation = session.extraction, scene, previous = session.ready,
                           before = session.ready ? std::optional(session.ready_scene) : std::nullopt] {
      extract(key, operation, scene, previous, before);
    });
  }

  std::shared_ptr<const ExtractedScene> extract_from(const CatalogueEntry& source, const StepSource& steps, const Scene& scene,
                                                     const std::shared_ptr<const ExtractedScene>& previous, const Task& task, const SceneAids& aids) {
    if (options_.ranks) return options_.ranks->extract({source.source, source.id}, steps, scene, previous, task, aids);
    return extract_scene(steps, scene, previous, task, aids);
  }

  /// previous, before: what is ready, and the scene that it is of.
  void extract(SessionKey key, const std::shared_ptr<Operation>& operation, const Scene& scene, const std::shared_ptr<const ExtractedScene>& previous,
               const std::optional<Scene>& before) {
    std::shared_ptr<const ExtractedScene> extracted;
    std::exception_ptr failure;
    try {
      const Doing extracting(options_.board, Stage::extracting, key, 0, operation->id());
      operation->task().check();
      const Work work(key, WorkClass::scene, {&operation->task(), true, extracting.waiting()});
      const CatalogueEntry& source = entry(scene.dataset);
      const StepSource steps = [this, &source](int step, const Task& task) { return acquire(source, step, task); };
      SceneAids aids;
      aids.bricks = &bricks_;
      aids.ordered = &ordered_;
      aids.bases = &bases_;
      aids.tetrahedra = cuts_intervals_ ? TetrahedraWay::automatic : TetrahedraWay::split;
      if (draws_bricks_) aids.least_in_bricks = kLeastInBricksOfFrames;
      aids.max_bytes = room_for(key, false);
      const bool shows_it = is_whole(previous) && before->dataset == scene.dataset && before->array == scene.array;  // with other intervals, or at another step
      if (!options_.ranks && !shows_it)
        if (auto first = coarse_.extract(steps, scene, operation->task())) show_meanwhile(key, operation, scene, std::move(first));
      try {
        extracted = extract_from(source, steps, scene, previous, operation->task(), aids);
      } catch (const Error& error) {
        const std::uint64_t room = error.code() == ErrorCode::too_large ? room_for(key, true) : 0;
        if (room <= aids.max_bytes) throw;
        aids.max_bytes = room;
        extracted = extract_from(source, steps, scene, previous, operation->task(), aids);
      }
    } catch (...) {
      failure = std::current_exception();
    }
    operation->finish();
    if (extracted) prepare_tetrahedra(*extracted, scene, previous.get());
    if (extracted && before) read_ahead(*extracted, scene, *before);
    std::vector<EngineEvent> events;
    std::vector<std::shared_ptr<const ExtractedScene>> given_back;
    {
      std::lock_guard lock(mutex_);
      const auto it = sessions_.find(key);
      if (it == sessions_.end() || it->second.extraction != operation) return;
      SessionState& session = it->second;
      session.extraction.reset();
      session.last_was_cut_short = failure && operation->superseded();
      if (extracted) {
        scenes_.hold(key, scene_bytes(*extracted));
        session.ready = extracted;
        session.ready_scene = scene;
        session.ready_drawn = false;
        session.ready_coarse.reset();
        prepare_motion(key, extracted, scene);
      } else if (same_extraction(scene, *session.scene)) {
        // Nothing is tried again until the scene changes: whoever waits for it is told once.
        session.extraction_failure = failure_of(failure, key, 0, session.scene->revision);
        events.push_back(*session.extraction_failure);
        fail_waiting(session, events);
      }
      advance(key, session);
      draw_soon(key, session);
      given_back = give_back(max_scene_bytes(), key);
    }
    let_go(std::move(given_back));
    for (EngineEvent& event : events) send(std::move(event));
  }

  /// Of a scene that takes long to draw, the same of every n-th point is made in advance, for the next hand that turns it. With mutex_ held.
  void prepare_motion(SessionKey key, const std::shared_ptr<const ExtractedScene>& extracted, const Scene& scene) {
    std::int64_t tetrahedra = 0;
    for (const IntervalSummary& of : extracted->summaries()) tetrahedra += of.tetrahedra;
    if (options_.ranks || tetrahedra < options_.least_coarse_tetrahedra || extracted->base || !extracted->dataset->grid.structured()) return;
    movers_.post(key, [this, key, extracted, scene] {
      const auto is_ready = [&] {
        const auto it = sessions_.find(key);
        return it != sessions_.end() && it->second.ready == extracted;
      };
      {
        const std::lock_guard lock(mutex_);
        if (!is_ready() || scene_bytes(*extracted) / 3 > max_scene_bytes() - std::min(max_scene_bytes(), scenes_.bytes())) return;
      }
      std::shared_ptr<const ExtractedScene> coarse;
      try {
        const Doing extracting(options_.board, Stage::extracting, 0, 0);
        const Work work(key, WorkClass::still, {&base_task_, true, extracting.waiting()});
        coarse = coarse_.extract_for_motion(extracted->dataset, scene, base_task_);
      } catch (const std::exception& error) {  // a hand turns all points then
        return;
      }
      if (!coarse) return;
      const std::lock_guard lock(mutex_);
      if (!is_ready()) return;
      scenes_.hold(key, scene_bytes(*extracted) + scene_bytes(*coarse));
      sessions_.at(key).ready_coarse = std::move(coarse);
      sessions_.at(key).coarse_arrays = color_arrays(scene);
    });
  }

  /// What is drawn until the extraction is done.
  void show_meanwhile(SessionKey key, const std::shared_ptr<Operation>& operation, const Scene& scene, std::shared_ptr<const ExtractedScene> coarse) {
    const std::lock_guard lock(mutex_);  // what was there before is held by who extracts
    const auto it = sessions_.find(key);
    if (it == sessions_.end() || it->second.extraction != operation) return;
    SessionState& session = it->second;
    scenes_.hold(key, scene_bytes(*coarse));
    session.ready = std::move(coarse);
    session.ready_coarse.reset();
    session.ready_scene = scene;
    session.ready_drawn = false;
    session.drawn_meanwhile.reset();
    draw_soon(key, session);
  }

  // ---- memory: datasets, then what works that are under way take, and then scenes in what is left of --max-memory ----

  /// With mutex_ held.
  std::uint64_t max_scene_bytes() const {
    const std::uint64_t most = options_.store.max_bytes,
                        other = store_.held_bytes() + bases_.held_bytes() + ordered_.bytes() + scenes_.in_work();
    return most - std::min(most, other);
  }

  /// Gives back what nobody looks at, so that a work of so many bytes has room, and begins it if it has. Returns how much is free. With mutex_ held; the
  /// caller drops `given_back` without.
  std::uint64_t try_work(SessionKey session, std::uint64_t bytes, std::vector<std::shared_ptr<const ExtractedScene>>& given_back) {
    const std::uint64_t most = max_scene_bytes();
    given_back = give_back(most - std::min(most, bytes), session);
    const std::uint64_t left = most - std::min(most, scenes_.bytes());
    if (bytes <= left) scenes_.begin_work(bytes);
    return left;
  }

  /// Ends a work that has begun; then whoever waits for room looks again.
  std::shared_ptr<void> until_it_ends(std::uint64_t bytes) {
    return {static_cast<void*>(this), [this, bytes](void*) {
              const std::lock_guard lock(mutex_);
              scenes_.end_work(bytes);
              for (auto& [key, session] : sessions_) draw_soon(key, session);
            }};
  }

  /// Room for one work, as long as it is held. Throws too_large, with the numbers, where there is not enough.
  std::shared_ptr<void> room_for_work(SessionKey session, std::uint64_t bytes, const std::string& what) {
    std::vector<std::shared_ptr<const ExtractedScene>> given_back;
    std::uint64_t left = 0;
    {
      const std::lock_guard lock(mutex_);
      left = try_work(session, bytes, given_back);
    }
    let_go(std::move(given_back));
    if (bytes <= left) return until_it_ends(bytes);
    throw Error(ErrorCode::too_large, what + " needs about " + std::to_string(bytes / 1'000'000) + " MB; " + std::to_string(left / 1'000'000) + " of the " +
                                          std::to_string(options_.store.max_bytes / 1'000'000) + " MB that this server may take are free (--max-memory)");
  }

  /// What an export may take: as much as the session's own scene of the same layers does, where that is known, else a quarter of what is free.
  std::uint64_t export_bytes(const ExportRequest& request) {
    const std::lock_guard lock(mutex_);
    const auto it = sessions_.find(request.session);
    const std::uint64_t most = max_scene_bytes(), free = most - std::min(most, scenes_.bytes());
    if (it != sessions_.end() && is_whole(it->second.ready) && same_extraction(it->second.ready_scene, request.scene)) {
      // Its facets and values come on top, and it needs some room to be told by numbers that it has too little.
      return std::max(2 * scenes_.bytes_of(request.session), kLeastExport);
    }
    return std::max(free / 4, kLeastExport);
  }

  /// What a still takes beside the scene: its pixels, and their copies on the way to a file. Measured bytes a pixel (worker's peak, 8192 x 8192 and
  /// 4096 x 4096): PNG 7.5, WebP 17.4, annotated PNG 24.1, EXR 48.3. 0 for a still that takes no more than a frame may.
  static std::uint64_t still_bytes(const FrameRequest& request, const Scene& scene) {
    const bool annotated = (request.annotations ? *request.annotations : scene.annotations).any();
    const std::uint64_t as_floats = 50, as_bytes = (annotated ? 26 : 10) + (request.still == StillFormat::webp ? 10 : 0);
    const std::uint64_t of_pixel = request.still && is_float(*request.still) ? as_floats : as_bytes;
    const std::uint64_t bytes = of_pixel * static_cast<std::uint64_t>(request.width) * static_cast<std::uint64_t>(request.height);
    return bytes <= kFrameBytes ? 0 : bytes;
  }

  /// An order for the session's next still and, where it is large, its room; nothing where that has to wait for others that work. With mutex_ held.
  std::optional<DrawOrder> still_order(SessionKey key, SessionState& session, std::vector<std::shared_ptr<const ExtractedScene>>& given_back) {
    const auto drawn_meanwhile = session.drawn_meanwhile;
    const bool ready_drawn = session.ready_drawn;
    auto order = order_of(session, is_still);
    const std::uint64_t bytes = order ? still_bytes(order->request, order->scene) : 0;
    if (bytes == 0) return order;
    if (bytes <= try_work(key, bytes, given_back)) {
      order->room = until_it_ends(bytes);
    } else if (scenes_.in_work() > 0) {
      session.waiting.push_front(order->request);
      session.pictures.erase(order->request.request);
      session.drawn_meanwhile = drawn_meanwhile;
      session.ready_drawn = ready_drawn;
      return std::nullopt;
    }
    return order;  // without room where there will be none: it is refused
  }

  /// What sessions that nobody has looked at for longest hold, so that the rest is at most that. It is made again when somebody looks.
  /// What is being drawn or extracted stays, and so does `but`'s. With mutex_ held; the caller drops it without.
  std::vector<std::shared_ptr<const ExtractedScene>> give_back(std::uint64_t most, SessionKey but) {
    std::vector<std::shared_ptr<const ExtractedScene>> all;
    const auto may_go = [&](SessionKey key) {
      const auto it = sessions_.find(key);
      return key != but && it != sessions_.end() && it->second.waiting.empty() && it->second.pictures.empty() && !it->second.extraction;
    };
    for (const SessionKey key : scenes_.too_many(most, may_go)) {
      SessionState& session = sessions_.at(key);
      all.push_back(std::move(session.ready));
      all.push_back(std::move(session.ready_coarse));
      session.ready.reset();
      session.ready_coarse.reset();
      scenes_.hold(key, 0);
      renderers_.drop(key);
    }
    return all;
  }

  /// Without the lock: what was given back goes to the kernel, not to what this process keeps.
  static void let_go(std::vector<std::shared_ptr<const ExtractedScene>> given_back) {
    if (given_back.empty()) return;
    given_back.clear();
    free_kept_blocks();
#ifdef __GLIBC__
    malloc_trim(0);
#endif
  }

  /// For the session's next scene. Others that are not looked at make room for one as large as its last, or go altogether.
  std::uint64_t room_for(SessionKey key, bool altogether) {
    std::vector<std::shared_ptr<const ExtractedScene>> given_back;
    std::uint64_t most = 0, others = 0;
    {
      const std::lock_guard lock(mutex_);
      const std::uint64_t own = scenes_.bytes_of(key);
      most = max_scene_bytes();
      given_back = give_back(altogether ? 0 : most - std::min(most, 2 * own), key);
      others = scenes_.bytes() - scenes_.bytes_of(key);
    }
    let_go(std::move(given_back));
    // What a renderer makes of it comes on top; and who has little room is told so by the extraction, with the numbers.
    return (most - std::min(most, others)) / 2;
  }

  /// Who goes from one step to the next will go on: the step after it is read while this one is drawn.
  void read_ahead(const ExtractedScene& extracted, const Scene& scene, const Scene& before) {
    const int next = scene.step + (scene.step - before.step > 0 ? 1 : -1);
    if (scene.time || before.time || scene.dataset != before.dataset || std::abs(scene.step - before.step) != 1 || next < 0 ||
        next >= static_cast<int>(extracted.dataset->times.size()) || !store_.has_room_for(scene.dataset, next))
      return;
    ahead_.post(std::hash<std::string>()(scene.dataset), [this, dataset = scene.dataset, next] {
      const Doing opening(options_.board, Stage::opening, 0, 0);
      try {
        const Work work(0, WorkClass::background, {&base_task_, true, opening.waiting()});
        acquire_held(entry(dataset), next, base_task_);
      } catch (const std::exception&) {  // who asks for it is told why
      }
    });
  }

  /// Intervals that were moved once will be moved again, and steps on one mesh will be followed by others: the grid of tetrahedra that they are cut
  /// out of then, where they are drawn or by extraction, is made meanwhile.
  void prepare_tetrahedra(const ExtractedScene& extracted, const Scene& scene, const ExtractedScene* previous) {
    if (extracted.base || !previous || previous->request == extracted.request || !only_tetrahedra(*extracted.dataset)) return;
    const bool same_steps = previous->steps == extracted.steps;
    const bool played = !same_steps && previous->dataset && previous->dataset->grid.storage == extracted.dataset->grid.storage;
    if (!same_steps && !played) return;
    const bool cut = same_steps && cuts_intervals_ && cuts_exactly(scene, extracted.array) && !bases_.find(extracted.dataset, extracted.array);
    const LayerRequest& request = extracted.request;
    const bool lay_out = request.terms.empty() && !request.time && !ordered_.knows(extracted.dataset->grid);
    if (cut ? previous->request.intervals == request.intervals : !lay_out) return;
    if (base_in_making_.exchange(true)) return;
    preparers_.post(0, [this, cut, dataset = extracted.dataset, array = extracted.array] {
      const Doing extracting(options_.board, Stage::extracting, 0, 0);
      try {
        const Work work(0, WorkClass::background, {&base_task_, true, extracting.waiting()});
        if (cut)
          bases_.make(dataset, array, base_task_);
        else
          ordered_.make(dataset->grid, base_task_);
      } catch (const std::exception&) {  // extraction goes on without it
      }
      base_in_making_ = false;
    });
  }

  static void fail_waiting(SessionState& session, std::vector<EngineEvent>& events) {
    for (const FrameRequest& request : session.waiting) {
      RequestFailed failed = *session.extraction_failure;
      failed.request = request.request;
      events.push_back(std::move(failed));
    }
    session.waiting.clear();
  }

  void take(FrameRequest& request) {
    std::optional<RequestFailed> failed;
    {
      std::lock_guard lock(mutex_);
      if (stopping_) return;
      const auto it = sessions_.find(request.session);
      if (it == sessions_.end() || !it->second.scene || it->second.scene->dataset.empty()) {
        failed = RequestFailed{request.session, request.request, 0, ErrorCode::not_found,
                               "no dataset is open: there is nothing to draw"};
      } else if (it->second.extraction_failure) {
        failed = *it->second.extraction_failure;
        failed->request = request.request;
      } else {
        it->second.waiting.push_back(request);
        scenes_.see(request.session);
        if (!it->second.ready) advance(request.session, it->second);  // it was given back
        if (request.video) it->second.streams.insert(request.video->stream);
        draw_soon(request.session, it->second);
      }
    }
    if (failed) send(std::move(*failed));
  }

  void take(CancelRequest& request) {
    std::lock_guard lock(mutex_);
    for (auto& [id, operation] : operations_) {
      const auto living = operation.lock();
      if (!living || living->session() != request.session) continue;
      if (id != request.operation && (request.request == 0 || living->request() != request.request)) continue;
      if (request.superseded) living->supersede(0);
      living->task().cancel();
    }
  }

  void take(ForgetFrame& request) {
    std::lock_guard lock(mutex_);
    const auto it = sessions_.find(request.session);
    if (it == sessions_.end()) return;
    std::erase_if(it->second.waiting, [&](const FrameRequest& f) { return f.request == request.request; });
    if (const auto picture = it->second.pictures.find(request.request); picture != it->second.pictures.end())
      picture->second.task->cancel();
  }

  void take(CloseSession& request) {
    if (close_session(request.session)) free_kept_blocks();  // nobody is there who would want them soon
  }
  /// Whether it was the last.
  bool close_session(SessionKey session) {
    std::shared_ptr<const ExtractedScene> freed_outside_the_lock;
    std::lock_guard lock(mutex_);
    for (auto& [id, operation] : operations_)
      if (const auto living = operation.lock(); living && living->session() == session) living->task().cancel();
    const auto it = sessions_.find(session);
    if (it == sessions_.end()) return false;
    freed_outside_the_lock = std::move(it->second.ready);
    for (auto& [request, picture] : it->second.pictures) picture.task->cancel();
    sessions_.erase(it);
    renderers_.drop(session);
    scenes_.forget(session);
    encoders_.close_session(session);
    return sessions_.empty();
  }

  void take(CloseStream& request) {
    std::lock_guard lock(mutex_);
    const auto it = sessions_.find(request.session);
    if (it != sessions_.end()) it->second.streams.erase(request.stream);
    encoders_.close(request.session, request.stream);
  }

  bool stream_is_open(SessionKey session, StreamId stream) {
    std::lock_guard lock(mutex_);
    const auto it = sessions_.find(session);
    return it != sessions_.end() && it->second.streams.contains(stream);
  }

  // ---- the render thread: of a device. Without one it only shows that the engine lives ----

  void render(std::promise<std::string>& started) {
    std::unique_ptr<Renderer> renderer;
    int failures = 0;  // of the device, frames in a row
    try {
      const Doing starting(Doing::OnRenderThread{}, options_.board, Stage::starting, 0, 0, 1);
      renderer = make_();
      take_renderer(*renderer);
      started.set_value(renderer->device());
    } catch (...) {
      started.set_exception(std::current_exception());
      return;
    }
    for (;;) {
      std::optional<DrawOrder> order;
      std::string instead;
      {
        std::unique_lock lock(mutex_);
        while (!changed_.wait_for(lock, kIdlePulse, [&] { return stopping_ || (order = next_order()); })) beat();
        if (stopping_) return;
        instead = instead_;
      }
      const std::optional<std::string> failure = draw(*renderer, std::move(*order), instead, false);
      failures = failure ? failures + 1 : 0;
      if (failures < kDeviceFailures || !instead.empty()) continue;
      instead = " in place of " + renderer->device() + ", which failed " + std::to_string(failures) +
                " frames in a row, the last with: " + *failure;
      try {
        auto make = options_.fallback_renderer ? options_.fallback_renderer : [] { return make_renderer({"native", "native"}); };
        renderer = make();
        const std::lock_guard lock(mutex_);
        make_ = std::move(make);
        instead_ = std::move(instead);
      } catch (const std::exception&) {
        failures = 0;  // go on as before; each frame says why it fails
        continue;
      }
      take_renderer(*renderer);
    }
  }

  void beat() {
    if (options_.board) ++options_.board->slots[ActivityBoard::kRenderThread].pulse;
  }

  /// What was made for a renderer that cuts intervals is made anew where the next one cannot.
  void take_renderer(const Renderer& renderer) {
    const std::lock_guard lock(mutex_);
    cuts_intervals_ = renderer.cuts_intervals();
    draws_bricks_ = renderer.draws_bricks();
    in_lanes_ = needs_no_device(renderer);
    for (auto& [key, session] : sessions_) {
      if (session.ready && ((!cuts_intervals_ && session.ready->base) || (!draws_bricks_ && session.ready->bricks))) {
        session.ready.reset();
        session.ready_coarse.reset();
        scenes_.hold(key, 0);
        advance(key, session);
      }
      draw_soon(key, session);
    }
  }

  // ---- lanes: each session draws for itself, its stills beside its frames ----

  /// Has drawn what is waiting. With mutex_ held.
  void draw_soon(SessionKey key, SessionState& session) {
    if (stopping_) return;
    if (!in_lanes_) return changed_.notify_all();
    const auto start = [&](bool still, bool& in_lane, Lanes& lanes) {
      if (in_lane || std::none_of(session.waiting.begin(), session.waiting.end(),
                                  [&](const FrameRequest& f) { return is_still(f) == still; }))
        return;
      in_lane = true;
      lanes.post(key, [this, key, still] { draw_in_lane(key, still); });
    };
    start(false, session.frame_in_lane, frames_);
    start(true, session.still_in_lane, stills_);
  }

  /// One picture, so that others who wait for a lane have their turn.
  void draw_in_lane(SessionKey key, bool still) {
    std::optional<DrawOrder> order;
    std::function<std::unique_ptr<Renderer>()> make;
    std::string instead;
    std::vector<std::shared_ptr<const ExtractedScene>> given_back;
    {
      const std::lock_guard lock(mutex_);
      const auto it = sessions_.find(key);
      if (stopping_ || it == sessions_.end()) return;
      order = still ? still_order(key, it->second, given_back) : order_of(it->second, [](const FrameRequest& f) { return !is_still(f); });
      if (!order) {
        (still ? it->second.still_in_lane : it->second.frame_in_lane) = false;
        return;
      }
      make = make_;
      instead = instead_;
    }
    let_go(std::move(given_back));
    std::unique_ptr<Renderer> renderer = renderers_.take(key, still);
    try {
      if (!renderer) renderer = make();
      draw(*renderer, std::move(*order), instead, true);
    } catch (...) {
      end_picture(key, order->request.request);
      send(failure_of(std::current_exception(), key, order->request.request, order->scene.revision));
    }
    const std::lock_guard lock(mutex_);
    const auto it = sessions_.find(key);
    if (it == sessions_.end()) return;
    if (renderer) renderers_.give(key, still, std::move(renderer));
    (still ? it->second.still_in_lane : it->second.frame_in_lane) = false;
    draw_soon(key, it->second);
  }

  void end_picture(SessionKey key, RequestId request) {
    const std::lock_guard lock(mutex_);
    if (const auto it = sessions_.find(key); it != sessions_.end()) it->second.pictures.erase(request);
  }

  // The next session in turn that has a frame to draw. With mutex_ held.
  std::optional<DrawOrder> next_order() {
    if (in_lanes_) return std::nullopt;
    auto it = sessions_.upper_bound(last_drawn_);
    for (std::size_t n = sessions_.size(); n > 0; --n, ++it) {
      if (it == sessions_.end()) it = sessions_.begin();
      if (auto order = order_of(it->second, [](const FrameRequest&) { return true; })) {
        last_drawn_ = it->first;
        return order;
      }
    }
    return std::nullopt;
  }

  /// Of the requests that fit. With mutex_ held.
  template <class Fits>
  static std::optional<DrawOrder> order_of(SessionState& session, const Fits& fits) {
    if (!session.ready || !session.scene) return std::nullopt;
    const bool whole = is_whole(session.ready), newest = whole && same_extraction(session.ready_scene, *session.scene);
    DrawOrder order;
    const auto request = std::find_if(session.waiting.begin(), session.waiting.end(), [&](const FrameRequest& f) {
      return fits(f) && (newest || !f.lossless) && (whole || !is_still(f));
    });
    if (request == session.waiting.end()) return std::nullopt;
    if (newest) {
      order.scene = *session.scene;
      session.ready_scene = *session.scene;
      session.drawn_meanwhile.reset();
    } else {
      // The intervals of the newest scene are still being extracted. The camera need not wait for them.
      if (session.ready_scene.dataset != session.scene->dataset) return std::nullopt;
      order.scene = session.ready_scene;
      take_view(order.scene, *session.scene);
      if (!whole) order.scene.revision = std::min(order.scene.revision, session.scene->revision - 1);  // it contains none wholly: who waits goes on
      const bool seen = session.ready_drawn && session.drawn_meanwhile
                            ? same_view(*session.drawn_meanwhile, order.scene)
                            : session.ready_drawn && same_view(session.ready_scene, order.scene);
      if (seen) return std::nullopt;
      session.drawn_meanwhile = order.scene;
    }
    order.request = *request;
    session.waiting.erase(request);
    order.task = std::make_shared<Task>();
    session.pictures[order.request.request] = {order.task, order.scene.revision, order.request.band_bytes > 0};
    order.coarse_at_hand = newest && session.ready_coarse && session.coarse_arrays == color_arrays(order.scene);
    order.extracted = order.coarse_at_hand && order.request.coarse ? session.ready_coarse : session.ready;
    order.extract_ms = session.ready_drawn ? 0 : session.ready->extract_ms;
    session.ready_drawn = true;
    return order;
  }

  /// Why the device failed, where it did. instead: is added to the device's name. in_lane: the thread is the session's, so that
  /// it may wait for its turn and end in the middle; a device is everybody's, so there turns are taken between pictures.
  std::optional<std::string> draw(Renderer& renderer, DrawOrder order, const std::string& instead, bool in_lane) {
    const FrameRequest& request = order.request;
    // On the board before it is said: whoever hears of it and looks finds it there.
    std::optional<Doing> drawing;
    const std::uint32_t patience = patience_for(request, device_);
    if (in_lane)
      drawing.emplace(options_.board, Stage::drawing, request.session, request.request, 0, patience);
    else
      drawing.emplace(Doing::OnRenderThread{}, options_.board, Stage::drawing, request.session, request.request, patience);
    send(FrameStarted{request.session, request.request});
    try {
      if (const std::uint64_t bytes = is_still(request) && !order.room ? still_bytes(request, order.scene) : 0)
        order.room = room_for_work(request.session, bytes, "a picture of " + std::to_string(request.width) + "x" + std::to_string(request.height));
      Drawn drawn = [&] {
        const Work work(request.session, class_of(request), {in_lane ? order.task.get() : nullptr, in_lane, drawing->waiting()});
        return draw_scene(renderer, order, instead);
      }();
      drawing.reset();
      order.extracted.reset();
      if (in_lane && is_still(request)) {
        encode(nullptr, drawn, order);
      } else {
        order.room.reset();  // what waits for an encoder may be dropped with mutex_ held
        const std::lock_guard lock(mutex_);
        if (!sessions_.contains(request.session)) throw Error(ErrorCode::cancelled, "the session has ended");
        encoders_.post(request.session,
                       [this, drawn = std::make_shared<Drawn>(std::move(drawn)), order](StreamEncoders& streams) mutable {
                         encode(&streams, *drawn, order);
                         drawn.reset();
                       });
      }
      return std::nullopt;
    } catch (const Error& error) {
      end_picture(request.session, request.request);
      send(failure_of(std::current_exception(), request.session, request.request, order.scene.revision));
      if (error.code() == ErrorCode::unavailable) return error.what();
    } catch (...) {
      end_picture(request.session, request.request);
      send(failure_of(std::current_exception(), request.session, request.request, order.scene.revision));
    }
    return std::nullopt;
  }

  /// A picture before it has bytes.
  struct Drawn {
    AnyImage image;
    Drawing annotations;
    Rgb background{0, 0, 0};
    FrameReady frame;
    Stopwatch since_taken;
  };

  Drawn draw_scene(Renderer& renderer, DrawOrder& order, const std::string& instead) {
    const FrameRequest& request = order.request;
    Drawn drawn;
    DrawInput input = draw_input(*order.extracted, order.scene, request.width, request.height);
    if (request.still && is_float(*request.still)) input.float_image = true;
    if (request.annotations) order.scene.annotations = *request.annotations;
    if (order.scene.annotations.any()) {
      drawn.annotations = annotate(annotation_input(*order.extracted, order.scene, input));
      if (!drawn.annotations.empty()) ask_for_annotated(input, request.lossless);
    }
    DrawResult result = renderer.draw(input);
    FrameReady& frame = drawn.frame;
    frame.session = request.session;
    frame.request = request.request;
    frame.revision = order.scene.revision;
    frame.step = order.scene.time || !order.extracted->parts.empty() ? order.extracted->time.first : order.scene.step;
    frame.lossless = request.lossless;
    frame.jpeg = request.jpeg;
    if (request.video) frame.video = VideoFacts{request.video->codec, request.video->stream, false};
    frame.width = request.width;
    frame.height = request.height;
    frame.camera = input.camera;
    frame.stages = {order.extract_ms, result.facts.order_ms, result.facts.draw_ms, result.facts.readback_ms, 0, 0};
    frame.device = result.facts.device + instead;
    frame.order = std::move(result.facts.order);
    frame.order_exact = result.facts.order_exact;
    frame.tetrahedra = result.facts.tetrahedra;
    frame.point_stride = order.extracted->point_stride;
    frame.coarse_at_hand = order.coarse_at_hand;
    frame.intervals = interval_facts(*order.extracted, order.scene, false, Task{});
    drawn.image = std::move(result.image);
    drawn.background = input.background;
    return drawn;
  }

  void send_encoded(FrameReady frame, const Stopwatch& encoding, const Stopwatch& since_taken) {
    frame.stages.encode_ms = encoding.elapsed_ms();
    frame.stages.total_ms = frame.stages.extract_ms + since_taken.elapsed_ms();
    send(std::move(frame));
  }

  /// Makes the picture's bytes and sends them. streams: null for a still.
  void encode(StreamEncoders* streams, Drawn& drawn, const DrawOrder& of) {
    FrameReady& frame = drawn.frame;
    const FrameRequest& request = of.request;
    try {
      const Doing encoding(options_.board, Stage::encoding, frame.session, frame.request);
      const WorkClass work_class = is_still(request) || request.lossless ? class_of(request) : WorkClass::encoding;
      const Work work(frame.session, work_class, {of.task.get(), true, encoding.waiting()});
      encode_bytes(streams, drawn, of);
    } catch (...) {
      send(failure_of(std::current_exception(), frame.session, frame.request, frame.revision));
    }
    end_picture(request.session, request.request);
  }

  void encode_bytes(StreamEncoders* streams, Drawn& drawn, const DrawOrder& of) {
    FrameReady& frame = drawn.frame;
    const FrameRequest& request = of.request;
    of.task->check();
    Stopwatch watch;
    if (!drawn.annotations.empty())
      drawn.image = finish_annotated(std::move(drawn.image), drawn.annotations, drawn.background, false);
    if (request.still) {
      frame.bytes = std::make_shared<const Bytes>(
          std::visit([&](const auto& image) { return encode_still(image, *request.still); }, drawn.image));
      return send_encoded(std::move(frame), watch, drawn.since_taken);
    }
    const Image& image = std::get<Image>(drawn.image);
    if (frame.video) {
      EncodeOrder order{request.jpeg_quality};
      order.bitrate_kbps = request.video->bitrate_kbps;
      order.key = request.video->key;
      if (!encode_video(*streams, image, order, frame)) return;
    } else if (request.lossless && request.band_bytes > 0) {
      auto bands = encode_png_bands(image, request.band_bytes, [&] { return overtaken(frame.session, frame.revision); });
      if (bands.empty()) throw Error(ErrorCode::cancelled, "a newer scene came first");
      frame.bands = std::make_shared<const std::vector<PngBand>>(std::move(bands));
    } else {
      frame.bytes = std::make_shared<const Bytes>(frame.jpeg ? encode_jpeg(image, request.jpeg_quality) : encode_png(image));
    }
    send_encoded(std::move(frame), watch, drawn.since_taken);
  }

  bool overtaken(SessionKey key, std::uint64_t revision) {
    std::lock_guard lock(mutex_);
    const auto it = sessions_.find(key);
    return it == sessions_.end() || !it->second.scene || it->second.scene->revision > revision;
  }

  /// False where the frame was answered with a failure.
  bool encode_video(StreamEncoders& streams, const Image& image, const EncodeOrder& order, FrameReady& frame) {
    const StreamId stream = frame.video->stream;
    if (!stream_is_open(frame.session, stream)) {
      send(RequestFailed{frame.session, frame.request, frame.revision, ErrorCode::cancelled, "the stream has been closed"});
      return false;
    }
    try {
      EncodedFrame encoded = streams.encoder(stream, frame.video->codec).encode(image, order);
      frame.bytes = std::make_shared<const Bytes>(std::move(encoded.bytes));
      frame.video->key = encoded.key;
      return true;
    } catch (...) {
      RequestFailed failed = failure_of(std::current_exception(), frame.session, frame.request, frame.revision);
      failed.encoder_failed = true;
      send(std::move(failed));
      return false;
    }
  }

  const EngineOptions options_;
  const Sink sink_;
  std::string device_;
  std::atomic<bool> cuts_intervals_{false}, draws_bricks_{false};  // the renderer of now
  static constexpr std::uint64_t kFrameBytes = 64ull << 20;   // of a picture that is not counted
  static constexpr std::uint64_t kLeastExport = 32ull << 20;  // that an export is given
  static constexpr int kStills = 4;          // sessions whose stills are drawn at once: each holds a picture

  std::mutex mutex_;  // guards the block below
  std::condition_variable changed_;
  bool stopping_ = false;
  bool in_lanes_ = false;                            // the renderer of now needs no device
  std::function<std::unique_ptr<Renderer>()> make_;  // makes another one like it
  std::string instead_;                              // what it replaces and why; empty: it is the one that was asked for
  std::map<SessionKey, SessionState> sessions_;
  SceneLedger scenes_;
  SessionKey last_drawn_ = 0;
  std::map<std::uint64_t, std::weak_ptr<Operation>> operations_;
  std::uint64_t next_operation_ = 1;
  std::map<std::string, std::pair<std::weak_ptr<const Dataset>, FirstView>> views_;  // by source

  // Destroyed from the last: every thread ends before what it uses.
  mutable std::mutex catalogue_mutex_;  // guards these two
  Catalogue catalogue_;
  std::set<std::string> grown_;  // ids of series whose new steps nobody has looked at
  DatasetStore store_;
  CoarseScenes coarse_;                      // of all sessions
  BrickMemory bricks_;                       // likewise
  BaseMeshes bases_;                         // likewise
  OrderedMemory ordered_;                    // likewise
  Task base_task_;                           // of making those that nobody waits for
  std::atomic<bool> base_in_making_{false};  // one at a time
  KnownRanges ranges_;
  KeptRenderers renderers_;
  EncoderThreads encoders_;
  Lanes openers_;                 // by session
  Lanes counters_;                // of histograms and the like, by session
  Lanes readers_{{8, 10}};        // of steps for their ranges, by dataset
  Lanes exporters_{{2, 10}};      // of mesh files, by session
  Lanes preparers_{{1, 10}};      // of base meshes
  Lanes movers_{{1, 0}};         // of scenes of every n-th point, by session
  Lanes ahead_{{1, 0}};           // of steps that will be asked for, by dataset
  Lanes extractors_;              // by session
  Lanes stills_{{kStills, 0}};    // by session
  Lanes frames_;                  // by session
  std::thread render_thread_;
};

Engine::Engine(EngineOptions options, Sink sink) : impl_(std::make_unique<Impl>(std::move(options), std::move(sink))) {}
Engine::~Engine() = default;
void Engine::post(EngineRequest request) { impl_->post(std::move(request)); }
const Catalogue& Engine::catalogue() const { return impl_->catalogue(); }
std::string Engine::device() const { return impl_->device(); }
EngineFacts Engine::facts() const {
  EngineFacts facts;
  facts.device = device();
  facts.device_is_software = is_software_device(facts.device);
  facts.process = getpid();
  facts.processes = 1;
  facts.renderer_trial = renderer_trial_report();
  return facts;
}

}  // namespace isostrata
