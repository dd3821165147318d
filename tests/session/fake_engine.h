// Sessions without an engine and without sockets: what is asked is kept, and the test answers.
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "session/sessions/sessions.h"
#include "support/client_messages.h"
#include "support/fin_facts.h"

namespace isostrata {

/// What one client hears.
struct FakeOutbox final : Outbox {
  void send(v1::ServerMessage message) override { messages.push_back(std::move(message)); }
  void send_state(v1::State state, std::uint64_t heeded) override {
    messages.emplace_back().mutable_state()->Swap(&state);
    messages.back().set_heeded(heeded);
  }
  void send_frame(v1::Frame frame, std::shared_ptr<const Bytes> payload) override {
    frames.push_back(std::move(frame));
    payloads.push_back(std::move(payload));
  }
  void close(std::uint16_t code, const std::string&) override { closed = code; }

  /// The newest message for which `has` holds; an empty one if there is none.
  template <class Has>
  v1::ServerMessage newest(const Has& has) const {
    for (auto it = messages.rbegin(); it != messages.rend(); ++it)
      if (has(*it)) return *it;
    return {};
  }
  v1::Welcome welcome() const {
    return newest([](const auto& m) { return m.has_welcome(); }).welcome();
  }
  v1::Error error() const {
    return newest([](const auto& m) { return m.has_error(); }).error();
  }
  v1::State state() const {
    return newest([](const auto& m) { return m.has_state(); }).state();
  }
  v1::Participants participants() const {
    return newest([](const auto& m) { return m.has_participants(); }).participants();
  }

  std::vector<v1::ServerMessage> messages;
  std::vector<v1::Frame> frames;
  std::vector<std::shared_ptr<const Bytes>> payloads;
  std::uint16_t closed = 0;
};

struct FakeClient {
  FakeOutbox outbox;
  ViewerKey key = 0;
  std::uint64_t seq = 0;
};

class SessionsOnAClock {
 public:
  explicit SessionsOnAClock(SessionsOptions options = {}) {
    options.catalogue = std::make_shared<Catalogue>(Catalogue::from_entries({{.id = "fin", .name = "fin", .source = "fin"}}));
    sessions = std::make_unique<Sessions>(std::move(options), [this](EngineRequest r) { requests.push_back(std::move(r)); }, now);
  }

  std::shared_ptr<FakeClient> connect(v1::Hello hello = {}, Sessions::Admission admission = {}) {
    auto client = clients.emplace_back(std::make_shared<FakeClient>());
    client->key = sessions->attach(client->outbox, now, std::move(admission));
    hello.set_protocol_major(1);
    v1::ClientMessage message;
    *message.mutable_hello() = std::move(hello);
    say(*client, std::move(message));
    return client;
  }
  static v1::Hello looking(int width = 64, int height = 48, bool video = false) {
    v1::Hello hello;
    hello.mutable_viewport()->set_width(static_cast<std::uint32_t>(width));
    hello.mutable_viewport()->set_height(static_cast<std::uint32_t>(height));
    hello.add_moving_formats("jpeg");
    if (video) hello.add_moving_formats("vp9-444"), hello.set_moving_format("vp9-444");
    return hello;
  }
  static v1::Hello resuming(const FakeClient& client, v1::Hello hello = looking()) {
    hello.set_resume_token(client.outbox.welcome().resume_token());
    return hello;
  }
  void say(FakeClient& client, v1::ClientMessage message) {
    message.set_seq(++client.seq);
    sessions->receive(client.key, message, now);
  }
  void leave(FakeClient& client, bool goodbye = false) { sessions->detach(client.key, now, goodbye); }

  /// All requests of one kind since the last call.
  template <class Request>
  std::vector<Request> take() {
    std::vector<Request> found;
    std::erase_if(requests, [&](const EngineRequest& r) {
      if (const auto* of_kind = std::get_if<Request>(&r)) found.push_back(*of_kind);
      return std::holds_alternative<Request>(r);
    });
    return found;
  }
  static DatasetFacts facts(const std::string& array = "Density") {
    DatasetFacts facts;
    facts.id = facts.name = "fin";
    facts.bounds.include({-1, -1, -1});
    facts.bounds.include({1, 2, 3});
    facts.arrays = {{array, "point", "float32", 1, 0, 8, 0}};
    facts.first_view = first_view_of(array, {{0, 2}, {2, 4}, {4, 8}}, facts.bounds);
    facts.times = {0, 1, 2};
    return facts;
  }
  /// Answers whoever waits for the dataset.
  void open(const std::string& array = "Density") {
    for (const OpenRequest& request : take<OpenRequest>())
      sessions->on_event(DatasetReady{request.session, request.request, facts(array)}, now);
  }
  void start(const FrameRequest& request) { sessions->on_event(FrameStarted{request.session, request.request}, now); }
  void finish(const FrameRequest& request, std::uint64_t revision, bool key = false, std::size_t bytes = 200000) {
    FrameReady ready;
    ready.session = request.session;
    ready.request = request.request;
    ready.revision = revision;
    ready.lossless = request.lossless;
    ready.jpeg = request.jpeg;
    ready.width = request.width;
    ready.height = request.height;
    if (request.video) ready.video = VideoFacts{request.video->codec, request.video->stream, key || request.video->key};
    ready.bytes = std::make_shared<const Bytes>(bytes, 7);
    sessions->on_event(ready, now);
  }
  void acknowledge(FakeClient& client) {
    now += std::chrono::milliseconds(1);
    v1::ClientMessage message;
    message.mutable_frame_ack()->set_frame_id(client.outbox.frames.back().frame_id());
    say(client, std::move(message));
  }
  static v1::ClientMessage camera(double x) { return camera_at(x); }

  TimePoint now{std::chrono::hours(1)};
  std::vector<EngineRequest> requests;
  std::vector<std::shared_ptr<FakeClient>> clients;  // an outbox must live until it is detached
  std::unique_ptr<Sessions> sessions;
};

}  // namespace isostrata
