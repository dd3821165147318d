#include "engine/engine/engine.h"

#include <malloc.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <exception>
#include <future>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <thread>

#include "base/kept_blocks.h"
#include "base/work.h"
#include "engine/engine/jobs.h"
#include "engine/engine/kept_renderers.h"
#include "engine/engine/lanes.h"
#include "engine/engine/make_picture.h"
#include "engine/engine/open_datasets.h"
#include "engine/engine/scene_ledger.h"
#include "engine/engine/session_state.h"
#include "engine/messages/failure_of.h"
#include "engine/messages/operations.h"
#include "engine/picture/coarse_scene.h"
#include "engine/picture/extraction_plan.h"
#include "engine/picture/without_mesh.h"
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

}  // namespace

class Engine::Impl {
 public:
  Impl(EngineOptions options, Sink sink)
      : options_(std::move(options)),
        sink_(std::move(sink)),
        operations_(sink_),
        datasets_(options_.catalogue, options_.store, options_.ranks),
        coarse_(options_.least_coarse_cells),
        bases_(options_.store.max_bytes),
        ordered_(options_.store.max_bytes),
        jobs_({options_.store.max_bytes, options_.board, options_.ranks}, datasets_, operations_, memory_for_jobs(), sink_) {
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
      operations_.cancel_all();
      for (auto& [key, session] : sessions_)
        for (auto& [request, picture] : session.pictures) picture.task->cancel();
      if (preparation_.task) preparation_.task->cancel();
    }
    ahead_task_.cancel();
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

  // ---- requests ----

  template <class Question>
    requires requires(Jobs& jobs, const Question& question) { jobs.post(question); }
  void take(const Question& question) {
    jobs_.post(question);
  }

  void take(MeasureRequest& request) {
    std::shared_ptr<const ExtractedScene> ready;
    {
      const std::lock_guard lock(mutex_);
      if (const auto it = sessions_.find(request.session); it != sessions_.end()) ready = it->second.ready_for(request.scene);
    }
    jobs_.post(request, std::move(ready));
  }

  void take(CancelRequest& request) { operations_.cancel(request); }

  void take(CatalogueUpdate& update) {
    const std::set<std::string> ids = datasets_.update(std::move(update.entries));
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
    const bool coarse = session.coarse_suffices();  // a hand moves the layers, and asks for no more
    if (session.extraction) {
      const bool for_nobody = coarse && !session.extraction_is_coarse;
      if (same_extraction(session.extraction_scene, scene) && !for_nobody) return;
      const bool other_data = session.extraction_scene.dataset != scene.dataset ||
                              session.extraction_scene.array != scene.array || session.extraction_scene.step != scene.step;
      if (other_data || for_nobody)
        session.extraction->supersede(0);
      else if (!session.last_was_cut_short)
        session.extraction->supersede(kSupersededGraceMs);
      return;
    }
    if (session.ready_for(scene) || (coarse && session.coarse_for(scene))) return;
    session.extraction = operations_.begin(key, 0);
    session.extraction_scene = scene;
    session.extraction_is_coarse = coarse;
    extractors_.post(key, [this, key, operation = session.extraction, scene, before = session.ready, coarse, level = session.asks_coarse] {
      if (coarse)
        extract_coarse(key, operation, scene, before.extracted->dataset, level);
      else
        extract(key, operation, scene, before);
    });
  }

  /// What job threw; null: nothing.
  template <class Job>
  std::exception_ptr run_extraction(SessionKey key, Operation& operation, const Job& job) {
    std::exception_ptr failure;
    try {
      const Doing extracting(options_.board, Stage::extracting, key, 0, operation.id());
      operation.task().check();
      const Work work(key, WorkClass::scene, {&operation.task(), true, extracting.waiting()});
      job();
    } catch (...) {
      failure = std::current_exception();
    }
    operation.finish();
    return failure;
  }

  /// before: what is ready.
  void extract(SessionKey key, const std::shared_ptr<Operation>& operation, const Scene& scene, const Prepared& before) {
    const std::shared_ptr<const ExtractedScene>& previous = before.extracted;
    std::shared_ptr<const ExtractedScene> extracted;
    const std::exception_ptr failure = run_extraction(key, *operation, [&] {
      const CatalogueEntry source = datasets_.entry(scene.dataset);
      const StepSource steps = datasets_.steps(source);
      SceneAids aids;
      aids.bricks = &bricks_;
      aids.ordered = &ordered_;
      aids.bases = &bases_;
      aids.tetrahedra = cuts_intervals_ ? TetrahedraWay::automatic : TetrahedraWay::split;
      if (draws_bricks_) aids.least_in_bricks = kLeastInBricksOfFrames;
      aids.extracts_there = extracts_there_;
      aids.max_bytes = room_for(key, false);
      const bool shows_it = is_whole(previous) && before.scene.dataset == scene.dataset && before.scene.array == scene.array;  // with other intervals, or at another step
      if (!options_.ranks && !shows_it)
        if (auto first = coarse_.extract(steps, scene, operation->task())) show_meanwhile(key, operation, scene, std::move(first));
      try {
        extracted = extract_by(options_.ranks, {source.source, source.id}, steps, scene, previous, operation->task(), aids);
      } catch (const Error& error) {
        const std::uint64_t room = error.code() == ErrorCode::too_large ? room_for(key, true) : 0;
        if (room <= aids.max_bytes) throw;
        aids.max_bytes = room;
        extracted = extract_by(options_.ranks, {source.source, source.id}, steps, scene, previous, operation->task(), aids);
      }
    });
    if (extracted) prepare_tetrahedra(key, *extracted, scene, previous.get());
    if (extracted && previous) read_ahead(*extracted, scene, before.scene);
    finish_extraction(key, operation, scene, failure, [&](SessionState& session) {
      session.ready = {extracted, scene};
      if (!session.coarse_for(scene)) session.coarse.extracted.reset();
      hold(key, session);
    });
  }

  /// Of every n-th point, from a dataset of the scene's step that is at hand.
  void extract_coarse(SessionKey key, const std::shared_ptr<Operation>& operation, const Scene& scene, const std::shared_ptr<const Dataset>& whole, int level) {
    std::shared_ptr<const ExtractedScene> extracted;
    const std::exception_ptr failure =
        run_extraction(key, *operation, [&] { extracted = coarse_.extract_for_motion(whole, scene, level, operation->task()); });
    finish_extraction(key, operation, scene, failure, [&](SessionState& session) { hold_coarse(key, session, extracted, scene); });
    if (extracted) find_error(extracted);
  }

  /// How far a coarse picture may be from that of all points, beside everything else.
  void find_error(const std::shared_ptr<const ExtractedScene>& coarse) {
    if (!coarse->coarse_error || coarse->coarse_error->get()) return;
    preparers_.post(0, [this, coarse] {
      try {
        const Doing extracting(options_.board, Stage::extracting, 0, 0);
        const Work work(0, WorkClass::background, {&ahead_task_, true, extracting.waiting()});
        coarse_.find_error(*coarse, options_.store.max_bytes, ahead_task_);
      } catch (const std::exception&) {  // the pictures do without it
      }
    });
  }

  /// Gives the session what was extracted by take(session), or tells who waits why there is nothing, and goes on with what the newest scene needs.
  template <class Take>
  void finish_extraction(SessionKey key, const std::shared_ptr<Operation>& operation, const Scene& scene, const std::exception_ptr& failure, const Take& take) {
    std::vector<EngineEvent> events;
    std::vector<std::shared_ptr<const ExtractedScene>> given_back;
    {
      std::lock_guard lock(mutex_);
      const auto it = sessions_.find(key);
      if (it == sessions_.end() || it->second.extraction != operation) return;
      SessionState& session = it->second;
      session.extraction.reset();
      session.last_was_cut_short = failure && operation->superseded();
      if (!failure) {
        take(session);
      } else if (same_extraction(scene, *session.scene) && !operation->superseded()) {  // else it was given up, and is wanted again by now
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

  /// Of a scene that rests and takes long to draw, the same of every n-th point is made in advance, for the next hand that turns it.
  void prepare_motion(SessionKey key) {
    const std::lock_guard lock(mutex_);
    const auto at = sessions_.find(key);
    if (at == sessions_.end() || !at->second.scene || at->second.coarse.extracted || !at->second.ready_for(*at->second.scene)) return;
    const std::shared_ptr<const ExtractedScene> extracted = at->second.ready.extracted;
    const Scene& scene = at->second.ready.scene;
    std::int64_t tetrahedra = 0;
    for (const IntervalSummary& of : extracted->summaries()) tetrahedra += of.tetrahedra;
    if (options_.ranks || tetrahedra < options_.least_coarse_tetrahedra || extracted->base || !can_be_coarse(*extracted, scene)) return;
    movers_.post(key, [this, key, extracted, scene] {
      const auto is_ready = [&] {
        const auto it = sessions_.find(key);
        return it != sessions_.end() && it->second.ready.extracted == extracted;
      };
      {
        const std::lock_guard lock(mutex_);
        if (!is_ready() || scene_bytes(*extracted) / 3 > max_scene_bytes() - std::min(max_scene_bytes(), scenes_.bytes())) return;
      }
      std::shared_ptr<const ExtractedScene> coarse;
      try {
        const Doing extracting(options_.board, Stage::extracting, 0, 0);
        const Work work(key, WorkClass::still, {&ahead_task_, true, extracting.waiting()});
        coarse = coarse_.extract_for_motion(extracted->dataset, scene, 1, ahead_task_);
      } catch (const std::exception& error) {  // a hand turns all points then
        return;
      }
      if (!coarse) return;
      find_error(coarse);
      const std::lock_guard lock(mutex_);
      if (!is_ready()) return;
      hold_coarse(key, sessions_.at(key), std::move(coarse), scene);
    });
  }

  /// With mutex_ held.
  void hold_coarse(SessionKey key, SessionState& session, std::shared_ptr<const ExtractedScene> coarse, const Scene& scene) {
    session.take_coarse(std::move(coarse), scene);
    hold(key, session);
  }

  /// With mutex_ held.
  void hold(SessionKey key, const SessionState& session) {
    std::uint64_t bytes = 0;
    for (const Prepared* of : {&session.ready, &session.coarse})
      if (of->extracted) bytes += scene_bytes(*of->extracted);
    scenes_.hold(key, bytes);
  }

  /// What is drawn until the extraction is done.
  void show_meanwhile(SessionKey key, const std::shared_ptr<Operation>& operation, const Scene& scene, std::shared_ptr<const ExtractedScene> coarse) {
    const std::lock_guard lock(mutex_);  // what was there before is held by who extracts
    const auto it = sessions_.find(key);
    if (it == sessions_.end() || it->second.extraction != operation) return;
    SessionState& session = it->second;
    session.ready = {std::move(coarse), scene};
    session.coarse.extracted.reset();
    hold(key, session);
    session.drawn_meanwhile.reset();
    draw_soon(key, session);
  }

  // ---- memory: datasets, then what works that are under way take, and then scenes in what is left of --max-memory ----

  /// With mutex_ held.
  std::uint64_t max_scene_bytes() const {
    const std::uint64_t most = options_.store.max_bytes,
                        other = datasets_.held_bytes() + bases_.held_bytes() + ordered_.bytes() + scenes_.in_work();
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

  /// The same of what is free as it is: nothing is given back for it.
  std::shared_ptr<void> room_that_is_free(std::uint64_t bytes) {
    const std::lock_guard lock(mutex_);
    const std::uint64_t most = max_scene_bytes(), left = most - std::min(most, scenes_.bytes());
    if (bytes > left) throw Error(ErrorCode::unavailable, "no memory is free for a small picture at the moment");
    scenes_.begin_work(bytes);
    return until_it_ends(bytes);
  }

  MemoryForJobs memory_for_jobs() {
    const auto quarter = [this] {
      const std::lock_guard lock(mutex_);
      return quarter_of_free();
    };
    return {[this](SessionKey session, std::uint64_t bytes, const std::string& what) { return room_for_work(session, bytes, what); },
            [this](std::uint64_t bytes) { return room_that_is_free(bytes); }, quarter, [this](const ExportRequest& request) { return export_bytes(request); }};
  }

  /// What an export may take: as much as the session's own scene of the same layers does, where that is known, else a quarter of what is free.
  std::uint64_t export_bytes(const ExportRequest& request) {
    const std::lock_guard lock(mutex_);
    const auto it = sessions_.find(request.session);
    if (it != sessions_.end() && it->second.ready_for(request.scene)) {
      // Its facets and values come on top, and it needs some room to be told by numbers that it has too little.
      return std::max(2 * scenes_.bytes_of(request.session), kLeastWork);
    }
    return quarter_of_free();
  }

  /// For a work of which nobody knows what it takes. With mutex_ held.
  std::uint64_t quarter_of_free() const {
    const std::uint64_t most = max_scene_bytes();
    return std::max((most - std::min(most, scenes_.bytes())) / 4, kLeastWork);
  }

  /// An order for the session's next still and, where it is large, its room; nothing where that has to wait for others that work. With mutex_ held.
  std::optional<PictureOrder> still_order(SessionKey key, SessionState& session, std::vector<std::shared_ptr<const ExtractedScene>>& given_back) {
    const auto drawn_meanwhile = session.drawn_meanwhile;
    const bool ready_drawn = session.ready.drawn;
    auto order = session.next_order(is_still);
    const std::uint64_t bytes = order ? still_bytes(order->request, order->scene) : 0;
    if (bytes == 0) return order;
    if (bytes <= try_work(key, bytes, given_back)) {
      order->room = until_it_ends(bytes);
    } else if (scenes_.in_work() > 0) {
      session.waiting.push_front(order->request);
      session.pictures.erase(order->request.request);
      session.drawn_meanwhile = drawn_meanwhile;
      session.ready.drawn = ready_drawn;
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
      all.push_back(std::move(session.ready.extracted));
      all.push_back(std::move(session.coarse.extracted));
      session.give_back();
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
        next >= static_cast<int>(extracted.dataset->times.size()) || !datasets_.has_room_for(scene.dataset, next))
      return;
    ahead_.post(std::hash<std::string>()(scene.dataset), [this, dataset = scene.dataset, next] {
      const Doing opening(options_.board, Stage::opening, 0, 0);
      try {
        const Work work(0, WorkClass::background, {&ahead_task_, true, opening.waiting()});
        datasets_.acquire(datasets_.entry(dataset), next, ahead_task_);
      } catch (const std::exception&) {  // who asks for it is told why
      }
    });
  }

  /// Whoever looks at layers will move their ends, and steps on one mesh will be followed by others: the grid of tetrahedra that layers are cut out of then,
  /// where they are drawn or by extraction, is made meanwhile. Before a hand has moved, only if it takes little of the memory.
  void prepare_tetrahedra(SessionKey key, const ExtractedScene& extracted, const Scene& scene, const ExtractedScene* previous) {
    constexpr std::uint64_t kLittle = 8;  // of --max-memory
    const bool same_steps = previous && previous->steps == extracted.steps;
    if (extracted.base || (same_steps && previous->request == extracted.request) || !only_tetrahedra(*extracted.dataset)) return;
    const bool played = previous && !same_steps && previous->dataset && previous->dataset->grid.storage == extracted.dataset->grid.storage;
    const bool opened = !same_steps && !played;
    if (opened && base_tetrahedra_bytes(*extracted.dataset) > options_.store.max_bytes / kLittle) return;
    const bool cut = !played && cuts_intervals_ && cuts_exactly(scene, extracted.array) && !bases_.find(extracted.dataset, extracted.array);
    const LayerRequest& request = extracted.request;
    const bool lay_out = request.terms.empty() && !request.time && !ordered_.knows(extracted.dataset->grid);
    if (cut ? same_steps && previous->request.intervals == request.intervals : !lay_out) return;
    const bool waited_for = !opened;  // what yields to all that is played would be made once that ends
    const std::shared_ptr<Task> task = begin_preparation(waited_for);
    if (!task) return;
    (waited_for ? movers_ : preparers_).post(waited_for ? key : 0, [this, key, cut, waited_for, dataset = extracted.dataset, array = extracted.array, task] {
      const Doing extracting(options_.board, Stage::extracting, 0, 0);
      try {
        const Work work(waited_for ? key : 0, waited_for ? WorkClass::scene : WorkClass::background, {task.get(), true, extracting.waiting()});
        if (cut)
          bases_.make(dataset, array, *task);
        else
          ordered_.make(dataset->grid, *task);
      } catch (const std::exception&) {  // extraction goes on without it
      }
      const std::lock_guard lock(mutex_);
      if (preparation_.task == task) preparation_ = {};
    });
  }

  /// One at a time. A hand that moves, or who plays, waits for it, and does not wait for what was begun for later and yields to everything: that is begun
  /// anew.
  /// Null: not now.
  std::shared_ptr<Task> begin_preparation(bool waited_for) {
    const std::lock_guard lock(mutex_);
    if (stopping_ || (preparation_.task && (preparation_.waited_for || !waited_for))) return nullptr;
    if (preparation_.task) preparation_.task->cancel();
    preparation_ = {std::make_shared<Task>(), waited_for};
    return preparation_.task;
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
        if (!is_still(request)) it->second.asks_coarse = options_.ranks ? 0 : request.coarse;
        advance(request.session, it->second);  // what was given back, or is wanted of all points now
        if (request.video) it->second.streams.insert(request.video->stream);
        draw_soon(request.session, it->second);
      }
    }
    if (failed) send(std::move(*failed));
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
    operations_.cancel_session(session);
    const auto it = sessions_.find(session);
    if (it == sessions_.end()) return false;
    freed_outside_the_lock = std::move(it->second.ready.extracted);
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
      std::optional<PictureOrder> order;
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
    extracts_there_ = renderer.extracts();
    in_lanes_ = needs_no_device(renderer);
    for (auto& [key, session] : sessions_) {
      const ExtractedScene* ready = session.ready.extracted.get();
      if (ready && ((!cuts_intervals_ && ready->base) || (!(draws_bricks_ && draws_from_bricks(session.ready.scene)) && ready->bricks))) {
        session.give_back();
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
    std::optional<PictureOrder> order;
    std::function<std::unique_ptr<Renderer>()> make;
    std::string instead;
    std::vector<std::shared_ptr<const ExtractedScene>> given_back;
    {
      const std::lock_guard lock(mutex_);
      const auto it = sessions_.find(key);
      if (stopping_ || it == sessions_.end()) return;
      order = still ? still_order(key, it->second, given_back) : it->second.next_order([](const FrameRequest& f) { return !is_still(f); });
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
  std::optional<PictureOrder> next_order() {
    if (in_lanes_) return std::nullopt;
    auto it = sessions_.upper_bound(last_drawn_);
    for (std::size_t n = sessions_.size(); n > 0; --n, ++it) {
      if (it == sessions_.end()) it = sessions_.begin();
      if (auto order = it->second.next_order([](const FrameRequest&) { return true; })) {
        last_drawn_ = it->first;
        return order;
      }
    }
    return std::nullopt;
  }

  /// Why the device failed, where it did. instead: is added to the device's name. in_lane: the thread is the session's, so that
  /// it may wait for its turn and end in the middle; a device is everybody's, so there turns are taken between pictures.
  std::optional<std::string> draw(Renderer& renderer, PictureOrder order, const std::string& instead, bool in_lane) {
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
      DrawnPicture drawn = [&] {
        const Work work(request.session, class_of(request), {in_lane ? order.task.get() : nullptr, in_lane, drawing->waiting()});
        return draw_picture(renderer, order, instead);
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
                       [this, drawn = std::make_shared<DrawnPicture>(std::move(drawn)), order](StreamEncoders& streams) mutable {
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

  /// Makes the picture's bytes and sends them. streams: null for a still.
  void encode(StreamEncoders* streams, DrawnPicture& drawn, const PictureOrder& of) {
    FrameReady& frame = drawn.frame;
    const FrameRequest& request = of.request;
    try {
      const Doing encoding(options_.board, Stage::encoding, frame.session, frame.request);
      const WorkClass work_class = is_still(request) || request.lossless ? class_of(request) : WorkClass::encoding;
      const Work work(frame.session, work_class, {of.task.get(), true, encoding.waiting()});
      encode_picture(drawn, of,
                     {streams, [&] { return overtaken(frame.session, frame.revision); }, [&] { return stream_is_open(frame.session, frame.video->stream); }});
      send(std::move(frame));
      if (request.lossless) prepare_motion(request.session);
    } catch (const EncoderFailed&) {
      RequestFailed failed = failure_of(std::current_exception(), request.session, request.request, of.scene.revision);
      failed.encoder_failed = true;
      send(std::move(failed));
    } catch (...) {
      send(failure_of(std::current_exception(), request.session, request.request, of.scene.revision));
    }
    end_picture(request.session, request.request);
  }

  bool overtaken(SessionKey key, std::uint64_t revision) {
    std::lock_guard lock(mutex_);
    const auto it = sessions_.find(key);
    return it == sessions_.end() || !it->second.scene || it->second.scene->revision > revision;
  }

  const EngineOptions options_;
  const Sink sink_;
  std::string device_;
  std::atomic<bool> cuts_intervals_{false}, draws_bricks_{false}, extracts_there_{false};  // the renderer of now
  static constexpr std::uint64_t kLeastWork = 32ull << 20;  // that an export or a measure is given
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
  struct {
    std::shared_ptr<Task> task;  // null: none
    bool waited_for = false;
  } preparation_;  // of tetrahedra

  // Destroyed from the last: every thread ends before what it uses.
  Operations operations_;
  OpenDatasets datasets_;
  CoarseScenes coarse_;                      // of all sessions
  BrickMemory bricks_;                       // likewise
  BaseMeshes bases_;                         // likewise
  OrderedMemory ordered_;                    // likewise
  Task ahead_task_;                          // of making what nobody waits for
  KeptRenderers renderers_;
  EncoderThreads encoders_;
  Jobs jobs_;
  Lanes preparers_{{1, 10}};      // of what it may need
  Lanes movers_{{1, 0}};          // of what a hand that moves needs, by session
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
