// Which codec a viewer gets over links and on machines of all kinds: real sessions on a ticked clock, before an engine and a
// link whose times are given.
#include <gtest/gtest.h>

#include <algorithm>
#include <deque>
#include <functional>
#include <map>

#include "engine/messages/coarse_levels.h"
#include "session/fake_engine.h"

namespace isostrata {
namespace {

constexpr int kWidth = 1280, kHeight = 720;
constexpr double kTickMs = 0.5;

struct World {
  double rest_ms = 0;  // before the hand begins
  double round_trip_ms = 1;
  std::function<double(double)> bits_per_second = [](double) { return 1e9; };
  std::function<double(double)> load = [](double) { return 1.0; };  // what the machine's times are multiplied with
  double draw_ms = 4, drawn_part = 0.7;  // of a whole picture, of which that is in proportion to pixels
  double extract_ms = 0;  // of all points of the grid, of which the first coarse level takes an eighth; 0: the hand turns, else it moves layers
  double jpeg_ms = 2.5, video_ms = 10;   // of encoding
  double jpeg_decode_ms = 2, video_decode_ms = 3;
  double jpeg_bytes = 33000, video_bytes = 6500;
};

struct Shown {
  double at_ms;
  std::string format;
  int width;
  int point_stride = 1;
};

struct Watched {
  std::vector<Shown> frames;
  std::vector<std::pair<double, double>> latency;  // of each input: when it was made, until its picture was decoded; ms

  double p95(double from_ms, double to_ms = 1e9) const {
    std::vector<double> values;
    for (const auto& [at, ms] : latency)
      if (at >= from_ms && at < to_ms) values.push_back(ms);
    if (values.empty()) return 1e9;
    std::sort(values.begin(), values.end());
    return values[static_cast<std::size_t>(0.95 * static_cast<double>(values.size() - 1))];
  }
  double longest(double from_ms, double to_ms) const {
    double ms = 0;
    for (const auto& [at, of] : latency)
      if (at >= from_ms && at < to_ms) ms = std::max(ms, of);
    return ms;
  }
  double part(const std::string& format, double from_ms, double to_ms = 1e9) const {
    double all = 0, with = 0;
    for (const Shown& of : frames)
      if (of.at_ms >= from_ms && of.at_ms < to_ms) ++all, with += of.format == format;
    return all > 0 ? with / all : 0;
  }
  int changes() const {
    int n = 0;
    for (std::size_t i = 1; i < frames.size(); ++i) n += frames[i].format != frames[i - 1].format;
    return n;
  }
};

v1::ClientMessage dragged(int to) {
  v1::ClientMessage message;
  v1::Interval& interval = *message.mutable_set_intervals()->add_intervals();
  interval.set_lower(1);
  interval.set_upper(2 + 0.001 * to);
  return message;
}

/// A hand that turns, or moves layers, for so long. format: of Hello; empty: by time.
Watched watch(const World& world, double seconds, const std::string& format = "") {
  SessionsOptions options;
  options.moving_codecs = {Codec::vp9_444, Codec::jpeg};
  SessionsOnAClock s(std::move(options));
  v1::Hello hello = SessionsOnAClock::looking(kWidth, kHeight);
  hello.add_moving_formats("vp9-444");
  hello.set_moving_format(format);
  const TimePoint origin = s.now;
  const auto client = s.connect(hello);
  const auto ms = [](double v) { return std::chrono::duration_cast<Duration>(std::chrono::duration<double, std::milli>(v)); };
  s.open();

  double now = 0, renderer_free = 0, encoder_free = 0, decoder_free = 0, queue_bits = 0, next_input = world.rest_ms, next_ping = 0;
  struct Event {
    double at_ms;
    std::function<void()> happen;
  };
  std::deque<Event> events;
  const auto at = [&](double when, std::function<void()> happen) { events.push_back({when, std::move(happen)}); };
  std::deque<std::pair<double, v1::Frame>> on_link;  // with the bits before and of it that must still pass
  std::map<std::uint64_t, double> inputs;            // when each message was sent
  std::map<StreamId, int> width_of;
  Watched run;

  const auto arrive = [&](const v1::Frame& frame) {
    const double load = world.load(now), size = static_cast<double>(frame.width()) * frame.height() / (kWidth * kHeight);
    const double decoding = (frame.format() == "jpeg" ? world.jpeg_decode_ms : world.video_decode_ms) * size * load;
    const double begun = now;
    decoder_free = std::max(decoder_free, now) + decoding;
    at(decoder_free, [&, frame, begun] {
      run.frames.push_back({now, frame.format(), static_cast<int>(frame.width()), static_cast<int>(frame.facts().point_stride())});
      for (auto it = inputs.begin(); it != inputs.end() && it->first <= frame.input_seq(); it = inputs.erase(it))
        run.latency.emplace_back(it->second, now - it->second);
      v1::ClientMessage ack;
      ack.mutable_frame_ack()->set_frame_id(frame.frame_id());
      ack.mutable_frame_ack()->set_decode_ms(now - begun);
      at(now + world.round_trip_ms / 2, [&, ack] { s.say(*client, ack); });
    });
  };
  std::function<void()> serve = [&] {
    for (const FrameRequest& request : s.take<FrameRequest>()) {
      const double begin = std::max(now, renderer_free), load = world.load(now);
      const double size = static_cast<double>(request.width) * request.height / (kWidth * kHeight);
      const double coarser = request.coarse > 0 ? 2 * kCoarser.at(static_cast<std::size_t>(request.coarse - 1)) : 1;
      const double extract = world.extract_ms * load / std::pow(coarser, 3);
      const double draw = world.draw_ms * load * (1 - world.drawn_part + world.drawn_part * size) / coarser;
      const bool key = request.video && width_of[request.video->stream] != request.width;
      if (request.video) width_of[request.video->stream] = request.width;
      const double encode = (request.video ? world.video_ms : world.jpeg_ms) * load * size * (key ? 3 : 1);
      renderer_free = begin + extract + draw;
      encoder_free = std::max(encoder_free, renderer_free) + encode;
      const double made = encoder_free, total = made - begin;
      at(begin, [&, request, coarser, extract, draw, encode, made, total, key, size] {
        s.start(request);
        const std::uint64_t revision = s.sessions->list().front()->scene().revision;
        at(made, [&, request, coarser, extract, draw, encode, total, key, size, revision] {
          FrameReady ready;
          ready.session = request.session;
          ready.request = request.request;
          ready.revision = revision;
          ready.lossless = request.lossless;
          ready.jpeg = request.jpeg;
          ready.width = request.width;
          ready.height = request.height;
          ready.point_stride = static_cast<int>(coarser);
          ready.coarse_at_hand = request.coarse > 0;
          ready.stages = {extract, 0.3, draw - 0.3, 0, encode, total};
          if (request.video) ready.video = VideoFacts{request.video->codec, request.video->stream, key};
          double bytes = 130000;
          if (request.video)
            bytes =
                std::min(world.video_bytes * size * (key ? 3 : 1), request.video->bitrate_kbps * 1000.0 / 30 / 8 * (key ? 3 : 1));
          else if (!request.lossless)
            bytes =
                std::max(800.0, world.jpeg_bytes * std::pow(size, 0.8) * (0.2 + 0.8 * std::pow(request.jpeg_quality / 90.0, 2)));
          ready.bytes = std::make_shared<const Bytes>(static_cast<std::size_t>(bytes), 7);
          s.sessions->on_event(ready, s.now);
        });
      });
    }
    for (std::size_t i = 0; i < client->outbox.frames.size(); ++i) {
      queue_bits += 8 * static_cast<double>(client->outbox.payloads[i]->size());
      on_link.emplace_back(queue_bits, client->outbox.frames[i]);
    }
    client->outbox.frames.clear();
    client->outbox.payloads.clear();
    client->outbox.messages.clear();
  };

  for (int i = 0; now < seconds * 1000; now += kTickMs) {
    s.now = origin + ms(now);
    if (now >= next_input) {
      const double sent = now;
      next_input += 1000.0 / 60;
      at(now + world.round_trip_ms / 2, [&, sent, x = i++] {
        s.say(*client, world.extract_ms > 0 ? dragged(x) : SessionsOnAClock::camera(x));
        inputs[client->seq] = sent;
      });
    }
    if (now >= next_ping) {
      next_ping += 2000;
      s.sessions->round_trip(client->key, ms(world.round_trip_ms), s.now);
    }
    s.sessions->tick(s.now);
    serve();
    if (queue_bits > 0) {
      const double passed = std::min(queue_bits, world.bits_per_second(now) * kTickMs / 1000);
      queue_bits -= passed;
      for (auto& [left, frame] : on_link) left -= passed;
      for (; !on_link.empty() && on_link.front().first <= 1e-6; on_link.pop_front())
        at(now + world.round_trip_ms / 2, [&, frame = on_link.front().second] { arrive(frame); });
    }
    for (std::size_t e = 0; e < events.size();) {
      if (events[e].at_ms > now) {
        ++e;
        continue;
      }
      const auto happen = std::move(events[e].happen);
      events.erase(events.begin() + static_cast<std::ptrdiff_t>(e));
      happen();
      serve();
      e = 0;
    }
  }
  return run;
}

const auto kTwoMegabits = [](double) { return 2e6; };

TEST(CodecByTime, OnAFastLinkItIsTheOneThatIsMadeSooner) {
  const Watched run = watch({}, 6);
  EXPECT_EQ(run.part("jpeg", 0), 1) << "nothing else could be sooner, so nothing else is tried";
}

TEST(CodecByTime, OnASlowLinkItIsVideo) {
  World world;
  world.round_trip_ms = 80;
  world.bits_per_second = kTwoMegabits;
  EXPECT_GT(watch(world, 8).part("vp9-444", 2500), 0.95);
}

TEST(CodecByTime, FollowsARateThatFallsToATenth) {
  World world;
  world.round_trip_ms = 20;
  world.bits_per_second = [](double at) { return at < 4000 ? 60e6 : 4e6; };
  const Watched run = watch(world, 10);
  EXPECT_GT(run.part("jpeg", 1000, 4000), 0.95);
  EXPECT_GT(run.part("vp9-444", 6000), 0.95);
}

TEST(CodecByTime, ABusyProcessorTurnsVideoToPicturesAndBack) {
  World world;
  world.round_trip_ms = 5;
  world.bits_per_second = [](double) { return 12e6; };
  world.load = [](double at) { return at > 5000 && at < 10000 ? 5.0 : 1.0; };
  const Watched run = watch(world, 40);
  EXPECT_GT(run.part("vp9-444", 2500, 5000), 0.95);
  EXPECT_GT(run.part("jpeg", 6500, 10000), 0.8);
  EXPECT_GT(run.part("vp9-444", 25000), 0.8);
}

TEST(CodecByTime, PixelsAreGivenUpOnlyWhereTheyAreWhatTakesTheTime) {
  World slow;
  slow.draw_ms = 200;
  slow.drawn_part = 0.95;
  Watched run = watch(slow, 10);
  EXPECT_LT(run.frames.back().width, kWidth);
  slow.drawn_part = 0;
  run = watch(slow, 10);
  EXPECT_EQ(run.frames.back().width, kWidth);
  slow.drawn_part = 0.95;
  slow.load = [](double at) { return at < 5000 ? 1 : 0.05; };
  run = watch(slow, 12);
  EXPECT_EQ(run.frames.back().width, kWidth);
}

// A hand that begins to turn what rests.
TEST(CodecByTime, TheFirstPictureOfAGestureIsInTimeAndLaterOnesAreNoSmallerThanTheyMustBe) {
  World world;
  world.rest_ms = 1500;
  for (const double draw_ms : {5.0, 40.0, 80.0, 150.0}) {
    world.draw_ms = draw_ms;
    world.drawn_part = 0.9;
    const Watched run = watch(world, 5);
    std::vector<int> widths;
    for (const Shown& frame : run.frames)
      if (frame.at_ms > world.rest_ms && frame.format != "png") widths.push_back(frame.width);
    ASSERT_GT(widths.size(), 60u) << draw_ms;
    EXPECT_LE(run.p95(world.rest_ms), 70) << draw_ms << " ms: at " << widths.front() << ", then " << widths.back();
    EXPECT_LE(std::abs(widths.front() - widths.back()), kWidth / 4) << draw_ms << " ms: the first forecast is nearly right";
    int changes = 0;
    for (std::size_t i = 1; i < widths.size(); ++i) changes += widths[i] != widths[i - 1];
    EXPECT_LE(changes, 2) << draw_ms;
  }
}

// The law that all of it is for.
TEST(CodecByTime, IsNowhereMuchLaterThanTheBetterOfTheTwo) {
  for (const double mbit : {1000.0, 50.0, 20.0, 10.0, 5.0, 2.0, 1.0})
    for (const double round_trip : {0.5, 40.0})
      for (const double load : {0.5, 1.0, 4.0}) {
        World world;
        world.round_trip_ms = round_trip;
        world.bits_per_second = [=](double) { return mbit * 1e6; };
        world.load = [=](double) { return load; };
        const double mine = watch(world, 8).p95(2000);
        const double jpeg = watch(world, 5, "jpeg").p95(2000), video = watch(world, 5, "vp9-444").p95(2000);
        EXPECT_LE(mine, 1.12 * std::min(jpeg, video) + 1)
            << mbit << " Mb/s, " << round_trip << " ms, load " << load << ": jpeg " << jpeg << ", video " << video;
      }
}

// Whatever is on its way when a line gets slower is late: by less, the less it is.
TEST(CodecByTime, IsNowhereMuchLaterWhereALineBecomesTenTimesSlower) {
  World world;
  world.round_trip_ms = 40;
  world.bits_per_second = [](double ms) { return 20e6 * std::pow(0.1, std::clamp((ms - 5000) / 1000, 0.0, 1.0)); };
  const double mine = watch(world, 9).p95(3000);
  const double jpeg = watch(world, 9, "jpeg").p95(3000), video = watch(world, 9, "vp9-444").p95(3000);
  EXPECT_LE(mine, 1.12 * std::min(jpeg, video) + 1) << "jpeg " << jpeg << ", video " << video;
}

TEST(CodecByTime, LayersThatTakeLongToBeCutAreMovedAsCoarselyAsIsInTime) {
  World world;
  world.draw_ms = 50;
  for (const auto& [extract_ms, stride] : std::vector<std::pair<double, int>>{{5, 1}, {100, 2}, {350, 3}, {1000, 4}}) {
    world.extract_ms = extract_ms;
    const Watched run = watch(world, 7);
    ASSERT_FALSE(run.frames.empty());
    for (const Shown& of : run.frames)
      EXPECT_TRUE(of.at_ms < 4000 || of.point_stride == stride) << extract_ms << " ms: " << of.point_stride << ", shown at " << of.at_ms;
    EXPECT_LE(run.p95(4000), 80) << extract_ms << " ms";
  }
}

TEST(CodecByTime, AHandThatBeginsToMoveLayersFindsASizeThatIsInTime) {
  World world;
  world.draw_ms = 25;
  world.rest_ms = 3000;
  for (const double extract_ms : {5.0, 20.0, 100.0}) {
    world.extract_ms = extract_ms;
    EXPECT_LE(watch(world, 5).longest(3000, 3500), 70) << extract_ms << " ms";
  }
}

}  // namespace
}  // namespace isostrata
