#include "engine/encoder_threads.h"

namespace isostrata {

Encoder& StreamEncoders::encoder(SessionKey session, StreamId stream, Codec codec) {
  auto& slot = encoders_[{session, stream}];
  if (!slot || slot->codec() != codec) slot = make_encoder(codec);
  return *slot;
}

void StreamEncoders::close_session(SessionKey session) {
  std::erase_if(encoders_, [session](const auto& entry) { return entry.first.first == session; });
}

EncoderThreads::EncoderThreads(int threads) {
  for (int i = 0; i < threads; ++i) lanes_.push_back(std::make_unique<Lane>());
}

void EncoderThreads::post(SessionKey session, Job job) {
  Lane& lane = *lanes_[session % lanes_.size()];
  lane.thread.post([&lane, job = std::move(job)] { job(lane.streams); });
}

void EncoderThreads::close(SessionKey session, StreamId stream) {
  post(session, [=](StreamEncoders& streams) { streams.close(session, stream); });
}

void EncoderThreads::close_session(SessionKey session) {
  post(session, [=](StreamEncoders& streams) { streams.close_session(session); });
}

}  // namespace isostrata
