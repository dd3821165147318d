#include "engine/engine/engine.h"

#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <string>
#include <utility>
#include <variant>

#include "base/kept_blocks.h"
#include "engine/engine/draw_lanes.h"
#include "engine/engine/frame_maker.h"
#include "engine/engine/jobs.h"
#include "engine/engine/kept_renderers.h"
#include "engine/engine/lend_memory.h"
#include "engine/engine/live_sessions.h"
#include "engine/engine/open_datasets.h"
#include "engine/engine/render_thread.h"
#include "engine/engine/renderer_traits.h"
#include "engine/engine/scene_extractor.h"
#include "engine/engine/shared_meshes.h"
#include "engine/engine/work_ahead.h"
#include "engine/messages/running_operations.h"
#include "rendering/choice/native_renderer.h"

namespace isostrata {

/// Has no state of its own: makes the objects, hands each the others' functions that it needs, and gives each request to whom it is for.
class Engine::Impl {
 public:
  Impl(EngineOptions options, Sink sink)
      : options_(std::move(options)),
        operations_(sink),
        datasets_(options_.catalogue, options_.store, options_.ranks),
        shared_(options_.least_coarse_cells, max_memory()),
        sessions_({max_memory() - kept_at_most(), [this] { return datasets_.held_bytes() + shared_.held_bytes(); }}, by_ranks(), operations_,
                  ports_of_sessions(sink)),
        frames_(options_.board, ports_of_frames(sink)),
        jobs_({max_memory(), options_.board, options_.ranks}, datasets_, operations_, memory_for_jobs(sessions_, max_memory()), sink),
        ahead_({max_memory(), options_.least_coarse_tetrahedra, by_ranks(), options_.board}, datasets_, shared_, ports_of_ahead()),
        extractor_(options_.board, options_.ranks, datasets_, shared_, ahead_, ports_of_extractor()),
        lanes_(frames_, renderers_, ports_of_lanes()) {
    keep_at_most(kept_at_most());
    const RenderThread::Make asked_for = [choice = options_.renderer_choice] { return make_renderer(choice); };
    const RenderThread::Make native = [] { return make_renderer({"native", "native"}); };
    render_thread_ = std::make_unique<RenderThread>(options_.renderer ? options_.renderer : asked_for, options_.fallback_renderer ? options_.fallback_renderer : native,
                                                    options_.board, ports_of_render_thread());
    frames_.draw_on(render_thread_->device());
  }

  ~Impl() {
    sessions_.stop();
    ahead_.stop();
    render_thread_.reset();
  }

  void post(EngineRequest request) {
    std::visit([this](auto& message) { take(message); }, request);
  }

  const Catalogue& catalogue() const { return options_.catalogue; }
  const std::string& device() const { return render_thread_->device(); }

 private:
  std::uint64_t max_memory() const { return options_.store.max_bytes; }
  /// Blocks that were freed and wait to be used again: no scene may have their memory.
  std::size_t kept_at_most() const { return static_cast<std::size_t>(std::min<std::uint64_t>(max_memory() / 16, kMostKept)); }
  bool by_ranks() const { return options_.ranks != nullptr; }

  // ---- requests ----

  template <class Question>
    requires requires(Jobs& jobs, const Question& question) { jobs.post(question); }
  void take(const Question& question) {
    jobs_.post(question);
  }
  void take(MeasureRequest& request) { jobs_.post(request, sessions_.ready_for(request.session, request.scene)); }
  void take(SceneUpdate& update) { sessions_.take(std::move(update)); }
  void take(FrameRequest& request) { sessions_.take(request); }
  void take(RestScene& request) { sessions_.rest(request.session); }
  void take(ForgetFrame& request) { sessions_.forget(request); }
  void take(CancelRequest& request) { operations_.cancel(request); }
  void take(CatalogueUpdate& update) { sessions_.try_again(datasets_.update(std::move(update.entries))); }
  void take(CloseStream& request) { frames_.close_stream(request.session, request.stream); }
  void take(CloseSession& request) {
    operations_.cancel_session(request.session);
    const LiveSessions::Closed closed = sessions_.close(request.session);
    if (!closed.was_there) return;
    renderers_.drop(request.session);
    frames_.close_session(request.session);
    if (closed.was_last) free_kept_blocks();  // nobody is there who would want them soon
  }

  // ---- who tells whom ----

  LiveSessions::Ports ports_of_sessions(const Sink& sink) {
    const auto accepted = [this](const FrameRequest& request) {
      if (request.video) frames_.open_stream(request.session, request.video->stream);
    };
    return {.send = sink,
            .extract = [this](ExtractionJob job) { extractor_.post(std::move(job)); },
            .draw_in_lane = [this](SessionKey session, PictureKind kind) { lanes_.post(session, kind); },
            .drop_renderers = [this](SessionKey session) { renderers_.drop(session); },
            .accepted = accepted,
            .prepare_motion = [this](SessionKey session, const auto& extracted, const Scene& scene) {
              ahead_.prepare_motion(session, extracted, scene, extractor_.renderer().draws_bricks);
            }};
  }

  SceneExtractor::Ports ports_of_extractor() {
    return {.room_for = [this](SessionKey session, bool altogether) { return sessions_.room_for_scene(session, altogether); },
            .first_look = [this](const ExtractionJob& of, auto coarse) { sessions_.take_first_look(of, std::move(coarse)); },
            .done = [this](const ExtractionJob& of, auto extracted, const auto& why_not) { sessions_.take_extracted(of, std::move(extracted), why_not); }};
  }

  WorkAhead::Ports ports_of_ahead() {
    return {.wants_coarse = [this](SessionKey session, const auto& of, std::uint64_t bytes) { return sessions_.wants_coarse(session, of, bytes); },
            .take_coarse = [this](SessionKey session, const auto& of, auto coarse, const Scene& scene) {
              sessions_.take_coarse(session, of, std::move(coarse), scene);
            }};
  }

  FrameMaker::Ports ports_of_frames(const Sink& sink) {
    return {.send = sink,
            .lend = [this](SessionKey session, std::uint64_t bytes, const std::string& what) { return lend(sessions_, session, bytes, what, max_memory()); },
            .if_there = [this](SessionKey session, const auto& then) { return sessions_.if_there(session, then); },
            .overtaken = [this](SessionKey session, std::uint64_t revision) { return sessions_.overtaken(session, revision); },
            .ended = [this](SessionKey session, RequestId request) { sessions_.ended(session, request); },
            .seen = [this](SessionKey session, bool rests) { sessions_.seen(session, rests); }};
  }

  DrawLanes::Ports ports_of_lanes() {
    return {.next = [this](SessionKey session, PictureKind kind) { return sessions_.next_in_lane(session, kind); },
            .if_there = [this](SessionKey session, const auto& then) { return sessions_.if_there(session, then); },
            .free = [this](SessionKey session, PictureKind kind) { sessions_.free_lane(session, kind); }};
  }

  RenderThread::Ports ports_of_render_thread() {
    const auto take = [this](const Renderer& renderer, const RenderThread::Make& make, const std::string& instead) {
      const RendererTraits traits = traits_of(renderer);
      extractor_.extract_for(traits);
      lanes_.draw_by(make, instead);
      sessions_.draw_by(traits, needs_no_device(renderer));
    };
    return {.take = take,
            .wait = [this](std::chrono::milliseconds longest, auto& order) { return sessions_.wait_for_turn(longest, order); },
            .next_between = [this](const FrameRequest& of) { return sessions_.next_between(of); },
            .draw = [this](Renderer& renderer, PictureOrder order, const std::string& instead, const std::function<void()>& between) {
              return frames_.draw(renderer, std::move(order), instead, FrameMaker::On::render_thread, between);
            }};
  }

  const EngineOptions options_;
  // Destroyed from the last: every thread ends before what it uses.
  RunningOperations operations_;
  OpenDatasets datasets_;
  SharedMeshes shared_;
  LiveSessions sessions_;
  KeptRenderers renderers_;
  FrameMaker frames_;
  Jobs jobs_;
  WorkAhead ahead_;
  SceneExtractor extractor_;
  DrawLanes lanes_;
  std::unique_ptr<RenderThread> render_thread_;
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
