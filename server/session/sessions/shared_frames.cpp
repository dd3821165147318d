#include "session/sessions/shared_frames.h"

#include <algorithm>
#include <memory>
#include <utility>
#include <vector>

#include "engine/picture/layer_request.h"
#include "session/wire/wire.h"

namespace isostrata {
namespace {

v1::FormatForecast to_wire(const FormatForecast& forecast) {
  v1::FormatForecast out;
  out.set_format(std::string(name_of(forecast.codec)));
  out.set_ms(forecast.ms);
  out.set_width(static_cast<std::uint32_t>(forecast.width));
  out.set_height(static_cast<std::uint32_t>(forecast.height));
  return out;
}

}  // namespace

void SharedFrames::come(Viewer& viewer, TimePoint now) {
  viewer.frames.set_codec(viewer.format.codec());
  viewer.frames.scene_changed(scene_.revision, ports_.drawable(), now);
}

void SharedFrames::leave(Viewer& viewer) {
  leave_ordered(viewer);
  for (const RequestId request : making_.leave_all(viewer.key)) forget(request);
  streams_.leave(viewer.key, true);
  viewer.stream = 0;
  end_streams();
}

void SharedFrames::scene_changed(TimePoint now) {
  making_.forget_kept();
  if (measured_ && measured_->request != 0 && !same_extraction(measured_->scene, scene_)) give_up_measuring();
  for (const auto& [key, viewer] : people_.viewers()) {
    viewer->frames.scene_changed(scene_.revision, ports_.drawable(), now);
    viewer->bands.clear();
    viewer->awaits_layers = false;
  }
}

void SharedFrames::draw_again(TimePoint now) {
  for (const auto& [key, viewer] : people_.viewers()) viewer->frames.scene_changed(scene_.revision, ports_.drawable(), now);
}

void SharedFrames::note_told(const Scene& before, const Scene& now) {
  if (costs_.moves_layers() || same_extraction(before, now)) return;
  costs_.note_moved_layers();
  for (const auto& [key, viewer] : people_.viewers()) viewer->format.hurry();
}

void SharedFrames::forget(RequestId request) {
  engine_.post(ForgetFrame{session_, request});
  engine_.forget(request);
}

void SharedFrames::leave_ordered(Viewer& viewer) {
  const RequestId ordered = std::exchange(viewer.ordered_request, 0);
  if (making_.leave(ordered, viewer.key)) forget(ordered);
}

// ---- asking ----

void SharedFrames::pump(TimePoint now) {
  for (const auto& [key, viewer] : people_.viewers()) pump(*viewer, now);
}

void SharedFrames::pump(Viewer& viewer, TimePoint now) {
  send_bands(viewer, now);
  if (viewer.awaits_layers && viewer.bands.empty() && viewer.frames.in_flight() == 0) tell_layers(viewer);
  if (viewer.frames.withdraw_order()) leave_ordered(viewer);
  if (viewer.stream != 0 && (!viewer.frames.visible() || viewer.frames.stalled(now))) leave_stream(viewer, now);
  use_format(viewer, now);
  viewer.frames.set_most_samples(viewer.refines ? costs_.most_samples() : 1);
  if (making_.crowded()) return;
  auto order = viewer.frames.next(now);
  if (!order && viewer.bands.empty()) order = viewer.frames.refined(now);
  if (!order) return;
  ports_.announce(now);
  const FrameRequest request = request_of(viewer, *order, now);
  if (give_kept(viewer, request, *order, now) || join(viewer, request, *order)) return;
  if (viewer.role == v1::ROLE_VIEWER) {
    ViewerBudget& budget = ports_.budget();
    if (const Duration wait = budget.wait(now); wait > Duration::zero()) {
      viewer.pays_at = now + wait;
      return viewer.frames.put_back();
    }
    budget.take(static_cast<double>(order->width) * order->height * order->samples * order->samples);
  }
  ask(viewer, request, *order);
}

FrameRequest SharedFrames::request_of(Viewer& viewer, FrameOrder& order, TimePoint now) {
  FrameRequest request{session_, 0, order.width, order.height, order.lossless, !order.lossless, order.quality};
  // A settled frame is a picture by itself, as good as pictures get that are not lossless.
  if (order.phase == FramePhase::moving && is_video(order.codec)) {
    const auto choice = streams_.choose(viewer.key, order.codec, order.width, order.height, now);
    viewer.stream = choice.stream;
    end_streams();
    if (choice.stream != 0)
      request.video = VideoOrder{order.codec, choice.stream, order.bitrate_kbps, choice.key};
    else
      order.codec = Codec::jpeg;
  }
  if (order.phase == FramePhase::moving) request.coarse = viewer.format.coarse_level(costs_.moves_layers());
  request.samples = order.samples;
  request.until_newer = order.phase != FramePhase::moving && !order.whole;
  if (order.lossless && !order.whole && viewer.takes_bands) request.band_bytes = viewer.frames.band_bytes(now);
  return request;
}

bool SharedFrames::give_kept(Viewer& viewer, const FrameRequest& wanted, const FrameOrder& order, TimePoint now) {
  const auto kept = making_.kept_for(wanted, order, scene_.revision);
  if (!kept) return false;
  viewer.frames.started(scene_.revision);
  give(viewer, kept->order, kept->ready, now);
  return true;
}

bool SharedFrames::join(Viewer& viewer, const FrameRequest& wanted, const FrameOrder& order) {
  const auto joined = making_.join(viewer.key, wanted, order, scene_.revision);
  if (!joined) return false;
  if (joined->started)
    viewer.frames.started(scene_.revision);
  else
    viewer.ordered_request = joined->request;
  return true;
}

void SharedFrames::ask(Viewer& viewer, const FrameRequest& request, const FrameOrder& order) {
  // The listener learns its own number from the shared slot: it is called only later, from the io thread's loop.
  auto number = std::make_shared<RequestId>(0);
  *number = engine_.ask(request, [this, number](const EngineEvent& event, TimePoint then) { answered(*number, event, then); });
  making_.ask(*number, request, order, scene_.revision, viewer.key);
  viewer.ordered_request = *number;
}

std::optional<TimePoint> SharedFrames::wake_at(TimePoint now) const {
  std::optional<TimePoint> earliest;
  const bool wait = making_.crowded();  // until a picture is ready
  for (const auto& [key, viewer] : people_.viewers()) {
    auto at = viewer->frames.wake_at(now);
    if (at) at = std::max(*at, viewer->pays_at);
    if (at && !wait && (!earliest || *at < *earliest)) earliest = at;
    if (viewer->bands.empty()) continue;
    if (const TimePoint next = viewer->frames.next_band_at(now); next != TimePoint::max() && (!earliest || next < *earliest))
      earliest = next;
  }
  return earliest;
}

// ---- giving ----

void SharedFrames::answered(RequestId request, const EngineEvent& event, TimePoint now) {
  if (const auto* begun = std::get_if<FrameStarted>(&event)) {
    const auto* making = making_.start(request, begun->revision);
    if (!making) return;
    for (const auto& [key, order] : making->takers)
      if (Viewer* viewer = people_.find(key)) {
        viewer->ordered_request = 0;
        viewer->frames.started(begun->revision);
      }
    return ports_.pump(now);
  }
  const auto made = making_.finish(request);
  if (!made) return;
  if (!made->started)
    for (const auto& [key, order] : made->takers)
      if (Viewer* viewer = people_.find(key)) viewer->ordered_request = 0;
  if (const auto* of = std::get_if<FrameReady>(&event))
    ready(*made, *of, now);
  else if (const auto* why = std::get_if<RequestFailed>(&event))
    failed(*made, *why, now);
  ports_.pump(now);
}

void SharedFrames::ready(const FramesInMaking::Making& made, const FrameReady& ready, TimePoint now) {
  costs_.made(made.request, made.order.phase, ready, now);
  making_.keep(made, ready, scene_.revision);
  std::vector<ViewerKey> of_stream;
  if (ready.video) of_stream = streams_.takers(ready.video->stream, ready.video->key, now);
  for (const auto& [key, order] : made.takers) {
    Viewer* viewer = people_.find(key);
    if (!viewer) continue;
    if (ready.video && std::ranges::find(of_stream, key) == of_stream.end())
      viewer->frames.failed(made.started);  // it was being drawn when the viewer left its stream
    else
      give(*viewer, order, ready, now);
  }
  // The stream's next frame is of use only to whoever has this one.
  for (const ViewerKey key : of_stream) {
    Viewer* viewer = people_.find(key);
    if (!viewer || made.takers.empty() || made.takers.contains(key)) continue;
    if (viewer->frames.visible() && viewer->frames.in_flight() < viewer->frames.window() && !viewer->frames.stalled(now))
      give(*viewer, made.takers.begin()->second, ready, now);
    else
      begin_stream(*viewer, now);
  }
}

void SharedFrames::failed(const FramesInMaking::Making& made, const RequestFailed& failed, TimePoint now) {
  for (const auto& [key, order] : made.takers) {
    Viewer* viewer = people_.find(key);
    if (!viewer) continue;
    viewer->frames.failed(made.started);
    // One that had begun failed in drawing; the others failed with their extraction, which everyone has been told of.
    if (made.started && !failed.encoder_failed && failed.code != ErrorCode::cancelled)
      viewer->outbox->send(error_message(wire_error(failed)));
  }
  if (failed.encoder_failed && made.request.video)
    for (const ViewerKey key : streams_.members(made.request.video->stream))
      if (Viewer* viewer = people_.find(key)) step_down(*viewer, now);
}

void SharedFrames::give(Viewer& viewer, FrameOrder order, const FrameReady& ready, TimePoint now) {
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
    viewer.format.sent(order, frame.frame_id(), megapixels(ready.width, ready.height));
    for (const FormatForecast& of : viewer.format.forecasts()) *frame.add_forecasts() = to_wire(of);
  }
  frame.set_input_seq(viewer.input_of(ready.revision));
  viewer.outbox->send_frame(std::move(frame), std::move(payload));
  if (order.phase == FramePhase::lossless && order.samples == 1 && ready.revision == scene_.revision) viewer.awaits_layers = true;
}

void SharedFrames::send_bands(Viewer& viewer, TimePoint now) {
  while (!viewer.bands.empty() && viewer.frames.next_band_at(now) <= now) {
    Viewer::Band& band = viewer.bands.front();
    band.frame.set_frame_id(viewer.frames.sent_band(band.payload->size(), now));
    viewer.outbox->send_frame(std::move(band.frame), std::move(band.payload));
    viewer.bands.pop_front();
  }
}

/// At rest, once the exact picture is on the screen, so that no picture waits for it; and once for as long as the layers stay what they are.
void SharedFrames::tell_layers(Viewer& viewer) {
  viewer.awaits_layers = false;
  const auto message = [this] {
    v1::ServerMessage told;
    *told.mutable_layer_facts() = *measured_->facts;
    return told;
  };
  if (measured_ && same_extraction(measured_->scene, scene_)) {
    if (measured_->facts) viewer.outbox->send(message());
    return;
  }
  measured_ = {scene_, 0, std::nullopt};
  measured_->request = engine_.ask(MeasureRequest{session_, 0, scene_}, [this, message](const EngineEvent& event, TimePoint) {
    if (measured_ && isostrata::request_of(event) == measured_->request) measured_->request = 0;
    const auto* ready = std::get_if<LayersMeasured>(&event);
    if (!ready || !measured_ || ready->revision != measured_->scene.revision) return;
    measured_->facts = to_wire(*ready);
    if (same_extraction(measured_->scene, scene_)) people_.tell(message());
  });
}

/// A hand that moves layers does not wait for what they were.
void SharedFrames::give_up_measuring() {
  engine_.forget(measured_->request);
  engine_.post(CancelRequest{session_, 0, measured_->request, true});
  measured_.reset();
}

// ---- video ----

// Whoever has missed a frame, or begins anew, gets a stream of their own, which begins with a key frame.
void SharedFrames::begin_stream(Viewer& viewer, TimePoint now) {
  streams_.missed(viewer.key, now);
  leave_stream(viewer, now);
}

void SharedFrames::leave_stream(Viewer& viewer, TimePoint now) {
  streams_.leave(viewer.key);
  viewer.stream = 0;
  end_streams();
  viewer.frames.scene_changed(scene_.revision, ports_.drawable(), now);  // the picture it did not get
}

void SharedFrames::end_streams() {
  for (const StreamId stream : streams_.take_ended()) engine_.post(CloseStream{session_, stream});
}

void SharedFrames::decoder_failed(Viewer& viewer, bool again, TimePoint now) {
  if (again)
    begin_stream(viewer, now);
  else
    step_down(viewer, now);
}

void SharedFrames::step_down(Viewer& viewer, TimePoint now) {
  viewer.format.step_down();
  if (viewer.format.chooses()) choose_format(viewer, now);
  begin_stream(viewer, now);
}

void SharedFrames::choose_format(Viewer& viewer, TimePoint now) {
  MovingFormat::Others others;
  for (const auto& [key, other] : people_.viewers()) {
    if (other == &viewer || !other->frames.visible() || other->frames.width() != viewer.frames.width() ||
        other->frames.height() != viewer.frames.height())
      continue;
    ++others.all;
    ++others.with[is_video(other->format.codec())];
  }
  if (!viewer.format.choose(viewer.frames, costs_, others, now) || viewer.stream == 0) return;
  streams_.leave(viewer.key);
  viewer.stream = 0;
  end_streams();
}

void SharedFrames::use_format(Viewer& viewer, TimePoint now) {
  if (viewer.format.due(now)) choose_format(viewer, now);
  const Codec codec = viewer.format.codec();
  const bool possible = !is_video(codec) || streams_.has_room(viewer.key, now);
  viewer.frames.set_codec(possible ? codec : Codec::jpeg, viewer.format.scale());
}

}  // namespace isostrata
