#include "engine/engine/encoder_threads.h"

namespace isostrata {

std::optional<EncodedFrame> StreamEncoders::encode(StreamId stream, Codec codec, const Image& image, EncodeOrder order) {
  Stream& of = streams_[stream];
  if (of.width != image.width || of.height != image.height || (of.encoder && of.encoder->codec() != codec)) {
    of = {.width = image.width, .height = image.height};
    if (order.quantizer)
      of.encoder = make_encoder(codec);
    else
      open_(stream, codec, image, order);
  }
  if (of.failure) std::rethrow_exception(of.failure);
  if (!of.encoder) return std::nullopt;
  order.key = order.key || !of.begun;
  EncodedFrame frame = of.encoder->encode(image, order);
  of.begun = true;
  return frame;
}

void StreamEncoders::opened(Opened opened) {
  const auto it = streams_.find(opened.stream);
  if (it == streams_.end() || it->second.encoder || it->second.width != opened.width || it->second.height != opened.height) return;
  it->second.encoder = std::move(opened.encoder);
  it->second.failure = std::move(opened.failure);
}

void EncoderThreads::open(SessionKey session, StreamId stream, Codec codec, const Image& first, const EncodeOrder& order) {
  const auto opened = std::make_shared<StreamEncoders::Opened>();
  opened->stream = stream;
  opened->width = first.width;
  opened->height = first.height;
  try {
    opened->encoder = make_encoder(codec);
    opened->encoder->encode(first, order);  // what it takes is taken with its first picture
  } catch (...) {
    opened->failure = std::current_exception();
  }
  post_to_known(session, [opened](StreamEncoders& streams) { streams.opened(std::move(*opened)); });
}

void EncoderThreads::post(SessionKey session, Job job) {
  {
    const std::lock_guard lock(mutex_);
    auto& streams = streams_[session];
    if (!streams)
      streams = std::make_shared<StreamEncoders>([this, session](StreamId stream, Codec codec, Image first, EncodeOrder order) {
        openers_.post(session, [this, session, stream, codec, first = std::move(first), order] { open(session, stream, codec, first, order); });
      });
  }
  post_to_known(session, std::move(job));
}

void EncoderThreads::post_to_known(SessionKey session, Job job) {
  const std::lock_guard lock(mutex_);
  const auto it = streams_.find(session);
  if (it == streams_.end()) return;
  lanes_.post(session, [streams = it->second, job = std::move(job)] { job(*streams); });
}

void EncoderThreads::close(SessionKey session, StreamId stream) {
  post_to_known(session, [stream](StreamEncoders& streams) { streams.close(stream); });
}

void EncoderThreads::close_session(SessionKey session) {
  const std::lock_guard lock(mutex_);
  const auto it = streams_.find(session);
  if (it == streams_.end()) return;
  lanes_.post(session, [streams = std::move(it->second)]() mutable { streams.reset(); });
  streams_.erase(it);
}

}  // namespace isostrata
