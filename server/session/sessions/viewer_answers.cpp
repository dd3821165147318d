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

void ViewerAnswers::probe(Viewer& viewer, ProbeRequest request, std::uint64_t seq) {
  if (const auto before = probes_.find(viewer.key); before != probes_.end()) {
    viewer.outbox->send(error_message(wire_error("cancelled", "a newer probe of this connection has taken its place"), before->second.seq));
    give_up_probe(viewer.key);
  }
  const RequestId asked = engine_.ask(std::move(request), [this, key = viewer.key, seq](const EngineEvent& event, TimePoint) {
    probes_.erase(key);
    Viewer* to = people_.find(key);
    if (!to) return;
    if (const auto* failed = std::get_if<RequestFailed>(&event)) return to->outbox->send(error_message(wire_error(*failed), seq));
    if (const auto* ready = std::get_if<ProbeReady>(&event)) {
      v1::ServerMessage answer;
      *answer.mutable_probe_result() = to_wire(*ready);
      answer.mutable_probe_result()->set_in_reply_to(seq);
      to->outbox->send(std::move(answer));
    }
  });
  probes_[viewer.key] = {asked, seq};
}

void ViewerAnswers::give_up_probe(ViewerKey viewer) {
  const auto node = probes_.extract(viewer);
  if (node.empty()) return;
  engine_.post(CancelRequest{session_, 0, node.mapped().request, true});
  engine_.forget(node.mapped().request);
}

void ViewerAnswers::leave(ViewerKey viewer) {
  give_up_probe(viewer);
  const auto node = pictures_.extract(viewer);
  if (node.empty()) return;
  for (const RequestId request : node.mapped()) {
    engine_.post(ForgetFrame{session_, request});
    engine_.forget(request);
  }
}

}  // namespace isostrata
