#include "engine/engine/frame_maker.h"

#include <utility>

#include "base/work.h"
#include "engine/engine/sliced_renderer.h"
#include "engine/messages/failure_of.h"

namespace isostrata {

void FrameMaker::draw_on(const std::string& device) { software_ = is_software_device(device); }

// A drawing that runs in loops of ours has a pulse. One that a device does for us has none, so it gets time by its size; between slices it is looked at anew.
std::uint32_t FrameMaker::patience_for(const FrameRequest& request) const {
  const std::int64_t pixels = std::int64_t{request.width} * request.height;
  return static_cast<std::uint32_t>(1 + pixels / (1 << 22)) * (software_ ? 6 : 1);
}

void FrameMaker::fail(const PictureOrder& order, const std::exception_ptr& why) {
  ports_.ended(order.request.session, order.request.request);
  ports_.send(failure_of(why, order.request.session, order.request.request, order.scene.revision));
}

std::optional<std::string> FrameMaker::draw(Renderer& renderer, PictureOrder order, const std::string& instead, On thread,
                                            const std::function<void()>& between) {
  const FrameRequest& request = order.request;
  const bool in_lane = thread == On::lane;
  // On the board before it is said: whoever hears of it and looks finds it there.
  std::optional<Doing> drawing;
  const auto begin = [&] {
    if (in_lane)
      drawing.emplace(board_, Stage::drawing, request.session, request.request, 0, patience_for(request));
    else
      drawing.emplace(Doing::OnRenderThread{}, board_, Stage::drawing, request.session, request.request, patience_for(request));
  };
  begin();
  SlicedRenderer in_slices(renderer, class_of(request) == WorkClass::still ? kSliceSamples : kFrameSliceSamples, [&] {
    order.task->check();
    drawing.reset();
    between();
    begin();
    order.task->check();
  });
  ports_.send(FrameStarted{request.session, request.request, order.scene.revision});
  try {
    if (const std::uint64_t bytes = (is_still(request) || is_of_film(request)) && !order.room ? still_bytes(request, order.scene) : 0)
      order.room = ports_.lend(request.session, bytes, "a picture of " + std::to_string(request.width) + "x" + std::to_string(request.height));
    DrawnPicture drawn = [&] {
      const Work work(request.session, class_of(request), {in_lane ? order.task.get() : nullptr, in_lane, drawing->waiting()});
      return draw_picture(between ? in_slices : renderer, order, instead);
    }();
    drawing.reset();
    order.extracted.reset();
    if (in_lane && is_still(request))
      encode(nullptr, drawn, order);
    else
      hand_to_encoder(std::move(drawn), order);
  } catch (const Error& error) {
    fail(order, std::current_exception());
    if (error.code() == ErrorCode::unavailable) return error.what();
  } catch (...) {
    fail(order, std::current_exception());
  }
  return std::nullopt;
}

void FrameMaker::hand_to_encoder(DrawnPicture drawn, PictureOrder& order) {
  const SessionKey session = order.request.session;
  order.room.reset();  // what waits for an encoder may be dropped while the session cannot end
  const auto picture = std::make_shared<DrawnPicture>(std::move(drawn));
  const auto post = [&] {
    encoders_.post(session, [this, picture, order](StreamEncoders& streams) { encode(&streams, *picture, order); });
  };
  if (!ports_.if_there(session, post)) throw Error(ErrorCode::cancelled, "the session has ended");
}

/// Makes the picture's bytes and sends them. streams: null for a still.
void FrameMaker::encode(StreamEncoders* streams, DrawnPicture& drawn, const PictureOrder& of) {
  FrameReady& frame = drawn.frame;
  const FrameRequest& request = of.request;
  try {
    const Doing encoding(board_, Stage::encoding, frame.session, frame.request);
    const WorkClass work_class = is_still(request) || request.lossless ? class_of(request) : WorkClass::encoding;
    const Work work(frame.session, work_class, {of.task.get(), true, encoding.waiting()});
    encode_picture(drawn, of,
                   {streams, [&] { return ports_.overtaken(frame.session, frame.revision); }, [&] { return is_open(frame.session, frame.video->stream); }});
    ports_.send(std::move(frame));
    if (!is_still(request) && !is_of_film(request)) ports_.seen(request.session, request.lossless);
  } catch (const EncoderFailed&) {
    RequestFailed failed = failure_of(std::current_exception(), request.session, request.request, of.scene.revision);
    failed.encoder_failed = true;
    ports_.send(std::move(failed));
  } catch (...) {
    ports_.send(failure_of(std::current_exception(), request.session, request.request, of.scene.revision));
  }
  ports_.ended(request.session, request.request);
}

void FrameMaker::open_stream(SessionKey session, StreamId stream) {
  const std::lock_guard lock(mutex_);
  streams_[session].insert(stream);
}

bool FrameMaker::is_open(SessionKey session, StreamId stream) {
  const std::lock_guard lock(mutex_);
  const auto it = streams_.find(session);
  return it != streams_.end() && it->second.contains(stream);
}

void FrameMaker::close_stream(SessionKey session, StreamId stream) {
  {
    const std::lock_guard lock(mutex_);
    if (const auto it = streams_.find(session); it != streams_.end()) it->second.erase(stream);
  }
  encoders_.close(session, stream);
}

void FrameMaker::close_session(SessionKey session) {
  {
    const std::lock_guard lock(mutex_);
    streams_.erase(session);
  }
  encoders_.close_session(session);
}

}  // namespace isostrata
