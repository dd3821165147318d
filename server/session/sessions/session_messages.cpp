// Of a session: what its viewers say, and who answers it.
#include <algorithm>
#include <utility>

#include "session/sessions/session.h"
#include "session/wire/wire.h"

namespace isostrata {

/// Refusals, to whoever asked, and for the client that may ask again.
Session::Reply Session::reply_to(const Viewer& viewer, const v1::ClientMessage& message) {
  return [this, key = viewer.key, seq = message.seq(), command = CommandNumber{viewer.client_id, message.command()}](std::optional<v1::Error> error) {
    if (!error) return;
    if (command.number != 0) commands_.note_refused(command, *error);
    // An answer that was long in coming follows its client to a newer connection, where the number means nothing.
    if (Viewer* to = people_.find(key))
      to->outbox->send(error_message(std::move(*error), seq));
    else if (Viewer* again = people_.find_client(command.client))
      again->outbox->send(error_message(std::move(*error)));
  };
}

void Session::acknowledge(Viewer& viewer, std::uint64_t seq) {
  viewer.heeded = std::max(viewer.heeded, seq);
  viewer.outbox->send_state(wire_state(), viewer.heeded);
}

void Session::receive(Viewer& viewer, const v1::ClientMessage& message, TimePoint now) {
  use_.touch(now);
  // An answer never overtakes the change that it answers.
  if (!message.has_set_camera() && !message.has_frame_ack()) announce(now);
  if (message.body_case() != v1::ClientMessage::kRequestStill &&  // a picture may be asked for again
      commands_.done_before({viewer.client_id, message.command()}, !viewer.invitation.empty()))
    return acknowledge(viewer, message.seq());
  const Reply reply = reply_to(viewer, message);
  if (const auto why = people_.forbidden(viewer, message)) return reply(wire_error("forbidden", *why));
  if (people_.answer(viewer, message, now, reply)) return pump(now);
  if (is_scene_command(message)) return command(message, &viewer, now, reply);
  switch (message.body_case()) {
    case v1::ClientMessage::kOpenDataset:
      return open(message.open_dataset(), &viewer, now, reply, message.command());
    case v1::ClientMessage::kReloadDataset:
      return reload(&viewer, now, reply);
    case v1::ClientMessage::kViewport: {
      const v1::Viewport& viewport = message.viewport();
      if (auto error = check_size(viewport.width(), viewport.height())) return reply(std::move(error));
      viewer.set_viewport(viewport, now);
      if (!viewer.bands.empty() &&
          (viewer.bands.front().frame.width() != viewport.width() || viewer.bands.front().frame.height() != viewport.height()))
        viewer.bands.clear();
      return frames_.pump(viewer, now);
    }
    case v1::ClientMessage::kInteraction:
      viewer.frames.set_interaction(message.interaction().active(), now);
      return frames_.pump(viewer, now);
    case v1::ClientMessage::kFrameAck:
      return receive_ack(viewer, message.frame_ack(), now);
    case v1::ClientMessage::kDecoderFailed: {
      const v1::DecoderFailed& failed = message.decoder_failed();
      if (failed.stream_id() == 0 || failed.stream_id() != viewer.stream) return;  // of a stream that has ended
      frames_.decoder_failed(viewer, failed.again(), now);
      return frames_.pump(viewer, now);
    }
    case v1::ClientMessage::kRequestStill:
      return receive_still(viewer, message, now, reply);
    case v1::ClientMessage::kRequestHistogram:
      return receive_histogram(viewer, message);
    case v1::ClientMessage::kProbePoint:
      return receive_probe(viewer, message);
    case v1::ClientMessage::kProbeLine:
    case v1::ClientMessage::kProbeSteps:
      return receive_curve(viewer, message);
    case v1::ClientMessage::kRequestLayerStatistics:
      return receive_layer_statistics(viewer, message);
    case v1::ClientMessage::kCancel:
      dataset_.cancel(message.cancel().operation(), now);
      engine_.post(CancelRequest{key_, message.cancel().operation(), 0});
      return acknowledge(viewer, message.seq());
    case v1::ClientMessage::kPing: {
      v1::ServerMessage pong;
      pong.mutable_pong()->set_client_time_ms(message.ping().client_time_ms());
      return viewer.outbox->send(std::move(pong));
    }
    case v1::ClientMessage::kHello:
      return reply(wire_error("invalid_argument", "hello was said already; it is the first message only"));
    default:
      ++viewer.ignored_messages;  // of a newer minor version
  }
}

void Session::receive_ack(Viewer& viewer, const v1::FrameAck& ack, TimePoint now) {
  const double decode_ms = ack.decode_ms();  // may be anything; what is too much is not believed
  const double believed = decode_ms > 0 && decode_ms < 60000 ? decode_ms : 0;
  viewer.format.decoded(ack.frame_id(), decode_ms, now);
  viewer.format.decoded(ack.decoded_frame_id(), ack.decoded_ms(), now);
  viewer.frames.acknowledged(ack.frame_id(), now,
                             std::chrono::duration_cast<Duration>(std::chrono::duration<double, std::milli>(believed)));
  frames_.pump(viewer, now);
}

void Session::receive_still(Viewer& viewer, const v1::ClientMessage& message, TimePoint now, const Reply& reply) {
  if (waking())
    return after_waking([this, key = viewer.key, message](TimePoint then) {
      if (Viewer* to = people_.find(key)) receive(*to, message, then);
    });
  const v1::RequestStill& still = message.request_still();
  if (state_.scene.dataset.empty()) return reply(wire_error("not_found", "no dataset is open; open one first"));
  if (still.width() != 0 || still.height() != 0)
    if (auto error = check_size(still.width(), still.height())) return reply(std::move(error));
  if (auto error = viewer.refuse_still(still, now)) return reply(std::move(error));
  use_.look(now);
  if (still.has_annotations()) return answers_.draw(viewer, still, message.seq());
  viewer.frames.request_still(static_cast<int>(still.width()), static_cast<int>(still.height()));
  frames_.pump(viewer, now);
}

void Session::receive_histogram(Viewer& viewer, const v1::ClientMessage& message) {
  const std::uint64_t seq = message.seq();
  const v1::RequestHistogram& wanted = message.request_histogram();
  if (dataset_.opening()) {
    // It means the dataset that the viewer has asked for.
    if (queue_.full()) return viewer.outbox->send(error_message(wire_error("unavailable", "too many commands wait for the dataset"), seq));
    return queue_.add([this, key = viewer.key, message](TimePoint) {
      if (Viewer* to = people_.find(key)) receive_histogram(*to, message);
    });
  }
  if (auto error = check_histogram(wanted, context())) return viewer.outbox->send(error_message(std::move(*error), seq));
  const Scene& scene = state_.scene;
  const ArrayFacts& array = *dataset()->find_array(wanted.array());
  HistogramRequest request{key_, 0, scene.dataset, scene.step, array.name, static_cast<int>(wanted.bins()), {}};
  if (scene.array == array.name) request.values = scene.values;
  request.least = array.range(request.values);
  answers_.count(viewer, std::move(request), seq);
}

void Session::receive_probe(Viewer& viewer, const v1::ClientMessage& message) {
  const std::uint64_t seq = message.seq();
  const v1::ProbePoint& wanted = message.probe_point();
  const auto refuse = [&](v1::Error error) { viewer.outbox->send(error_message(std::move(error), seq)); };
  if (auto error = check_probe(wanted)) return refuse(std::move(*error));
  if (dataset_.opening()) {
    if (queue_.full()) return refuse(wire_error("unavailable", "too many commands wait for the dataset"));
    return queue_.add([this, key = viewer.key, message](TimePoint) {
      if (Viewer* to = people_.find(key)) receive_probe(*to, message);
    });
  }
  const bool as_shown = wanted.width() == 0;
  const int width = as_shown ? viewer.frames.width() : static_cast<int>(wanted.width());
  const int height = as_shown ? viewer.frames.height() : static_cast<int>(wanted.height());
  if (!drawable()) return refuse(wire_error("not_found", "no dataset is open; open one first"));
  if (width < 1 || height < 1) return refuse(wire_error("invalid_argument", "there is no viewport in which the place could lie; say width and height", "width"));
  answers_.probe(viewer, {key_, 0, drawn(), wanted.x(), wanted.y(), width, height}, seq);
}

void Session::receive_curve(Viewer& viewer, const v1::ClientMessage& message) {
  const std::uint64_t seq = message.seq();
  const bool line = message.has_probe_line();
  const auto refuse = [&](v1::Error error) { viewer.outbox->send(error_message(std::move(error), seq)); };
  if (!line && !message.probe_steps().has_at()) return answers_.give_up_steps(viewer.key);
  if (dataset_.opening()) {
    if (queue_.full()) return refuse(wire_error("unavailable", "too many commands wait for the dataset"));
    return queue_.add([this, key = viewer.key, message](TimePoint) {
      if (Viewer* to = people_.find(key)) receive_curve(*to, message);
    });
  }
  if (!drawable()) return refuse(wire_error("not_found", "no dataset is open; open one first"));
  if (auto error = line ? check_line(message.probe_line(), context()) : check_steps(message.probe_steps(), context())) return refuse(std::move(*error));
  CurveRequest request{key_, 0, drawn(), line ? message.probe_line().array() : message.probe_steps().array(), {}, {}};
  request.from = vector_of(line ? message.probe_line().from() : message.probe_steps().at());
  if (line) request.to = vector_of(message.probe_line().to());
  answers_.probe(viewer, std::move(request), seq);
}

void Session::receive_layer_statistics(Viewer& viewer, const v1::ClientMessage& message) {
  const std::uint64_t seq = message.seq();
  const v1::RequestLayerStatistics& wanted = message.request_layer_statistics();
  const auto refuse = [&](v1::Error error) { viewer.outbox->send(error_message(std::move(error), seq)); };
  if (dataset_.opening() || !drawable()) return refuse(wire_error("unavailable", "no dataset is open, or another one is being opened"));
  if (auto error = check_layer(wanted.interval(), wanted.array(), state_.scene, context())) return refuse(std::move(*error));
  answers_.measure(viewer, {key_, 0, drawn(), wanted.interval(), wanted.array()}, seq);
}

}  // namespace isostrata
