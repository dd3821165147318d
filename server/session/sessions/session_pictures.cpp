// Of a session: which pictures are asked for, and who gets them. Whoever looks at the same size gets the same bytes, drawn and
// encoded once, also those whose credits come back a little later than the others'.
#include <algorithm>
#include <utility>
#include <vector>

#include "engine/picture/layer_request.h"
#include "session/sessions/session.h"
#include "session/wire/wire.h"

namespace isostrata {
namespace {

constexpr int kMostMaking = 3;        // pictures: one that is drawn, one that is encoded, one that waits for that
constexpr std::size_t kMostMade = 4;  // pictures of the newest scene that are kept for whoever comes later

bool same_picture(const FrameRequest& a, const FrameRequest& b) {
  if (a.video.has_value() != b.video.has_value()) return false;
  // Whoever needs a key frame cannot do with an ordinary one; the other way round is no loss.
  if (a.video && (a.video->stream != b.video->stream || (b.video->key && !a.video->key))) return false;
  return a.width == b.width && a.height == b.height && a.lossless == b.lossless && a.jpeg == b.jpeg &&
         a.coarse == b.coarse && a.samples == b.samples && a.jpeg_quality == b.jpeg_quality && a.band_bytes == b.band_bytes && a.until_newer == b.until_newer;
}

/// Whether who ordered `wanted` can do with the picture that is made for another's order. Moving pictures that are less than the
/// viewport deserves need not be of one's own step, nor size: else many who look over ways that differ a little would have a
/// drawing each, and all would wait for all of them.
bool does_for(const FrameRequest& made, const FrameOrder& other, const FrameRequest& wanted, const FrameOrder& order) {
  if (same_picture(made, wanted)) return true;
  const bool moving =
      order.phase == FramePhase::moving && other.phase == FramePhase::moving && made.jpeg && !made.video && !wanted.video;
  return moving && order.viewport_width == other.viewport_width && order.viewport_height == other.viewport_height &&
         other.step > 0 && order.step > 0 && other.step >= order.step - 1 && other.step <= order.step + 2;
}

FrameOrder as_made(FrameOrder order, const FrameOrder& made) {
  if (order.phase == FramePhase::moving) order.step = made.step, order.codec = made.codec;
  return order;
}

}  // namespace

// Whoever has missed a frame, or begins anew, gets a stream of their own, which begins with a key frame.
void Session::begin_stream(Viewer& viewer, TimePoint now) {
  streams_.missed(viewer.key, now);
  leave_stream(viewer, now);
}

void Session::leave_stream(Viewer& viewer, TimePoint now) {
  streams_.leave(viewer.key);
  viewer.stream = 0;
  end_streams();
  viewer.frames.scene_changed(state_.scene.revision, drawable(), now);  // the picture it did not get
}

void Session::end_streams() {
  for (const StreamId stream : streams_.take_ended()) engine_.post(CloseStream{key_, stream});
}

void Session::step_down(Viewer& viewer, TimePoint now) {
  if (viewer.ladder.size() > 1) viewer.ladder.erase(viewer.ladder.begin());
  if (viewer.chooses) choose_codec(viewer, now);
  begin_stream(viewer, now);
}

void Session::send_bands(Viewer& viewer, TimePoint now) {
  while (!viewer.bands.empty() && viewer.frames.next_band_at(now) <= now) {
    Viewer::Band& band = viewer.bands.front();
    band.frame.set_frame_id(viewer.frames.sent_band(band.payload->size(), now));
    viewer.outbox->send_frame(std::move(band.frame), std::move(band.payload));
    viewer.bands.pop_front();
  }
}

void Session::leave_picture(Viewer& viewer) {
  const auto it = pictures_.find(std::exchange(viewer.ordered_request, 0));
  if (it == pictures_.end()) return;
  it->second.takers.erase(viewer.key);
  if (!it->second.takers.empty()) return;
  engine_.post(ForgetFrame{key_, it->first});
  engine_.forget(it->first);
  pictures_.erase(it);
}

// What would be drawn now would only wait for the encoder, and be older when it is sent than what is drawn later.
bool Session::crowded() const {
  return std::count_if(pictures_.begin(), pictures_.end(), [](const auto& p) { return p.second.started; }) >= kMostMaking;
}

void Session::pump(Viewer& viewer, TimePoint now) {
  send_bands(viewer, now);
  if (viewer.frames.withdraw_order()) leave_picture(viewer);
  if (viewer.stream != 0 && (!viewer.frames.visible() || viewer.frames.stalled(now))) leave_stream(viewer, now);
  use_codec(viewer, now);
  viewer.frames.set_most_samples(most_samples(viewer));
  if (crowded()) return;
  auto order = viewer.frames.next(now);
  if (!order && viewer.bands.empty()) order = viewer.frames.refined(now);
  if (!order) return;
  announce(now);
  FrameRequest request{key_, 0, order->width, order->height, order->lossless, !order->lossless, order->quality};
  // A settled frame is a picture by itself, as good as pictures get that are not lossless.
  if (order->phase == FramePhase::moving && is_video(order->codec)) {
    const auto choice = streams_.choose(viewer.key, order->codec, order->width, order->height, now);
    viewer.stream = choice.stream;
    end_streams();
    if (choice.stream != 0)
      request.video = VideoOrder{order->codec, choice.stream, order->bitrate_kbps, choice.key};
    else
      order->codec = Codec::jpeg;
  }
  if (order->phase == FramePhase::moving) request.coarse = coarse_level(viewer);
  request.samples = order->samples;
  request.until_newer = order->phase != FramePhase::moving && !order->whole;
  if (order->lossless && !order->whole && viewer.takes_bands) request.band_bytes = viewer.frames.band_bytes(now);
  for (const Made& made : made_)
    if (made.ready.revision == state_.scene.revision && does_for(made.request, made.order, request, *order)) {
      viewer.frames.started();
      return give(viewer, as_made(*order, made.order), made.ready, now);
    }
  // One that is not being drawn yet will show the newest scene, and so will one that was asked for after the newest change.
  for (auto& [id, picture] : pictures_) {
    if ((picture.started && picture.revision != state_.scene.revision) ||
        !does_for(picture.request, picture.order, request, *order) || picture.takers.contains(viewer.key))
      continue;
    picture.takers[viewer.key] = as_made(*order, picture.order);
    if (picture.started)
      viewer.frames.started();
    else
      viewer.ordered_request = id;
    return;
  }
  if (viewer.role == v1::ROLE_VIEWER) {
    ViewerBudget& budget = engine_.viewer_budget();
    if (const Duration wait = budget.wait(now); wait > Duration::zero()) {
      viewer.pays_at = now + wait;
      return viewer.frames.put_back();
    }
    budget.take(static_cast<double>(order->width) * order->height * order->samples * order->samples);
  }
  // The listener learns its own number from the shared slot: it is called only later, from the io thread's loop.
  auto number = std::make_shared<RequestId>(0);
  *number =
      engine_.ask(request, [this, number](const EngineEvent& event, TimePoint then) { on_picture_event(*number, event, then); });
  pictures_[*number] = {request, *order, state_.scene.revision, false, {{viewer.key, *order}}};
  viewer.ordered_request = *number;
}

void Session::give(Viewer& viewer, FrameOrder order, const FrameReady& ready, TimePoint now) {
  v1::Frame frame = to_wire(ready);
  std::shared_ptr<const Bytes> payload = ready.bytes;
  viewer.bands.clear();
  if (ready.bands) {
    v1::Frame next = frame;
    next.clear_facts();
    for (std::size_t i = 0; i < ready.bands->size(); ++i) {
      const PngBand& band = (*ready.bands)[i];
      const std::shared_ptr<const Bytes> bytes(ready.bands, &band.bytes);  // all viewers' pieces are these
      v1::Frame& piece = i == 0 ? frame : viewer.bands.emplace_back(Viewer::Band{next, bytes}).frame;
      if (i == 0) payload = bytes;
      piece.mutable_band()->set_first_row(static_cast<std::uint32_t>(band.first_row));
      piece.mutable_band()->set_rows(static_cast<std::uint32_t>(band.rows));
      piece.mutable_band()->set_index(static_cast<std::uint32_t>(i));
      piece.mutable_band()->set_count(static_cast<std::uint32_t>(ready.bands->size()));
      piece.set_input_seq(viewer.input_of(ready.revision));
    }
  }
  if (order.phase == FramePhase::settled) frame.set_phase(v1::FRAME_PHASE_SETTLED);
  order.key = is_video(order.codec) && (!ready.video || ready.video->key);  // a picture in place of the first frame stands by itself, too
  frame.set_frame_id(viewer.frames.sent(order, ready.revision, payload->size(), now));
  if (order.phase == FramePhase::moving) {
    note_sent(viewer, order, ready, frame.frame_id());
    for (const v1::FormatForecast& of : viewer.forecasts) *frame.add_forecasts() = of;
  }
  frame.set_input_seq(viewer.input_of(ready.revision));
  viewer.outbox->send_frame(std::move(frame), std::move(payload));
  if (order.phase == FramePhase::lossless && order.samples == 1 && ready.revision == state_.scene.revision) tell_layers(viewer);
}

/// At rest, so that no picture waits for it, and once for as long as the layers stay what they are.
void Session::tell_layers(Viewer& viewer) {
  if (measured_ && same_extraction(measured_->scene, state_.scene)) {
    if (!measured_->facts) return;
    v1::ServerMessage message;
    *message.mutable_layer_facts() = *measured_->facts;
    return viewer.outbox->send(std::move(message));
  }
  measured_ = {state_.scene, std::nullopt};
  engine_.ask(MeasureRequest{key_, 0, state_.scene}, [this](const EngineEvent& event, TimePoint) {
    const auto* ready = std::get_if<LayersMeasured>(&event);
    if (!ready || !measured_ || ready->revision != measured_->scene.revision) return;
    measured_->facts = to_wire(*ready);
    if (!same_extraction(measured_->scene, state_.scene)) return;
    v1::ServerMessage message;
    *message.mutable_layer_facts() = *measured_->facts;
    broadcast(message);
  });
}

void Session::on_picture_event(RequestId request, const EngineEvent& event, TimePoint now) {
  const auto it = pictures_.find(request);
  if (it == pictures_.end()) return;
  const auto each_taker = [&](const Picture& picture, const auto& act) {
    for (const auto& [key, order] : picture.takers)
      if (Viewer* viewer = living(key)) act(*viewer, order);
  };
  if (std::holds_alternative<FrameStarted>(event)) {
    it->second.started = true;
    each_taker(it->second, [](Viewer& viewer, const FrameOrder&) {
      viewer.ordered_request = 0;
      viewer.frames.started();
    });
    return pump(now);
  }
  const Picture picture = std::move(it->second);
  pictures_.erase(it);
  if (!picture.started) each_taker(picture, [](Viewer& viewer, const FrameOrder&) { viewer.ordered_request = 0; });
  if (const auto* ready = std::get_if<FrameReady>(&event)) {
    note_made(picture, *ready, now);
    if (!ready->video && !picture.request.video && ready->revision == state_.scene.revision) {
      made_.push_front({picture.request, picture.order, *ready});
      if (made_.size() > kMostMade) made_.pop_back();
    }
    std::vector<ViewerKey> of_stream;
    if (ready->video) of_stream = streams_.takers(ready->video->stream, ready->video->key, now);
    const auto in_stream = [&](ViewerKey key) { return std::find(of_stream.begin(), of_stream.end(), key) != of_stream.end(); };
    each_taker(picture, [&](Viewer& viewer, const FrameOrder& order) {
      if (ready->video && !in_stream(viewer.key))
        viewer.frames.failed(picture.started);  // it was being drawn when the viewer left its stream
      else
        give(viewer, order, *ready, now);
    });
    // The stream's next frame is of use only to whoever has this one.
    for (const ViewerKey key : of_stream) {
      Viewer* viewer = living(key);
      if (!viewer || picture.takers.empty() || picture.takers.contains(key)) continue;
      if (viewer->frames.visible() && viewer->frames.in_flight() < viewer->frames.window() && !viewer->frames.stalled(now))
        give(*viewer, picture.takers.begin()->second, *ready, now);
      else
        begin_stream(*viewer, now);
    }
  } else if (const auto* failed = std::get_if<RequestFailed>(&event)) {
    each_taker(picture, [&](Viewer& viewer, const FrameOrder&) {
      viewer.frames.failed(picture.started);
      // One that had begun failed in drawing; the others failed with their extraction, which everyone has been told of.
      if (picture.started && !failed->encoder_failed && failed->code != ErrorCode::cancelled)
        viewer.outbox->send(error_message(wire_error(*failed)));
    });
    if (failed->encoder_failed && picture.request.video)
      for (const ViewerKey key : streams_.members(picture.request.video->stream))
        if (Viewer* viewer = living(key)) step_down(*viewer, now);
  }
  pump(now);
}

}  // namespace isostrata
