#include "engine/engine/live_sessions.h"

#include <malloc.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <utility>

#include "base/kept_blocks.h"
#include "base/pulse.h"
#include "engine/messages/failure_of.h"

namespace isostrata {
namespace {

// An extraction that a newer scene has overtaken may still run this long. Shorter ones are shown, so a drag is never blind.
constexpr double kSupersededGraceMs = 250;

/// Without the lock: what was given back goes to the kernel, not to what this process keeps.
void let_go(std::vector<LiveSessions::Extracted> given_back) {
  if (given_back.empty()) return;
  given_back.clear();
  free_kept_blocks();
#ifdef __GLIBC__
  malloc_trim(0);
#endif
}

}  // namespace

LiveSessions::LiveSessions(SceneMemory memory, bool by_ranks, RunningOperations& operations, Ports ports)
    : by_ranks_(by_ranks), operations_(operations), ports_(std::move(ports)), memory_(std::move(memory)) {}

LiveSessions::Session* LiveSessions::find(SessionKey key) {
  const auto it = sessions_.find(key);
  return it == sessions_.end() ? nullptr : &it->second;
}

// ---- what viewers ask for ----

void LiveSessions::take(SceneUpdate update) {
  const std::lock_guard lock(mutex_);
  if (stopping_) return;
  Session& session = sessions_[update.session];
  session.latest.take(std::move(update.scene));
  session.pictures.cancel_older(session.latest.scene()->revision);
  advance(update.session, session);
  draw_soon(update.session, session);
}

void LiveSessions::take(const FrameRequest& request) {
  std::optional<RequestFailed> failed;
  {
    const std::lock_guard lock(mutex_);
    if (stopping_) return;
    Session* session = find(request.session);
    // What was too large beside what others had may fit by now.
    if (session && session->latest.failure() && session->latest.failure()->code == ErrorCode::too_large &&
        memory_.altogether(request.session, may_go()) > session->room)
      session->latest.forget_failure();
    if (!session || !session->latest.scene() || session->latest.scene()->dataset.empty()) {
      failed = RequestFailed{request.session, request.request, 0, ErrorCode::not_found, "no dataset is open: there is nothing to draw"};
    } else if (session->latest.failure()) {
      failed = *session->latest.failure();
      failed->request = request.request;
    } else {
      session->rests = false;
      session->pictures.push(request);
      memory_.see(request.session);
      if (!is_still(request)) session->latest.ask_for(by_ranks_ ? 0 : request.coarse);
      advance(request.session, *session);  // what was given back, or is wanted of all points now
      ports_.accepted(request);
      draw_soon(request.session, *session);
    }
  }
  if (failed) ports_.send(std::move(*failed));
}

void LiveSessions::forget(const ForgetFrame& of) {
  const std::lock_guard lock(mutex_);
  if (Session* session = find(of.session)) session->pictures.forget(of.request);
}

void LiveSessions::rest(SessionKey key) {
  std::vector<Extracted> given_back;
  {
    const std::lock_guard lock(mutex_);
    Session* session = find(key);
    if (!session || !session->pictures.empty()) return;  // somebody waits: it is told again
    session->rests = true;
    if (session->latest.running()) session->latest.running()->supersede(0);
    given_back = let_rest(key, *session);
  }
  let_go(std::move(given_back));
}

LiveSessions::Closed LiveSessions::close(SessionKey key) {
  std::array<Extracted, 2> freed_outside_the_lock;
  const std::lock_guard lock(mutex_);
  Session* session = find(key);
  if (!session) return {};
  freed_outside_the_lock = session->latest.give_back();
  session->pictures.cancel_all();
  sessions_.erase(key);
  memory_.forget(key);
  return {true, sessions_.empty()};
}

void LiveSessions::try_again(const std::set<std::string>& datasets) {
  const std::lock_guard lock(mutex_);
  for (auto& [key, session] : sessions_) {
    if (!session.latest.failure() || !datasets.contains(session.latest.scene()->dataset)) continue;
    session.latest.forget_failure();
    advance(key, session);
  }
}

LiveSessions::Extracted LiveSessions::ready_for(SessionKey key, const Scene& scene) {
  const std::lock_guard lock(mutex_);
  const Session* session = find(key);
  return session ? session->latest.ready_for(scene) : nullptr;
}

void LiveSessions::stop() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
    operations_.cancel_all();
    for (auto& [key, session] : sessions_) session.pictures.cancel_all();
  }
  changed_.notify_all();
}

/// Starts or overtakes the extraction that the newest scene needs.
void LiveSessions::advance(SessionKey key, Session& session) {
  using Next = LatestExtraction::Next;
  LatestExtraction& latest = session.latest;
  const Next next = stopping_ || session.rests ? Next::nothing : latest.next(session.pictures.all_coarse());
  if (next == Next::overtake_at_once) latest.running()->supersede(0);
  if (next == Next::overtake_after_grace) latest.running()->supersede(kSupersededGraceMs);
  if (next != Next::extract && next != Next::extract_coarse) return;
  const bool coarse = next == Next::extract_coarse;
  latest.begin(operations_.begin(key, 0), coarse);
  ports_.extract({key, latest.running(), *latest.scene(), latest.ready(), coarse, latest.level()});
}

/// Has drawn what is waiting.
void LiveSessions::draw_soon(SessionKey key, Session& session) {
  if (stopping_) return;
  if (!in_lanes_) return changed_.notify_all();
  for (const PictureKind kind : {PictureKind::frame, PictureKind::still})
    if (session.pictures.take_lane(kind)) ports_.draw_in_lane(key, kind);
}

// ---- what has been extracted ----

/// Whose extraction the job is; null if it is not wanted any more.
LiveSessions::Session* LiveSessions::session_of(const ExtractionJob& job) {
  Session* session = find(job.session);
  return session && session->latest.running() == job.operation ? session : nullptr;
}

void LiveSessions::take_first_look(const ExtractionJob& of, Extracted coarse) {
  const std::lock_guard lock(mutex_);  // what was there before is held by who extracts
  Session* session = session_of(of);
  if (!session) return;
  session->latest.take_first_look(std::move(coarse), of.scene);
  memory_.hold(of.session, session->latest.bytes());
  draw_soon(of.session, *session);
}

/// Gives the session what was extracted, or tells who waits why there is nothing, and goes on with what the newest scene needs.
void LiveSessions::take_extracted(const ExtractionJob& of, Extracted extracted, const std::exception_ptr& why_not) {
  std::vector<RequestFailed> failures;
  std::vector<Extracted> given_back;
  {
    const std::lock_guard lock(mutex_);
    memory_.end_next_scene(of.session);
    Session* session = session_of(of);
    if (!session) return;
    LatestExtraction& latest = session->latest;
    if (const RequestFailed* failure = latest.end(why_not ? std::optional(failure_of(why_not, of.session, 0)) : std::nullopt)) {
      failures.push_back(*failure);
      for (const FrameRequest& request : session->pictures.refuse_waiting()) {
        failures.push_back(*failure);
        failures.back().request = request.request;
      }
    }
    if (!why_not) {
      of.coarse ? latest.take_coarse(std::move(extracted), of.scene) : latest.take_ready(std::move(extracted), of.scene);
      memory_.hold(of.session, latest.bytes());
    }
    advance(of.session, *session);
    draw_soon(of.session, *session);
    given_back = take_back(memory_.make_way_for(of.session, may_go()));
    std::ranges::move(let_rest(of.session, *session), std::back_inserter(given_back));
  }
  let_go(std::move(given_back));
  for (RequestFailed& failed : failures) ports_.send(std::move(failed));
}

bool LiveSessions::wants_coarse(SessionKey key, const Extracted& of, std::uint64_t bytes) {
  const std::lock_guard lock(mutex_);
  const Session* session = find(key);
  return session && session->latest.ready().extracted == of && !session->latest.coarse().extracted && bytes <= memory_.free();
}

void LiveSessions::take_coarse(SessionKey key, const Extracted& of, Extracted coarse, const Scene& scene) {
  const std::lock_guard lock(mutex_);
  Session* session = find(key);
  if (!session || session->latest.ready().extracted != of) return;
  session->latest.take_coarse(std::move(coarse), scene);
  memory_.hold(key, session->latest.bytes());
}

// ---- memory ----

/// Nobody draws or extracts it. It is made again when somebody looks.
SceneMemory::MayGo LiveSessions::may_go() {
  return [this](SessionKey key) {
    const Session* session = find(key);
    return session && session->pictures.empty() && !session->latest.running();
  };
}

/// What it holds, if it rests and nothing of it is extracted any more.
std::vector<LiveSessions::Extracted> LiveSessions::let_rest(SessionKey key, Session& session) {
  if (!session.rests || !may_go()(key)) return {};
  memory_.hold(key, 0);
  return take_back({key});
}

/// What these sessions hold; the caller lets it go without the lock.
std::vector<LiveSessions::Extracted> LiveSessions::take_back(const std::vector<SessionKey>& gone) {
  std::vector<Extracted> all;
  for (const SessionKey key : gone) {
    for (Extracted& extracted : sessions_.at(key).latest.give_back()) all.push_back(std::move(extracted));
    ports_.drop_renderers(key);
  }
  return all;
}

std::uint64_t LiveSessions::room_for_scene(SessionKey key, bool altogether) {
  constexpr std::chrono::milliseconds kPatience{30'000}, kLook{20};
  SceneMemory::Room room;
  std::vector<Extracted> given_back;
  {
    std::unique_lock lock(mutex_);
    if (altogether) memory_.end_next_scene(key);  // others may have it while this one waits
    for (auto until = std::chrono::steady_clock::now() + kPatience; altogether && std::chrono::steady_clock::now() < until;) {
      const Session* session = find(key);
      const auto running = session ? session->latest.running() : nullptr;
      if (stopping_ || !running || running->task().cancelled() || memory_.leave_most(key, may_go())) break;
      changed_.wait_for(lock, kLook);
      pulse();  // waiting is not hanging
    }
    room = memory_.for_next_scene(key, altogether, may_go());
    if (Session* const session = find(key)) session->room = room.bytes;
    given_back = take_back(room.gone);
  }
  let_go(std::move(given_back));
  return room.bytes;
}

std::uint64_t LiveSessions::begin_work(SessionKey key, std::uint64_t bytes) {
  SceneMemory::Room room;
  std::vector<Extracted> given_back;
  {
    const std::lock_guard lock(mutex_);
    room = memory_.begin_work(key, bytes, may_go());
    given_back = take_back(room.gone);
  }
  let_go(std::move(given_back));
  return room.bytes;
}

bool LiveSessions::begin_work_in_free(std::uint64_t bytes) {
  const std::lock_guard lock(mutex_);
  return memory_.begin_work_in_free(bytes);
}

void LiveSessions::end_work(std::uint64_t bytes) {
  const std::lock_guard lock(mutex_);
  memory_.end_work(bytes);
  for (auto& [key, session] : sessions_) draw_soon(key, session);
}

std::uint64_t LiveSessions::quarter_of_free() {
  const std::lock_guard lock(mutex_);
  return memory_.quarter_of_free();
}

std::uint64_t LiveSessions::room_for_export(const ExportRequest& request) {
  const std::lock_guard lock(mutex_);
  const Session* session = find(request.session);
  return session && session->latest.ready_for(request.scene) ? memory_.for_work_on(request.session) : memory_.quarter_of_free();
}

// ---- drawing ----

void LiveSessions::draw_by(const RendererTraits& renderer, bool in_lanes) {
  const std::lock_guard lock(mutex_);
  in_lanes_ = in_lanes;
  for (auto& [key, session] : sessions_) {
    const auto draws = [&](const Prepared& of) { return !of.extracted || can_draw(renderer, *of.extracted, of.scene); };
    if (!draws(session.latest.ready()) || !draws(session.latest.coarse())) {
      session.latest.give_back();
      memory_.hold(key, 0);
      advance(key, session);
    }
    draw_soon(key, session);
  }
}

RenderThread::Ports::Turn LiveSessions::wait_for_turn(std::chrono::milliseconds longest, std::optional<PictureOrder>& order) {
  using Turn = RenderThread::Ports::Turn;
  const auto next = [](Session& of) { return of.pictures.next(of.latest, {}); };
  std::unique_lock lock(mutex_);
  changed_.wait_for(lock, longest, [&] { return stopping_ || (!in_lanes_ && (order = turns_.next(sessions_, next))); });
  return stopping_ ? Turn::end : order ? Turn::draw : Turn::idle;
}

std::optional<PictureOrder> LiveSessions::next_between(const FrameRequest& of) {
  const std::lock_guard lock(mutex_);
  if (stopping_) return std::nullopt;
  const Session* const own = is_still(of) ? nullptr : find(of.session);
  return turns_.next(sessions_, [&](Session& session) { return &session == own ? std::nullopt : session.pictures.next(session.latest, PictureKind::frame); });
}

std::optional<PictureOrder> LiveSessions::next_in_lane(SessionKey key, PictureKind kind) {
  std::vector<Extracted> given_back;
  std::optional<PictureOrder> order;
  {
    const std::lock_guard lock(mutex_);
    Session* session = find(key);
    if (stopping_ || !session) return std::nullopt;
    order = kind == PictureKind::still ? next_still(key, *session, given_back) : session->pictures.next(session->latest, kind);
    if (!order) session->pictures.free_lane(kind);
  }
  let_go(std::move(given_back));
  return order;
}

/// The session's next still and, if it is large, its room; nothing if that has to wait for others that work.
std::optional<PictureOrder> LiveSessions::next_still(SessionKey key, Session& session, std::vector<Extracted>& given_back) {
  const LatestExtraction::Mark before = session.latest.mark();
  auto order = session.pictures.next(session.latest, PictureKind::still);
  const std::uint64_t bytes = order ? still_bytes(order->request, order->scene) : 0;
  if (bytes == 0) return order;
  const SceneMemory::Room room = memory_.begin_work(key, bytes, may_go());
  given_back = take_back(room.gone);
  if (bytes <= room.bytes) {
    order->room = {static_cast<void*>(this), [this, bytes](void*) { end_work(bytes); }};
  } else if (memory_.any_work()) {
    session.pictures.put_back(*order);
    session.latest.undo_show(before);
    return std::nullopt;
  }
  return order;  // without room if there will be none: it is refused
}

void LiveSessions::free_lane(SessionKey key, PictureKind kind) {
  const std::lock_guard lock(mutex_);
  Session* session = find(key);
  if (!session) return;
  session->pictures.free_lane(kind);
  draw_soon(key, *session);
}

bool LiveSessions::if_there(SessionKey key, const std::function<void()>& then) {
  const std::lock_guard lock(mutex_);
  if (!find(key)) return false;
  then();
  return true;
}

bool LiveSessions::overtaken(SessionKey key, std::uint64_t revision) {
  const std::lock_guard lock(mutex_);
  const Session* session = find(key);
  return !session || !session->latest.scene() || session->latest.scene()->revision > revision;
}

void LiveSessions::ended(SessionKey key, RequestId request) {
  const std::lock_guard lock(mutex_);
  if (Session* session = find(key)) session->pictures.end(request);
}

void LiveSessions::seen(SessionKey key, bool rests) {
  const std::lock_guard lock(mutex_);
  Session* session = find(key);
  if (stopping_ || !session || !session->latest.scene()) return;
  LatestExtraction& latest = session->latest;
  if (latest.ready_for(*latest.scene()) && (latest.take_news() || rests)) ports_.prepare_motion(key, latest.ready().extracted, latest.ready().scene);
}

}  // namespace isostrata
