// Messages of a WebSocket, one after the other, to a server without sockets. The input is a list of messages, each after two
// bytes of its length, the lower one first.
#include <cstdint>
#include <cstdlib>

#include "fuzz/fake_engine.h"
#include "session/wire/wire.h"

namespace {

using namespace isostrata;

struct Listener final : Outbox {
  void send(v1::ServerMessage message) override { fuzz::expect(message.ByteSizeLong() < (8u << 20), "an answer is bounded"); }
  void send_state(v1::State, std::uint64_t) override {}
  void send_frame(v1::Frame, std::shared_ptr<const Bytes>) override {}
  void close(std::uint16_t, const std::string&) override { closed = true; }
  bool closed = false;
};

// A state that the server has is one that it takes back.
void check(const Session& session) {
  SceneState again;
  const DatasetFacts facts = fin_facts();
  if (!session.dataset()) return;
  open_in_scene(again, facts);
  const v1::State state = session.wire_state();
  const CommandOutcome outcome = apply_state(again, state, {&facts});
  fuzz::expect(!outcome.error, outcome.error ? outcome.error->message().c_str() : "");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::FakeEngine engine;
  Listener listener;
  const auto now = std::chrono::steady_clock::now();
  const ViewerKey viewer = engine.sessions.attach(listener, now);
  v1::ClientMessage hello;
  hello.set_seq(1);
  hello.mutable_hello()->set_protocol_major(1);
  hello.mutable_hello()->mutable_viewport()->set_width(64);
  hello.mutable_hello()->mutable_viewport()->set_height(48);
  if (size > 0 && data[0] % 8 != 0) {
    engine.sessions.receive(viewer, hello, now);
    engine.run();
  }
  for (std::uint64_t seq = 2; size >= 2 && !listener.closed; ++seq) {
    const std::size_t length = std::min<std::size_t>(data[0] | data[1] << 8, size - 2);
    v1::ClientMessage message;
    if (message.ParseFromArray(data + 2, static_cast<int>(length))) {
      if (message.seq() % 16 != 15) message.set_seq(seq);  // now and then the fuzzer's own
      engine.sessions.receive(viewer, message, now);
      engine.run();
    }
    data += 2 + length;
    size -= 2 + length;
  }
  engine.sessions.tick(now);
  for (const Session* session : engine.sessions.list()) check(*session);
  engine.sessions.detach(viewer, now);
  return 0;
}
