// Drags one end of an interval to and fro, as a hand does, and times each move until a decoded frame contains it.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <deque>
#include <memory>

#include "commands.h"

namespace isostrata::client {
namespace {

using Clock = std::chrono::steady_clock;

double ms_between(Clock::time_point a, Clock::time_point b) { return std::chrono::duration<double, std::milli>(b - a).count(); }

double percentile(const std::vector<double>& sorted, double p) {
  if (sorted.empty()) return std::nan("");
  return sorted[std::min(sorted.size() - 1, static_cast<std::size_t>(p * static_cast<double>(sorted.size())))];
}

struct Measured {
  std::vector<double> latency_ms;  // of every move, to the first decoded frame that contains it
  std::vector<double> decode_ms;
  std::uint64_t frames = 0, bytes = 0, moves = 0;
  std::int64_t tetrahedra = 0;
  double seconds = 0;
  v1::StageTimes stages;  // sums
  std::string device, format;
};

void add(v1::StageTimes& sum, const v1::StageTimes& one) {
  sum.set_extract_ms(sum.extract_ms() + one.extract_ms());
  sum.set_order_ms(sum.order_ms() + one.order_ms());
  sum.set_draw_ms(sum.draw_ms() + one.draw_ms());
  sum.set_readback_ms(sum.readback_ms() + one.readback_ms());
  sum.set_encode_ms(sum.encode_ms() + one.encode_ms());
  sum.set_total_ms(sum.total_ms() + one.total_ms());
}

Measured drag(Connection& connection, const v1::Interval& interval, double seconds, double rate_hz) {
  struct Sent {
    std::uint64_t seq;
    Clock::time_point at;
  };
  std::deque<Sent> pending;
  Measured measured;
  v1::ClientMessage begin;
  begin.mutable_interaction()->set_active(true);
  connection.send(std::move(begin));

  const auto start = Clock::now();
  const auto period = std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(1.0 / rate_hz));
  const double span = interval.upper() - interval.lower();
  auto next_move = start;
  while (ms_between(start, Clock::now()) < seconds * 1000 || !pending.empty()) {
    const auto now = Clock::now();
    const bool moving = ms_between(start, now) < seconds * 1000;
    if (!moving && ms_between(start, now) > seconds * 1000 + 30'000) throw Error("timeout", "the last moves were never shown");
    if (moving && now >= next_move) {
      // One swing of a tenth of the interval's width each second; the range of active cells changes with every move.
      const double phase = ms_between(start, now) / 1000 * 2 * 3.14159265358979;
      v1::ClientMessage move;
      move.mutable_patch_interval()->set_id(interval.id());
      move.mutable_patch_interval()->set_upper(interval.upper() - 0.05 * span * (1 - std::cos(phase)));
      pending.push_back({connection.send(std::move(move)), now});
      ++measured.moves;
      next_move = std::max(next_move + period, now);
    }
    const auto wait = std::chrono::ceil<std::chrono::milliseconds>(moving ? next_move - Clock::now() : Clock::duration(std::chrono::milliseconds(100)));
    const auto message = connection.receive(std::max(wait, std::chrono::milliseconds(0)));
    if (!message) continue;
    if (message->has_error()) throw Error(message->error().code(), message->error().message());
    if (!message->has_frame()) continue;
    const v1::Frame& frame = message->frame();
    const auto arrived = Clock::now();
    if (frame.format() == "jpeg") decode_jpeg(frame.payload());
    const auto decoded = Clock::now();
    connection.acknowledge(frame, ms_between(arrived, decoded));
    while (!pending.empty() && pending.front().seq <= frame.input_seq()) {
      measured.latency_ms.push_back(ms_between(pending.front().at, decoded));
      pending.pop_front();
    }
    if (!moving) continue;
    ++measured.frames;
    measured.bytes += frame.payload().size();
    measured.decode_ms.push_back(ms_between(arrived, decoded));
    measured.tetrahedra = frame.facts().tetrahedra();
    measured.device = frame.facts().device();
    measured.format = frame.format();
    add(measured.stages, frame.stages());
    measured.seconds = ms_between(start, decoded) / 1000;
  }
  std::sort(measured.latency_ms.begin(), measured.latency_ms.end());
  return measured;
}

void print(const Measured& m, const SceneArguments& scene, bool json) {
  if (m.frames == 0) throw Error("timeout", "no frame arrived during the drag");
  const double frames = static_cast<double>(m.frames);
  const double fps = frames / m.seconds;
  double decode = 0;
  for (const double ms : m.decode_ms) decode += ms / frames;
  const auto mean = [&](double sum) { return sum / frames; };
  if (json) {
    std::printf(
        "{\"size\":\"%s\",\"seconds\":%.3f,\"moves\":%llu,\"frames\":%llu,\"fps\":%.3f,\"input_to_decoded_ms\":{\"p50\":%.2f,\"p95\":%.2f,"
        "\"max\":%.2f},\"bytes_per_frame\":%.0f,\"codec\":\"%s\",\"tetrahedra\":%lld,\"mean_ms\":{\"extract\":%.2f,\"order\":%.2f,\"draw\":%.2f,"
        "\"readback\":%.2f,\"encode\":%.2f,\"total\":%.2f,\"decode\":%.2f}}\n",
        scene.size.c_str(), m.seconds, static_cast<unsigned long long>(m.moves), static_cast<unsigned long long>(m.frames), fps,
        percentile(m.latency_ms, 0.5), percentile(m.latency_ms, 0.95), percentile(m.latency_ms, 1), static_cast<double>(m.bytes) / frames,
        m.format.c_str(), static_cast<long long>(m.tetrahedra), mean(m.stages.extract_ms()), mean(m.stages.order_ms()),
        mean(m.stages.draw_ms()), mean(m.stages.readback_ms()), mean(m.stages.encode_ms()), mean(m.stages.total_ms()), decode);
    return;
  }
  std::printf("%.2f frames per second over %.1f s at %s (%lld tetrahedra, %s)\n", fps, m.seconds, scene.size.c_str(),
              static_cast<long long>(m.tetrahedra), m.device.c_str());
  std::printf("input to decoded frame  p50 %.1f ms, p95 %.1f ms, max %.1f ms over %llu moves\n", percentile(m.latency_ms, 0.5),
              percentile(m.latency_ms, 0.95), percentile(m.latency_ms, 1), static_cast<unsigned long long>(m.moves));
  std::printf("mean stages             extract %.1f, order %.1f, draw %.1f, readback %.1f, encode %.1f, decode %.1f ms; %.0f bytes a frame\n",
              mean(m.stages.extract_ms()), mean(m.stages.order_ms()), mean(m.stages.draw_ms()), mean(m.stages.readback_ms()),
              mean(m.stages.encode_ms()), decode, static_cast<double>(m.bytes) / frames);
}

}  // namespace

void add_latency_command(CLI::App& app, const std::string& url) {
  struct Arguments {
    SceneArguments scene;
    double seconds = 10;
    double rate_hz = 60;
    bool json = false;
  };
  auto* command = app.add_subcommand("latency", "Drags an interval's upper end and times every move until a decoded frame contains it");
  auto arguments = std::make_shared<Arguments>();
  arguments->scene.add_to(*command);
  command->add_option("--seconds", arguments->seconds, "How long to drag")->capture_default_str()->check(CLI::Range(0.1, 3600.0));
  command->add_option("--rate", arguments->rate_hz, "Moves per second")->capture_default_str()->check(CLI::Range(1.0, 1000.0));
  command->add_flag("--json", arguments->json, "One JSON document");
  command->callback([&url, arguments] {
    std::uint64_t seq = 0;
    Connection connection = arguments->scene.open(url, seq);
    v1::ClientMessage still;
    still.mutable_request_still();
    connection.send(std::move(still));
    connection.wait_for_frame(seq, true, std::chrono::minutes(2));
    if (connection.state().intervals().empty()) throw Error("invalid_argument", "the session has no interval to drag; give --interval LOWER:UPPER");
    const v1::Interval interval = connection.state().intervals(0);
    print(drag(connection, interval, arguments->seconds, arguments->rate_hz), arguments->scene, arguments->json);
  });
}

}  // namespace isostrata::client
