#include "engine/engine/encoder_threads.h"

namespace isostrata {

Encoder& StreamEncoders::encoder(StreamId stream, Codec codec) {
  auto& slot = encoders_[stream];
  if (!slot || slot->codec() != codec) slot = make_encoder(codec);
  return *slot;
}

void EncoderThreads::post(SessionKey session, Job job) {
  const std::lock_guard lock(mutex_);
  auto& streams = streams_[session];
  if (!streams) streams = std::make_shared<StreamEncoders>();
  lanes_.post(session, [streams, job = std::move(job)] { job(*streams); });
}

void EncoderThreads::close(SessionKey session, StreamId stream) {
  const std::lock_guard lock(mutex_);
  if (const auto it = streams_.find(session); it != streams_.end())
    lanes_.post(session, [streams = it->second, stream] { streams->close(stream); });
}

void EncoderThreads::close_session(SessionKey session) {
  const std::lock_guard lock(mutex_);
  const auto it = streams_.find(session);
  if (it == streams_.end()) return;
  lanes_.post(session, [streams = std::move(it->second)]() mutable { streams.reset(); });
  streams_.erase(it);
}

}  // namespace isostrata
