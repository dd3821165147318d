// Which codec a viewer's moving frames come in: what it says to have decoded, the server's ladder, and the steps down.
#include <gtest/gtest.h>

#include <deque>

#include "session/sessions/sessions.h"
#include "support/client_messages.h"

namespace isostrata {
namespace {

using Names = std::vector<std::string>;

struct FakeOutbox final : Outbox {
  void send(v1::ServerMessage message) override { messages.push_back(std::move(message)); }
  void send_state(v1::State, std::uint64_t) override {}
  void send_frame(v1::Frame frame, std::shared_ptr<const Bytes> payload) override {
    frames.push_back(std::move(frame));
    payloads.push_back(std::move(payload));
  }
  void close(std::uint16_t code, const std::string&) override { closed = code; }

  std::deque<v1::ServerMessage> messages;
  std::vector<v1::Frame> frames;
  std::vector<std::shared_ptr<const Bytes>> payloads;  // of the frames
  std::uint16_t closed = 0;
};

/// Sessions before an engine that is played by the test.
class NegotiatedCodec : public ::testing::Test {
 protected:
  NegotiatedCodec() {
    SessionsOptions options;
    options.moving_codecs = {Codec::vp9_444, Codec::jpeg};
    options.catalogue = std::make_shared<Catalogue>(Catalogue::from_entries({{.id = "torus", .name = "torus", .source = "torus:8"}}));
    sessions_ = std::make_unique<Sessions>(std::move(options), [this](EngineRequest request) {
      if (const auto* close = std::get_if<CloseStream>(&request)) closed_streams_.push_back(close->stream);
      requests_.push_back(std::move(request));
    });
    viewer_ = sessions_->attach(outbox_, now_);
  }

  void receive(v1::ClientMessage message) {
    message.set_seq(++seq_);
    sessions_->receive(viewer_, message, now_);
  }
  /// Always the best of them, unless told otherwise.
  v1::Welcome hello(const Names& formats, const Names& stills = {}, bool chosen_by_time = false) {
    v1::ClientMessage message;
    message.mutable_hello()->set_protocol_major(1);
    for (const std::string& format : stills) message.mutable_hello()->add_still_formats(format);
    message.mutable_hello()->mutable_viewport()->set_width(64);
    message.mutable_hello()->mutable_viewport()->set_height(48);
    for (const std::string& format : formats) message.mutable_hello()->add_moving_formats(format);
    if (!chosen_by_time && std::find(formats.begin(), formats.end(), "vp9-444") != formats.end())
      message.mutable_hello()->set_moving_format("vp9-444");
    receive(message);
    for (const auto& answer : outbox_.messages)
      if (answer.has_welcome()) {
        answer_open();
        return answer.welcome();
      }
    return {};
  }
  void answer_open() {
    const auto open = take<OpenRequest>();
    ASSERT_TRUE(open);
    DatasetReady ready{open->session, open->request, {}};
    ready.facts.id = "torus";
    ArrayFacts array;
    array.name = "distance";
    array.upper = 1;
    ready.facts.arrays.push_back(array);
    sessions_->on_event(ready, now_);
  }
  void acknowledge() {
    v1::ClientMessage message;
    message.mutable_frame_ack()->set_frame_id(outbox_.frames.back().frame_id());
    receive(message);
  }
  void decoder_failed(StreamId stream, bool again = false) {
    v1::ClientMessage message;
    message.mutable_decoder_failed()->set_stream_id(stream);
    message.mutable_decoder_failed()->set_again(again);
    receive(message);
  }
  /// The newest request of that kind, taken from those that were posted.
  template <class Request>
  std::optional<Request> take() {
    for (; !requests_.empty(); requests_.pop_back())
      if (auto* found = std::get_if<Request>(&requests_.back())) {
        const Request request = *found;
        requests_.pop_back();
        return request;
      }
    return std::nullopt;
  }
  void start(const FrameRequest& request) { sessions_->on_event(FrameStarted{request.session, request.request}, now_); }
  void finish(const FrameRequest& request, bool key) {
    FrameReady ready;
    ready.session = request.session;
    ready.request = request.request;
    ready.revision = 1000;
    ready.lossless = request.lossless;
    ready.jpeg = request.jpeg;
    if (request.video) ready.video = VideoFacts{request.video->codec, request.video->stream, key};
    ready.width = request.width;
    ready.height = request.height;
    ready.bytes = std::make_shared<const Bytes>(200000, 7);
    sessions_->on_event(ready, now_);
  }

  FakeOutbox outbox_;
  TimePoint now_ = TimePoint{} + std::chrono::hours(1);
  std::uint64_t seq_ = 0;
  std::vector<EngineRequest> requests_;
  std::vector<StreamId> closed_streams_;
  ViewerKey viewer_ = 0;
  std::unique_ptr<Sessions> sessions_;
};

Names names(const v1::Welcome& welcome) { return {welcome.moving_formats().begin(), welcome.moving_formats().end()}; }

TEST_F(NegotiatedCodec, IsTheBestThatBothHaveAndItsFramesNameStreamKeyAndDecoder) {
  EXPECT_EQ(names(hello({"jpeg", "vp9-444", "av2"})), (Names{"vp9-444", "jpeg"}));
  const auto first = take<FrameRequest>();
  ASSERT_TRUE(first && first->video);
  EXPECT_EQ(first->video->codec, Codec::vp9_444);
  start(*first);
  finish(*first, true);
  ASSERT_EQ(outbox_.frames.size(), 1u);
  const v1::Frame& frame = outbox_.frames[0];
  EXPECT_EQ(frame.format(), "vp9-444");
  EXPECT_EQ(frame.stream_id(), first->video->stream);
  EXPECT_TRUE(frame.key());
  EXPECT_EQ(frame.decoder(), "vp09.01.30.08.03.01.13.06.00");
  EXPECT_EQ(frame.phase(), v1::FRAME_PHASE_MOVING);
}

TEST_F(NegotiatedCodec, IsJpegForWhoNamesNoVideo) {
  EXPECT_EQ(names(hello({})), Names{"jpeg"});
  const auto request = take<FrameRequest>();
  ASSERT_TRUE(request);
  EXPECT_FALSE(request->video);
  EXPECT_TRUE(request->jpeg);
}

TEST_F(NegotiatedCodec, LeavesOutWhatTheClientLacks) {
  EXPECT_EQ(names(hello({"av2", "jpeg"})), (Names{"jpeg"}));
  EXPECT_FALSE(take<FrameRequest>()->video);
}

TEST_F(NegotiatedCodec, RefusesWhoDoesNotTakeJpeg) {
  hello({"vp9-444"});
  EXPECT_NE(outbox_.closed, 0);
}

TEST_F(NegotiatedCodec, AFailedDecoderIsAStepDownAndBelowJpegThereIsNone) {
  hello({"jpeg", "vp9-444"});
  auto request = take<FrameRequest>();
  start(*request);
  finish(*request, true);
  acknowledge();
  const StreamId stream = request->video->stream;
  decoder_failed(stream);
  EXPECT_EQ(closed_streams_.back(), stream);
  request = take<FrameRequest>();
  ASSERT_TRUE(request);
  EXPECT_FALSE(request->video);
  start(*request);
  finish(*request, true);
  EXPECT_EQ(outbox_.frames.back().format(), "jpeg");
  decoder_failed(0);
  decoder_failed(77);
  EXPECT_EQ(outbox_.closed, 0);
}

TEST_F(NegotiatedCodec, ADecoderThatWasTakenAwayGetsANewStreamOfTheSameCodec) {
  hello({"jpeg", "vp9-444"});
  const auto first = take<FrameRequest>();
  start(*first);
  finish(*first, true);
  now_ += std::chrono::milliseconds(20);
  acknowledge();
  decoder_failed(first->video->stream, true);
  acknowledge();  // what could not be decoded has arrived all the same
  const auto second = take<FrameRequest>();
  ASSERT_TRUE(second && second->video);
  EXPECT_EQ(second->video->codec, Codec::vp9_444);
  EXPECT_NE(second->video->stream, first->video->stream);
  decoder_failed(first->video->stream);  // late: of a stream that has ended
  start(*second);
  finish(*second, true);
  EXPECT_EQ(outbox_.frames.back().format(), "vp9-444");
}

TEST_F(NegotiatedCodec, AFrameThatWasBeingDrawnWhenItsStreamEndedIsNotSent) {
  hello({"jpeg", "vp9-444"});
  const auto first = take<FrameRequest>();
  start(*first);
  decoder_failed(first->video->stream, true);
  finish(*first, true);
  EXPECT_TRUE(outbox_.frames.empty());
  const auto second = take<FrameRequest>();
  ASSERT_TRUE(second && second->video);
  start(*second);
  finish(*second, true);
  ASSERT_EQ(outbox_.frames.size(), 1u);
  EXPECT_EQ(outbox_.frames[0].stream_id(), second->video->stream);
}

TEST_F(NegotiatedCodec, AnEncoderThatFailsIsAStepDownToo) {
  hello({"jpeg", "vp9-444"});
  const auto first = take<FrameRequest>();
  start(*first);
  RequestFailed failed{first->session, first->request, 1, ErrorCode::unavailable, "no"};
  failed.encoder_failed = true;
  sessions_->on_event(failed, now_);
  const auto second = take<FrameRequest>();
  ASSERT_TRUE(second);
  EXPECT_FALSE(second->video);
  for (const auto& message : outbox_.messages) EXPECT_FALSE(message.has_error());
}

TEST_F(NegotiatedCodec, OneThatJoinsSharesTheStreamAndBeginsWithAKeyFrameAndTheLastToLeaveClosesIt) {
  const v1::Welcome welcome = hello({"jpeg", "vp9-444"});
  const auto first = take<FrameRequest>();
  FakeOutbox other;
  const ViewerKey joined = sessions_->attach(other, now_);
  v1::ClientMessage message;
  message.set_seq(1);
  message.mutable_hello()->set_protocol_major(1);
  message.mutable_hello()->set_resume_token(welcome.resume_token());
  message.mutable_hello()->mutable_viewport()->set_width(64);
  message.mutable_hello()->mutable_viewport()->set_height(48);
  message.mutable_hello()->add_moving_formats("jpeg");
  message.mutable_hello()->add_moving_formats("vp9-444");
  message.mutable_hello()->set_moving_format("vp9-444");
  sessions_->receive(joined, message, now_);
  const auto second = take<FrameRequest>();
  ASSERT_TRUE(first && second && second->video);
  EXPECT_EQ(second->session, first->session);
  EXPECT_EQ(second->video->stream, first->video->stream);
  EXPECT_TRUE(second->video->key);
  sessions_->detach(viewer_, now_);
  EXPECT_TRUE(closed_streams_.empty());
  sessions_->detach(joined, now_);
  EXPECT_EQ(closed_streams_, std::vector<StreamId>{first->video->stream});
}

/// A viewer that takes lossless pictures in pieces, at rest, before an engine that answers with five.
class BandsAtRest : public NegotiatedCodec {
 protected:
  /// Answers what comes before it, and returns the lossless request. The link carries a megabyte a second.
  FrameRequest rest() {
    hello({"jpeg"}, {"png", "png-bands"});
    sessions_->round_trip(viewer_, std::chrono::milliseconds(1), now_);
    for (int i = 0; i < 4; ++i) {
      const auto request = take<FrameRequest>();
      if (!request || request->lossless) return request.value_or(FrameRequest{});
      start(*request);
      finish(*request, true);
      now_ += std::chrono::milliseconds(200);
      acknowledge();
      now_ += std::chrono::seconds(1);
      sessions_->tick(now_);
    }
    ADD_FAILURE() << "no lossless frame";
    return {};
  }
  void finish_bands(const FrameRequest& request, int count) {
    FrameReady ready;
    ready.session = request.session;
    ready.request = request.request;
    ready.revision = 1000;
    ready.lossless = true;
    ready.jpeg = false;
    ready.width = request.width;
    ready.height = request.height;
    std::vector<PngBand> bands;
    for (int i = 0; i < count; ++i) bands.push_back({i, 1, Bytes(60000, static_cast<std::uint8_t>(i))});
    ready.bands = std::make_shared<const std::vector<PngBand>>(std::move(bands));
    sessions_->on_event(ready, now_);
  }
};

TEST_F(BandsAtRest, FollowEachOtherAsTheyAreAcknowledged) {
  const FrameRequest request = rest();
  EXPECT_GT(request.band_bytes, 0u);
  EXPECT_LE(request.band_bytes, 64u << 10);
  start(request);
  outbox_.frames.clear();
  outbox_.payloads.clear();
  finish_bands(request, 9);
  EXPECT_LT(outbox_.frames.size(), 9u);
  for (int i = 0; i < 20; ++i) {
    now_ += std::chrono::milliseconds(60);
    acknowledge();
  }
  ASSERT_EQ(outbox_.frames.size(), 9u);
  for (std::uint32_t i = 0; i < 9; ++i) {
    EXPECT_EQ(outbox_.frames[i].band().index(), i);
    EXPECT_EQ(outbox_.frames[i].band().first_row(), i);
    EXPECT_EQ(outbox_.frames[i].band().count(), 9u);
    EXPECT_EQ(outbox_.frames[i].frame_id(), outbox_.frames[0].frame_id() + i);
    EXPECT_EQ(outbox_.payloads[i]->size(), 60000u);
    EXPECT_EQ(outbox_.frames[i].phase(), v1::FRAME_PHASE_LOSSLESS);
  }
}

TEST_F(BandsAtRest, ThoseThatHaveNotLeftAreGivenUpForNewInput) {
  const FrameRequest request = rest();
  start(request);
  outbox_.frames.clear();
  outbox_.payloads.clear();
  finish_bands(request, 9);
  receive(camera_at(0, 3));
  const std::size_t left = outbox_.frames.size();
  EXPECT_LT(left, 9u);
  for (int i = 0; i < 9; ++i) {
    now_ += std::chrono::milliseconds(60);
    acknowledge();
  }
  EXPECT_EQ(outbox_.frames.size(), left);
  const auto next = take<FrameRequest>();
  ASSERT_TRUE(next);
  EXPECT_FALSE(next->lossless);
}

TEST_F(BandsAtRest, APictureThatIsAskedForByNameComesInOnePiece) {
  const FrameRequest request = rest();
  start(request);
  finish_bands(request, 1);
  acknowledge();
  v1::ClientMessage still;
  still.mutable_request_still();
  receive(still);
  const auto asked = take<FrameRequest>();
  ASSERT_TRUE(asked && asked->lossless);
  EXPECT_EQ(asked->band_bytes, 0u);
  EXPECT_TRUE(request.until_newer);
  EXPECT_FALSE(asked->until_newer) << "whoever asks gets it, whatever others do meanwhile";
}

TEST_F(NegotiatedCodec, APictureOfAHandThatRestsIsGivenUpWhenItGoesOn) {
  hello({"jpeg"});
  v1::ClientMessage grip;
  grip.mutable_interaction()->set_active(true);
  receive(grip);
  const auto moving = take<FrameRequest>();
  ASSERT_TRUE(moving);
  EXPECT_FALSE(moving->until_newer) << "of a hand that goes on, each is shown";
  start(*moving);
  finish(*moving, true);
  acknowledge();
  now_ += std::chrono::seconds(1);
  sessions_->tick(now_);
  const auto settled = take<FrameRequest>();
  ASSERT_TRUE(settled && !settled->lossless);
  EXPECT_EQ(settled->width, 64);
  EXPECT_TRUE(settled->until_newer);
  start(*settled);
  receive(camera_at(0, 3));
  sessions_->on_event(RequestFailed{settled->session, settled->request, 0, ErrorCode::cancelled, "a newer scene came first"}, now_);
  const auto next = take<FrameRequest>();
  ASSERT_TRUE(next) << "and the one in motion comes at once";
  EXPECT_FALSE(next->until_newer);
}

TEST_F(NegotiatedCodec, WhoDoesNotNameBandsGetsTheLosslessPictureInOnePiece) {
  hello({"jpeg"}, {"png"});
  const auto moving = take<FrameRequest>();
  start(*moving);
  finish(*moving, true);
  acknowledge();
  now_ += std::chrono::seconds(1);
  sessions_->tick(now_);
  const auto request = take<FrameRequest>();
  ASSERT_TRUE(request && request->lossless);
  EXPECT_EQ(request->band_bytes, 0u);
}

}  // namespace
}  // namespace isostrata
