#include "worker/request_ledger.h"

#include <algorithm>

#include "worker/message_bytes.h"

namespace isostrata {
namespace {

// Whether a worker that died over the one may be trusted with the other: they differ in more than where one looks from.
bool another_scene(const Scene& a, const Scene& b) {
  const auto looks = [](Scene scene) {
    scene.revision = 0;
    scene.camera.reset();
    scene.cycle.phase = 0;
    return to_bytes(ToWorker{EngineRequest{SceneUpdate{0, std::move(scene)}}}).body;
  };
  return looks(a) != looks(b);
}

bool is_frame(const EngineRequest& request) { return std::holds_alternative<FrameRequest>(request); }

}  // namespace

RequestId answered_request_of(const EngineRequest& request) {
  if (std::holds_alternative<CancelRequest>(request) || std::holds_alternative<ForgetFrame>(request)) return 0;
  return request_of(request);
}

RequestFailed RequestLedger::failure(SessionKey session, RequestId request, const std::string& why) const {
  const auto it = sessions_.find(session);
  const std::uint64_t revision = it != sessions_.end() && it->second.scene ? it->second.scene->revision : 0;
  return RequestFailed{session, request, revision, ErrorCode::unavailable, why};
}

RequestLedger::Outcome RequestLedger::ask(EngineRequest request) {
  Outcome outcome;
  const SessionKey key = session_of(request);
  if (const RequestId number = answered_request_of(request)) {
    const auto it = sessions_.find(key);
    if (is_frame(request) && it != sessions_.end() && !it->second.withheld.empty()) {
      outcome.event = failure(key, number, it->second.withheld);
      return outcome;
    }
    if (is_frame(request) && it != sessions_.end()) it->second.rests = false;
    requests_[number] = {request, key, ++orders_};
  } else if (const auto* update = std::get_if<SceneUpdate>(&request)) {
    Session& session = sessions_[key];
    if (!session.withheld.empty()) {
      const bool another = another_scene(*session.scene, update->scene);
      session.scene = update->scene;
      if (!another) return outcome;
      session.withheld.clear();
      session.deaths = 0;
    } else {
      session.scene = update->scene;
    }
  } else if (const auto* cancel = std::get_if<CancelRequest>(&request)) {
    CancelRequest local = *cancel;
    if (cancel->operation != 0) {
      local.operation = 0;
      if (cancel->operation >> 32 == life_) {
        if ((cancel->operation & 0xffffffff) == kWatchdog)
          outcome.give_up_worker = announced_.contains(key);
        else if (operations_.contains({key, cancel->operation}))
          local.operation = cancel->operation & 0xffffffff;
      }
    }
    if (!requests_.contains(local.request)) local.request = 0;
    if (local.operation == 0 && local.request == 0) return outcome;
    outcome.request = local;
    return outcome;
  } else if (const auto* forget = std::get_if<ForgetFrame>(&request)) {
    if (requests_.erase(forget->request) == 0) return outcome;
  } else if (std::holds_alternative<RestScene>(request)) {
    if (const auto it = sessions_.find(key); it != sessions_.end()) it->second.rests = true;
  } else if (std::holds_alternative<CloseSession>(request)) {
    sessions_.erase(key);
    announced_.erase(key);
    std::erase_if(requests_, [key](const auto& of) { return of.second.session == key; });
    std::erase_if(operations_, [key](const auto& of) { return of.first == key; });
  }
  outcome.request = std::move(request);
  return outcome;
}

std::optional<EngineEvent> RequestLedger::hear(EngineEvent event) {
  const SessionKey key = session_of(event);
  if (auto* progress = std::get_if<OperationProgress>(&event)) {
    progress->operation = wire(progress->operation);
    operations_.insert({key, progress->operation});
    return event;
  }
  if (auto* done = std::get_if<OperationDone>(&event)) {
    done->operation = wire(done->operation);
    if (operations_.erase({key, done->operation}) == 0) return std::nullopt;
    return event;
  }
  const RequestId number = request_of(event);
  if (number == 0) return event;
  const auto it = requests_.find(number);
  if (it == requests_.end()) return std::nullopt;
  if (std::holds_alternative<FrameStarted>(event)) {
    if (std::exchange(it->second.started, true)) return std::nullopt;
    return event;
  }
  if (std::holds_alternative<FrameReady>(event))
    if (const auto session = sessions_.find(key); session != sessions_.end()) session->second.deaths = 0;
  requests_.erase(it);
  return event;
}

std::vector<EngineRequest> RequestLedger::begin_life() {
  ++life_;
  std::vector<EngineRequest> all;
  for (const auto& [key, session] : sessions_) {
    if (!session.scene || !session.withheld.empty()) continue;
    all.emplace_back(SceneUpdate{key, *session.scene});
    if (session.rests) all.emplace_back(RestScene{key});
  }
  std::vector<const Open*> open;
  for (const auto& [number, of] : requests_) open.push_back(&of);
  std::sort(open.begin(), open.end(), [](const Open* a, const Open* b) { return a->order < b->order; });
  for (const Open* of : open) all.push_back(of->request);
  return all;
}

std::vector<EngineEvent> RequestLedger::end_life(const std::vector<ActivityFacts>& at, const std::string& cause,
                                                 bool may_withhold) {
  std::vector<EngineEvent> events;
  for (const auto& [session, operation] : operations_) events.emplace_back(OperationDone{session, operation, true, 0, true});
  operations_.clear();

  std::map<SessionKey, bool> blamed;  // their scenes; whether one was being drawn
  std::set<RequestId> counted;
  for (const ActivityFacts& of : at) {
    if (of.stage == Stage::idle || of.stage == Stage::starting || of.waits) continue;
    const auto it = requests_.find(of.request);
    const bool about_scene = of.request == 0 || it == requests_.end() || is_frame(it->second.request);
    if (about_scene)
      blamed[of.session] = blamed[of.session] || of.stage == Stage::drawing;
    else if (counted.insert(of.request).second && ++it->second.deaths >= kMostDeaths) {
      events.emplace_back(failure(it->second.session, of.request, cause + "; it is not tried again"));
      requests_.erase(it);
    }
  }
  // One at a time: whoever was busy by chance whenever another's scene killed a worker has died as often.
  SessionKey worst = 0;
  std::pair<int, bool> most{};
  for (const auto& [key, drawing] : blamed) {
    const auto it = sessions_.find(key);
    if (it == sessions_.end() || !it->second.scene) continue;
    const std::pair<int, bool> deaths{++it->second.deaths, drawing};
    if (deaths > most) most = deaths, worst = key;
  }
  if (most.first < kMostSceneDeaths || !may_withhold) return events;
  for (const auto& [key, drawing] : blamed)
    if (const auto it = sessions_.find(key); it != sessions_.end() && key != worst) it->second.deaths = 0;
  Session& session = sessions_[worst];
  session.withheld = cause + ", for the " + std::to_string(session.deaths) +
                     "th time in a row over this scene; it is drawn again once more of it changes than the view";
  events.emplace_back(failure(worst, 0, session.withheld));
  for (auto of = requests_.begin(); of != requests_.end();) {
    if (of->second.session == worst && is_frame(of->second.request)) {
      events.emplace_back(failure(worst, of->first, session.withheld));
      of = requests_.erase(of);
    } else {
      ++of;
    }
  }
  return events;
}

void RequestLedger::forgive() {
  for (auto& [key, session] : sessions_) session.deaths = 0;
}

std::vector<EngineEvent> RequestLedger::give_up(const std::string& cause) {
  std::vector<EngineEvent> events = unannounce();
  for (const auto& [number, of] : requests_) events.emplace_back(failure(of.session, number, cause));
  requests_.clear();
  return events;
}

std::vector<EngineEvent> RequestLedger::announce(const std::string& text, double fraction) {
  for (const auto& [number, of] : requests_) announced_.insert(of.session);
  std::vector<EngineEvent> events;
  for (const SessionKey key : announced_) events.emplace_back(OperationProgress{key, wire(kWatchdog), text, fraction});
  return events;
}

std::vector<EngineEvent> RequestLedger::unannounce() {
  std::vector<EngineEvent> events;
  for (const SessionKey key : announced_) events.emplace_back(OperationDone{key, wire(kWatchdog), false});
  announced_.clear();
  return events;
}

}  // namespace isostrata
