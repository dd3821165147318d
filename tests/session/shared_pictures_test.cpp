// One picture for everyone who looks at it in the same size: drawn once, encoded once, and nobody waits for the slowest.
#include <gtest/gtest.h>

#include <array>
#include <deque>
#include <map>
#include <set>
#include <utility>

#include "session/fake_engine.h"

namespace isostrata {
namespace {

class SharedPictures : public ::testing::Test {
 protected:
  void begin(int viewers, bool video = false) {
    clients_.push_back(s_.connect(s_.looking(64, 48, video)));
    s_.open();
    for (int i = 1; i < viewers; ++i) clients_.push_back(s_.connect(s_.resuming(*clients_[0], s_.looking(64, 48, video))));
    settle();
  }
  /// Draws and acknowledges until nobody asks for anything at this moment.
  void settle() {
    for (int round = 0; round < 100; ++round) {
      const auto requests = s_.take<FrameRequest>();
      if (requests.empty()) return;
      for (const auto& request : requests) {
        s_.start(request);
        s_.finish(request, revision());
      }
      for (auto& client : clients_)
        if (!client->outbox.frames.empty()) s_.acknowledge(*client);
    }
    FAIL() << "frames without end";
  }
  /// Looks away, or looks again.
  void hide(FakeClient& client, bool hidden) {
    v1::ClientMessage message;
    message.mutable_viewport()->set_width(64);
    message.mutable_viewport()->set_height(48);
    message.mutable_viewport()->set_hidden(hidden);
    s_.say(client, message);
  }
  void acknowledge(FakeClient& client, std::uint64_t frame) {
    v1::ClientMessage message;
    message.mutable_frame_ack()->set_frame_id(frame);
    s_.say(client, message);
  }
  std::uint64_t revision() { return s_.sessions->list().front()->scene().revision; }

  SessionsOnAClock s_;
  std::vector<std::shared_ptr<FakeClient>> clients_;
};

TEST_F(SharedPictures, AreAskedForOnceAndSharedToTheByte) {
  begin(64);
  for (auto& client : clients_) client->outbox.frames.clear(), client->outbox.payloads.clear();
  s_.say(*clients_[0], s_.camera(5));
  const auto requests = s_.take<FrameRequest>();
  ASSERT_EQ(requests.size(), 1u);
  s_.start(requests[0]);
  s_.finish(requests[0], revision());
  for (auto& client : clients_) {
    ASSERT_EQ(client->outbox.frames.size(), 1u);
    EXPECT_EQ(client->outbox.payloads[0], clients_[0]->outbox.payloads[0]);
    EXPECT_EQ(client->outbox.frames[0].revision(), revision());
  }
  EXPECT_EQ(clients_[0]->outbox.frames[0].input_seq(), clients_[0]->seq) << "its own input, not the others'";
}

TEST_F(SharedPictures, AnotherSizeIsAnotherPicture) {
  begin(2);
  clients_.push_back(s_.connect(s_.resuming(*clients_[0], s_.looking(100, 48))));
  settle();
  s_.say(*clients_[0], s_.camera(5));
  EXPECT_EQ(s_.take<FrameRequest>().size(), 2u);
}

TEST_F(SharedPictures, WhoComesWhileOneIsDrawnTakesItWhereItIsOfTheNewestScene) {
  begin(2);
  hide(*clients_[1], true);
  const auto had = clients_[1]->outbox.frames.size();
  s_.say(*clients_[0], s_.camera(5));
  const auto request = s_.take<FrameRequest>().at(0);
  s_.start(request);
  hide(*clients_[1], false);
  EXPECT_TRUE(s_.take<FrameRequest>().empty());
  s_.finish(request, revision());
  EXPECT_EQ(clients_[1]->outbox.frames.size(), had + 1);
}

TEST_F(SharedPictures, WhoComesAfterwardsGetsTheSameBytesUntilTheSceneChanges) {
  begin(2);
  hide(*clients_[1], true);
  s_.say(*clients_[0], s_.camera(5));
  const auto request = s_.take<FrameRequest>().at(0);
  s_.start(request);
  s_.finish(request, revision());
  hide(*clients_[1], false);
  EXPECT_TRUE(s_.take<FrameRequest>().empty());
  EXPECT_EQ(clients_[1]->outbox.payloads.back(), clients_[0]->outbox.payloads.back());
  EXPECT_EQ(clients_[1]->outbox.frames.back().revision(), revision());

  hide(*clients_[1], true);
  s_.say(*clients_[0], s_.camera(6));
  for (const auto& newer : s_.take<FrameRequest>()) s_.start(newer);  // and is not finished
  const auto had = clients_[1]->outbox.frames.size();
  hide(*clients_[1], false);
  EXPECT_EQ(clients_[1]->outbox.frames.size(), had) << "the one that is there is of an older scene";
}

TEST_F(SharedPictures, OfAnOlderSceneThanTheNewestAreNotKept) {
  begin(2);
  hide(*clients_[1], true);
  s_.say(*clients_[0], s_.camera(5));
  const auto request = s_.take<FrameRequest>().at(0);
  s_.start(request);
  s_.finish(request, revision() - 1);  // its extraction was not ready
  const auto had = clients_[1]->outbox.frames.size();
  hide(*clients_[1], false);
  EXPECT_EQ(clients_[1]->outbox.frames.size(), had);
}

TEST_F(SharedPictures, WhoComesWhileAnOldOneIsDrawnGetsANewOne) {
  begin(2);
  hide(*clients_[1], true);
  const auto had = clients_[1]->outbox.frames.size();
  s_.say(*clients_[0], s_.camera(5));
  const auto old = s_.take<FrameRequest>().at(0);
  s_.start(old);
  s_.say(*clients_[0], s_.camera(6));
  const auto newer = s_.take<FrameRequest>();
  ASSERT_EQ(newer.size(), 1u);
  hide(*clients_[1], false);
  EXPECT_TRUE(s_.take<FrameRequest>().empty()) << "it joins the one that has not begun";
  s_.finish(old, revision() - 1);
  EXPECT_EQ(clients_[1]->outbox.frames.size(), had);
  s_.start(newer[0]);
  s_.finish(newer[0], revision());
  EXPECT_EQ(clients_[1]->outbox.frames.size(), had + 1);
}

TEST_F(SharedPictures, WhoeverDoesNotAcknowledgeMissesFramesAndHoldsNobody) {
  begin(2);
  const std::size_t had = clients_[1]->outbox.frames.size();
  for (int move = 0; move < 40; ++move) {
    s_.now += std::chrono::milliseconds(12);
    s_.say(*clients_[0], s_.camera(move));
    for (const auto& request : s_.take<FrameRequest>()) {
      s_.start(request);
      s_.finish(request, revision());
    }
    s_.acknowledge(*clients_[0]);
    EXPECT_EQ(clients_[0]->outbox.frames.back().revision(), revision());
  }
  EXPECT_LE(clients_[1]->outbox.frames.size() - had, static_cast<std::size_t>(FrameScheduler::kMaxWindow));
}

// Pictures that wait for the encoder are older when they are sent than those that are drawn later.
TEST_F(SharedPictures, NoneIsAskedForWhileThreeAreBeingMade) {
  begin(1);
  for (int i = 1; i < 4; ++i) clients_.push_back(s_.connect(s_.resuming(*clients_[0], s_.looking(64 + 16 * i, 48))));
  settle();
  s_.say(*clients_[0], s_.camera(5));
  const auto requests = s_.take<FrameRequest>();
  ASSERT_EQ(requests.size(), 4u);
  for (std::size_t i = 0; i < 3; ++i) s_.start(requests[i]);
  EXPECT_TRUE(s_.take<FrameRequest>().empty());
  s_.now += std::chrono::milliseconds(30);
  s_.say(*clients_[0], s_.camera(6));
  EXPECT_TRUE(s_.take<FrameRequest>().empty());
  s_.finish(requests[1], revision() - 1);
  const auto next = s_.take<FrameRequest>();
  ASSERT_EQ(next.size(), 3u) << "each of them, of the newest scene; the fourth viewer's shows that anyway";
}

// With one slow drawing after the other, those who come last in the list are served, too.
TEST_F(SharedPictures, WhereThereIsNoRoomForAllTheyTakeTurns) {
  begin(1);
  for (int i = 1; i < 8; ++i) clients_.push_back(s_.connect(s_.resuming(*clients_[0], s_.looking(64 + 16 * i, 48))));
  settle();
  std::map<int, int> drawn;  // pictures by their width
  std::deque<FrameRequest> waiting, making;
  for (int move = 0; move < 200; ++move) {
    s_.now += std::chrono::milliseconds(10);
    s_.say(*clients_[0], s_.camera(move));
    for (const FrameRequest& request : s_.take<FrameRequest>()) waiting.push_back(request);
    if (!waiting.empty()) {
      s_.start(waiting.front());
      making.push_back(waiting.front());
      waiting.pop_front();
    }
    if (making.size() < 3) continue;
    ++drawn[making.front().width];
    s_.finish(making.front(), revision() - 3);
    making.pop_front();
    for (auto& client : clients_)
      if (!client->outbox.frames.empty()) s_.acknowledge(*client);
  }
  EXPECT_EQ(drawn.size(), clients_.size());
  for (const auto& [width, count] : drawn) EXPECT_GT(count, 200 / 8 / 2) << width;
}

TEST_F(SharedPictures, WhoLeavesTakesNobodysPictureAway) {
  begin(2);
  s_.say(*clients_[0], s_.camera(5));
  const auto request = s_.take<FrameRequest>().at(0);
  s_.leave(*clients_[0]);
  EXPECT_TRUE(s_.take<ForgetFrame>().empty());
  const auto had = clients_[1]->outbox.frames.size();
  s_.start(request);
  s_.finish(request, revision());
  EXPECT_EQ(clients_[1]->outbox.frames.size(), had + 1);
  s_.take<FrameRequest>();
  s_.say(*clients_[1], s_.camera(6));
  const auto last = s_.take<FrameRequest>().at(0);
  s_.leave(*clients_[1]);
  const auto forgotten = s_.take<ForgetFrame>();
  ASSERT_EQ(forgotten.size(), 1u);
  EXPECT_EQ(forgotten[0].request, last.request);
}

TEST_F(SharedPictures, AFailureIsToldToEachAndTheNextIsAskedForOnce) {
  begin(3);
  s_.say(*clients_[0], s_.camera(5));
  const auto request = s_.take<FrameRequest>().at(0);
  s_.start(request);
  s_.sessions->on_event(RequestFailed{request.session, request.request, revision(), ErrorCode::unavailable, "no device"}, s_.now);
  for (auto& client : clients_) EXPECT_EQ(client->outbox.error().code(), "unavailable");
  s_.say(*clients_[0], s_.camera(6));
  EXPECT_EQ(s_.take<FrameRequest>().size(), 1u);
}

TEST_F(SharedPictures, VideoIsOneStreamForAllInStep) {
  begin(3, true);
  s_.say(*clients_[0], s_.camera(5));
  const auto requests = s_.take<FrameRequest>();
  ASSERT_EQ(requests.size(), 1u);
  ASSERT_TRUE(requests[0].video);
  s_.start(requests[0]);
  s_.finish(requests[0], revision());
  for (auto& client : clients_) EXPECT_EQ(client->outbox.frames.back().stream_id(), requests[0].video->stream);
}

TEST_F(SharedPictures, WhoJoinsAVideoStreamBeginsWithItsKeyFrame) {
  begin(1, true);
  s_.now += VideoStreams::kKeyPause;
  clients_.push_back(s_.connect(s_.resuming(*clients_[0], s_.looking(64, 48, true))));
  s_.say(*clients_[0], s_.camera(5));
  bool key = false;
  for (const auto& request : s_.take<FrameRequest>())
    if (request.video) {
      key = key || request.video->key;
      s_.start(request);
      s_.finish(request, revision());
    }
  EXPECT_TRUE(key);
  ASSERT_FALSE(clients_[1]->outbox.frames.empty());
  EXPECT_TRUE(clients_[1]->outbox.frames.front().key());
}

// Rates from 1 to 8 MB/s deserve pictures of seven steps and five sizes.
TEST_F(SharedPictures, ManyOverWaysThatDifferALittleHaveFewDrawings) {
  constexpr int kMany = 32, kMoves = 150;
  for (int i = 0; i < kMany; ++i)
    clients_.push_back(s_.connect(i ? s_.resuming(*clients_[0], s_.looking(1280, 720)) : s_.looking(1280, 720)));
  s_.open();
  std::vector<std::deque<std::pair<TimePoint, std::uint64_t>>> on_the_way(kMany);
  std::vector<TimePoint> free(kMany, s_.now);
  std::vector<FrameRequest> drawing;
  std::set<int> widths;
  std::size_t orders = 0;
  for (int tick = 0; tick < 3 * kMoves; ++tick) {
    s_.now += std::chrono::milliseconds(11);
    if (tick % 3 == 0) s_.say(*clients_[0], s_.camera(tick));
    for (const FrameRequest& request : std::exchange(drawing, {}))
      s_.finish(request, revision(), false,
                static_cast<std::size_t>(request.width * request.height * request.jpeg_quality / 500));
    for (std::size_t i = 0; i < kMany; ++i) {
      auto& outbox = clients_[i]->outbox;
      for (std::size_t f = 0; f < outbox.frames.size(); ++f) {
        const double seconds =
            static_cast<double>(outbox.payloads[f]->size()) / (1e6 + 7e6 * static_cast<double>(i) / (kMany - 1));
        free[i] = std::max(free[i], s_.now) + std::chrono::duration_cast<Duration>(std::chrono::duration<double>(seconds));
        on_the_way[i].emplace_back(free[i], outbox.frames[f].frame_id());
      }
      outbox.frames.clear();
      outbox.payloads.clear();
      for (; !on_the_way[i].empty() && on_the_way[i].front().first <= s_.now; on_the_way[i].pop_front())
        acknowledge(*clients_[i], on_the_way[i].front().second);
    }
    for (const FrameRequest& request : s_.take<FrameRequest>()) {
      if (tick > kMoves) ++orders, widths.insert(request.width);  // once their rates are known
      s_.start(request);
      drawing.push_back(request);
    }
  }
  EXPECT_GT(widths.size(), 1u) << "all ways deserve the same: the test shows nothing";
  EXPECT_LT(static_cast<double>(orders) / (kMoves * 2 / 3), 3.5) << "drawings of each scene";
}

// The law that a predictive codec lives by: between two key frames of a stream, a viewer gets every frame of it.
TEST_F(SharedPictures, NobodyEverMissesAFrameOfTheStreamTheyAreIn) {
  begin(4, true);
  std::map<StreamId, int> made;  // frames of each stream so far
  std::vector<std::map<StreamId, int>> last(clients_.size());
  std::array<std::uint64_t, 4> newest{};
  for (auto& client : clients_) client->outbox.frames.clear();
  s_.say(*clients_[0], s_.camera(-1));
  for (int move = 0; move < 300; ++move) {
    s_.now += std::chrono::milliseconds(30);
    s_.say(*clients_[0], s_.camera(move));
    for (const auto& request : s_.take<FrameRequest>()) {
      s_.start(request);
      const int number = request.video ? ++made[request.video->stream] : 0;
      for (auto& client : clients_) client->outbox.frames.clear();
      s_.finish(request, revision(), number == 1);
      for (std::size_t i = 0; i < clients_.size(); ++i)
        for (const auto& frame : clients_[i]->outbox.frames) {
          newest[i] = frame.frame_id();
          if (frame.stream_id() == 0) continue;
          if (!frame.key()) {
            EXPECT_EQ(number, last[i][frame.stream_id()] + 1) << "viewer " << i << " move " << move;
          }
          last[i][frame.stream_id()] = number;
        }
      for (std::size_t i = 0; i < clients_.size(); ++i)
        if (move % std::array{1, 3, 7, 50}[i] == 0) acknowledge(*clients_[i], newest[i]);
    }
  }
  EXPECT_GT(made.size(), 1u) << "nobody was ever out of step: the test shows nothing";
}

// An encoder for each would take a core for each.
TEST_F(SharedPictures, ManyWhoAreOutOfStepHaveFewStreamsAndPicturesByThemselves) {
  begin(40, true);
  std::set<StreamId> open;
  std::size_t most = 0, orders = 0, by_itself = 0;
  for (int move = 0; move < 300; ++move) {
    s_.now += std::chrono::milliseconds(30);
    s_.say(*clients_[0], s_.camera(move));
    const auto requests = s_.take<FrameRequest>();
    for (const auto& request : requests)
      if (request.video) open.insert(request.video->stream);
    for (const auto& closed : s_.take<CloseStream>()) open.erase(closed.stream);
    most = std::max(most, open.size());
    orders += requests.size();
    for (const auto& request : requests) {
      s_.start(request);
      s_.finish(request, revision());
    }
    for (std::size_t i = 0; i < clients_.size(); ++i) {
      auto& frames = clients_[i]->outbox.frames;
      if (frames.empty()) continue;
      by_itself += frames.back().stream_id() == 0;
      const std::uint64_t newest = frames.back().frame_id();
      if (static_cast<std::size_t>(move) % (1 + i % 9) == 0) {
        acknowledge(*clients_[i], newest);
        frames.clear();
      }
    }
  }
  EXPECT_EQ(most, VideoStreams::kMostStreams);
  EXPECT_GT(by_itself, 0u);
  EXPECT_LT(orders, 300u * 9) << "drawings and encodings for 40 viewers and 300 moves";
}

}  // namespace
}  // namespace isostrata
