// Sessions without an engine: what they ask is answered at once, by facts that fit, so that a fuzzer reaches every rule behind a
// dataset that is open. Nothing is drawn.
#pragma once

#include <cstdio>
#include <cstdlib>
#include <deque>
#include <memory>
#include <stdexcept>
#include <string>

#include "session/journal/protobuf_log.h"
#include "session/sessions/sessions.h"
#include "support/fin_facts.h"

namespace isostrata::fuzz {

inline const bool quiet = (silence_protobuf(), true);  // it would write a line for every other input

/// What was asked waits until run(), as on the io thread.
class FakeEngine {
  std::deque<EngineRequest> asked_;  // before the sessions, which still ask when they end

 public:
  FakeEngine() : sessions(options(), [this](EngineRequest request) { asked_.push_back(std::move(request)); }) {}

  void run() {
    for (int i = 0; i < 100 && !asked_.empty(); ++i) {
      const EngineRequest request = std::move(asked_.front());
      asked_.pop_front();
      std::visit([this](const auto& r) { answer(r); }, request);
    }
  }

  Sessions sessions;

 private:
  static SessionsOptions options() {
    SessionsOptions options;
    options.max_sessions = 4;
    options.catalogue = std::make_shared<Catalogue>(Catalogue::from_entries({{.id = "fin", .name = "fin", .source = "fin"}, {.id = "gone", .name = "gone", .source = "gone"}}));
    return options;
  }
  void send(const EngineEvent& event) { sessions.on_event(event, std::chrono::steady_clock::now()); }
  template <class Request>
  void fail(const Request& r) {
    send(RequestFailed{r.session, r.request, 0, ErrorCode::not_found, "it is not there"});
  }

  void answer(const OpenRequest& r) {
    if (r.dataset == "fin")
      send(DatasetReady{r.session, r.request, fin_facts()});
    else
      fail(r);
  }
  void answer(const HistogramRequest& r) {
    send(HistogramReady{r.session, r.request, r.dataset, r.step, r.array, 0, 1,
                        std::vector<std::uint64_t>(static_cast<std::size_t>(r.bins))});
  }
  void answer(const StatisticsRequest& r) { send(StatisticsReady{r.session, r.request, r.dataset, r.step, r.array, {}}); }
  void answer(const ThumbnailRequest& r) {
    if (r.dataset == "fin")
      send(ThumbnailReady{r.session, r.request, std::make_shared<const Bytes>(Bytes{1, 2, 3})});
    else
      fail(r);
  }
  void answer(const MeasureRequest& r) { send(LayersMeasured{r.session, r.request, r.scene.revision, {}}); }
  void answer(const ProbeRequest& r) {
    ProbeFacts facts;
    facts.hit = r.x < 0.5;
    facts.miss = facts.hit ? "" : "nothing is there";
    send(ProbeReady{r.session, r.request, r.scene.revision, std::move(facts)});
  }
  void answer(const CurveRequest& r) {
    CurveFacts facts{r.array, {0, 1}, {2, NAN}, false, {}, 0, {}};
    if (r.to) facts.layers = {{0, 1, 1, -1}};
    send(CurveReady{r.session, r.request, r.scene.revision, std::move(facts)});
  }
  void answer(const LayerStatisticsRequest& r) { send(LayerStatisticsReady{r.session, r.request, r.scene.revision, r.interval, {}}); }
  void answer(const ExportRequest& r) {
    send(OperationProgress{r.session, 1, "writing", 0.5, r.request});
    send(ExportReady{r.session, r.request, {}});
  }
  void answer(const FrameRequest& r) {
    send(FrameStarted{r.session, r.request});
    FrameReady frame;
    frame.session = r.session;
    frame.request = r.request;
    frame.bytes = std::make_shared<const Bytes>(Bytes{1, 2, 3});
    send(std::move(frame));
  }
  void answer(const SceneUpdate& r) { send(OperationProgress{r.session, r.scene.revision, "extracting", 0.5, 0}); }
  void answer(const CancelRequest&) {}
  void answer(const ForgetFrame&) {}
  void answer(const RestScene&) {}
  void answer(const CloseSession&) {}
  void answer(const CloseStream&) {}
  void answer(const CatalogueUpdate&) {}
};

/// For the next input.
inline void end_all(Sessions& sessions) {
  std::vector<std::string> ids;
  for (const Session* session : sessions.list()) ids.push_back(session->id());
  for (const std::string& id : ids) sessions.end(id);
}

/// Tells the fuzzer's report what did not hold.
inline void expect(bool holds, const char* law) {
  if (holds) return;
  std::fprintf(stderr, "broken: %s\n", law);
  std::abort();
}

}  // namespace isostrata::fuzz
