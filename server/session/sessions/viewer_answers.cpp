#include "session/sessions/viewer_answers.h"

#include <memory>
#include <utility>

#include "session/wire/wire.h"

namespace isostrata {

void ViewerAnswers::draw(Viewer& viewer, const v1::RequestStill& wanted, std::uint64_t seq) {
  const auto refuse = [&](const char* code, const std::string& why) {
    viewer.outbox->send(error_message(wire_error(code, why), seq));
  };
  if (const auto of = pictures_.find(viewer.key); of != pictures_.end() && of->second.size() >= kMostPictures)
    return refuse("unavailable", std::to_string(kMostPictures) + " pictures of this connection are being drawn; ask again later");
  const bool as_shown = wanted.width() == 0 && wanted.height() == 0;
  const int width = as_shown ? viewer.frames.width() : static_cast<int>(wanted.width());
  const int height = as_shown ? viewer.frames.height() : static_cast<int>(wanted.height());
  if (width < 1)
    return refuse("invalid_argument", "there is no viewport whose size the picture could have; say width and height");
  FrameRequest request{session_, 0, width, height, true, false};
  request.still = StillFormat::png;
  request.annotations = annotations_of(wanted.annotations());
  request.transparent = wanted.transparent();
  // The listener learns its own number from the shared slot: it is called only later, from the io thread's loop.
  auto number = std::make_shared<RequestId>(0);
  *number = engine_.ask(std::move(request), [this, key = viewer.key, seq, number](const EngineEvent& event, TimePoint) { drawn(key, *number, seq, event); });
  pictures_[viewer.key].insert(*number);
}

void ViewerAnswers::drawn(ViewerKey key, RequestId request, std::uint64_t seq, const EngineEvent& event) {
  if (std::holds_alternative<FrameStarted>(event)) return;
  Viewer* to = people_.find(key);
  if (!to) return;
  pictures_[key].erase(request);
  if (const auto* failed = std::get_if<RequestFailed>(&event)) return to->outbox->send(error_message(wire_error(*failed), seq));
  if (const auto* ready = std::get_if<FrameReady>(&event)) {
    v1::Frame frame = to_wire(*ready);
    frame.set_in_reply_to(seq);
    to->outbox->send_frame(std::move(frame), ready->bytes);
  }
}

void ViewerAnswers::count(Viewer& viewer, HistogramRequest request, std::uint64_t seq) {
  if (histograms_ >= kMostHistograms)
    return viewer.outbox->send(error_message(
        wire_error("unavailable", std::to_string(kMostHistograms) + " histograms are being counted; ask again later"), seq));
  ++histograms_;
  engine_.ask(std::move(request), [this, key = viewer.key, seq](const EngineEvent& event, TimePoint) {
    --histograms_;
    Viewer* to = people_.find(key);
    if (!to) return;
    if (const auto* failed = std::get_if<RequestFailed>(&event)) return to->outbox->send(error_message(wire_error(*failed), seq));
    if (const auto* ready = std::get_if<HistogramReady>(&event)) {
      v1::ServerMessage answer;
      *answer.mutable_histogram() = to_wire(*ready);
      to->outbox->send(std::move(answer));
    }
  });
}

template <class Ready, class Request, class Answer>
void ViewerAnswers::probe(Viewer& viewer, Asked asked, Request request, std::uint64_t seq, const Answer& answer) {
  const ProbeKey key{viewer.key, asked};
  give_up_probe(key);
  const RequestId number = engine_.ask(std::move(request), [this, key, seq, answer](const EngineEvent& event, TimePoint) {
    probes_.erase(key);
    Viewer* to = people_.find(key.first);
    if (!to) return;
    if (const auto* failed = std::get_if<RequestFailed>(&event)) return to->outbox->send(error_message(wire_error(*failed), seq));
    if (const auto* ready = std::get_if<Ready>(&event)) {
      v1::ServerMessage message;
      answer(*ready, message)->set_in_reply_to(seq);
      to->outbox->send(std::move(message));
    }
  });
  probes_[key] = {number, seq};
}

void ViewerAnswers::probe(Viewer& viewer, ProbeRequest request, std::uint64_t seq) {
  probe<ProbeReady>(viewer, Asked::place, std::move(request), seq, [](const ProbeReady& ready, v1::ServerMessage& message) {
    *message.mutable_probe_result() = to_wire(ready);
    return message.mutable_probe_result();
  });
}

void ViewerAnswers::probe(Viewer& viewer, CurveRequest request, std::uint64_t seq) {
  const Asked asked = request.to ? Asked::line : Asked::steps;
  probe<CurveReady>(viewer, asked, std::move(request), seq, [](const CurveReady& ready, v1::ServerMessage& message) {
    *message.mutable_probed_curve() = to_wire(ready);
    return message.mutable_probed_curve();
  });
}

void ViewerAnswers::measure(Viewer& viewer, LayerStatisticsRequest request, std::uint64_t seq) {
  probe<LayerStatisticsReady>(viewer, Asked::statistics, std::move(request), seq, [](const LayerStatisticsReady& ready, v1::ServerMessage& message) {
    *message.mutable_layer_statistics() = to_wire(ready);
    return message.mutable_layer_statistics();
  });
}

void ViewerAnswers::give_up_steps(ViewerKey viewer) { give_up_probe({viewer, Asked::steps}); }

void ViewerAnswers::give_up_probe(ProbeKey probe) {
  const auto node = probes_.extract(probe);
  if (node.empty()) return;
  if (Viewer* of = people_.find(probe.first))
    of->outbox->send(error_message(wire_error("cancelled", "this connection has asked for another in its place"), node.mapped().seq));
  engine_.post(CancelRequest{session_, 0, node.mapped().request, true});
  engine_.forget(node.mapped().request);
}

void ViewerAnswers::leave(ViewerKey viewer) {
  for (const Asked asked : {Asked::place, Asked::line, Asked::steps, Asked::statistics}) give_up_probe({viewer, asked});
  const auto node = pictures_.extract(viewer);
  if (node.empty()) return;
  for (const RequestId request : node.mapped()) {
    engine_.post(ForgetFrame{session_, request});
    engine_.forget(request);
  }
}

}  // namespace isostrata
