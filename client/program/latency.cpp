// latency: drags an interval's upper end as a person would and measures what comes back.
//
// An input's latency is the time from sending it to having decoded the first frame that contains it (Frame.input_seq), taken over
// every input that was sent while frames were coming: those that a newer one overtook count too, and have waited longest.
#include <algorithm>
#include <boost/json/object.hpp>
#include <boost/json/serialize.hpp>
#include <cmath>
#include <cstdio>
#include <deque>

#include "arguments.h"

namespace isostrata::client {
namespace {

using Steady = std::chrono::steady_clock;

double ms_between(Steady::time_point a, Steady::time_point b) { return std::chrono::duration<double, std::milli>(b - a).count(); }

double percentile(std::vector<double>& sorted, double p) {
  if (sorted.empty()) return 0;
  return sorted[static_cast<std::size_t>(
      std::min<double>(std::ceil(p * static_cast<double>(sorted.size())), static_cast<double>(sorted.size())) - (p > 0 ? 1 : 0))];
}

struct Measured {
  double seconds = 0;
  std::size_t inputs = 0;
  std::vector<double> latency_ms, decode_ms, bytes, extract_ms, draw_ms, encode_ms;
  std::int64_t tetrahedra = 0;
  std::string device;
};

Measured drag(Client& client, double seconds) {
  const v1::Interval dragged = client.state().intervals(0);
  v1::ClientMessage begin;
  begin.mutable_interaction()->set_active(true);
  client.send(std::move(begin));

  Measured measured;
  struct Input {
    std::uint64_t seq;
    Steady::time_point at;
  };
  std::deque<Input> inputs;
  const auto interval = std::chrono::duration_cast<Steady::duration>(std::chrono::duration<double>(1.0 / 60));
  const auto start = Steady::now();
  const auto end = start + std::chrono::duration_cast<Steady::duration>(std::chrono::duration<double>(seconds));
  const auto give_up = end + std::chrono::seconds(10);
  for (auto next = start;;) {
    const auto now = Steady::now();
    if (now < end && now >= next) {
      // Down to 80 % of the interval's width and back, once in two seconds.
      const double phase = ms_between(start, now) / 2000;
      const double width = (dragged.upper() - dragged.lower()) * (0.9 + 0.1 * std::cos(2 * 3.14159265358979 * phase));
      v1::ClientMessage move;
      move.mutable_patch_interval()->set_id(dragged.id());
      move.mutable_patch_interval()->set_upper(dragged.lower() + width);
      inputs.push_back({client.send(std::move(move)), now});
      ++measured.inputs;
      next = std::max(next + interval, now);
    }
    if (now >= end && (inputs.empty() || now >= give_up)) break;
    const auto wait =
        now < end ? std::chrono::duration_cast<std::chrono::milliseconds>(next - now) : std::chrono::milliseconds(50);
    const auto message = client.receive(std::clamp(wait, std::chrono::milliseconds(0), std::chrono::milliseconds(50)));
    if (!message) continue;
    if (message->has_error()) throw ClientError(message->error().code(), message->error().message());
    if (!message->has_frame()) continue;
    const v1::Frame& frame = message->frame();
    const auto arrived = Steady::now();
    decode(frame.payload());
    const auto decoded = Steady::now();
    for (; !inputs.empty() && inputs.front().seq <= frame.input_seq(); inputs.pop_front())
      measured.latency_ms.push_back(ms_between(inputs.front().at, decoded));
    if (arrived > end) continue;
    measured.decode_ms.push_back(ms_between(arrived, decoded));
    measured.bytes.push_back(static_cast<double>(frame.payload().size()));
    measured.extract_ms.push_back(frame.stages().extract_ms());
    measured.draw_ms.push_back(frame.stages().order_ms() + frame.stages().draw_ms() + frame.stages().readback_ms());
    measured.encode_ms.push_back(frame.stages().encode_ms());
    measured.tetrahedra = std::max(measured.tetrahedra, frame.facts().tetrahedra());
    measured.device = frame.facts().device();
  }
  measured.seconds = seconds;
  v1::ClientMessage finish;
  finish.mutable_interaction()->set_active(false);
  client.send(std::move(finish));
  return measured;
}

boost::json::object summary(std::vector<double>& values) {
  std::sort(values.begin(), values.end());
  return {{"p50", percentile(values, 0.5)}, {"p95", percentile(values, 0.95)}, {"max", percentile(values, 1)}};
}

}  // namespace

void add_latency(CLI::App& app, Options& options) {
  CLI::App* command = app.add_subcommand(
      "latency", "Drags an interval's end at up to 60 moves a second and reports frames per second and latency");
  const auto arguments = std::make_shared<SceneArguments>();
  const auto seconds = std::make_shared<double>(5);
  const auto json = std::make_shared<bool>(false);
  add_scene_options(*command, *arguments);
  command->add_option("--seconds", *seconds, "How long to drag")->check(CLI::Range(0.1, 3600.0))->capture_default_str();
  command->add_flag("--json", *json, "One JSON document");
  command->callback([&options, arguments, seconds, json] {
    Client client = connect(options, *arguments);
    set_scene(client, *arguments);
    if (client.state().intervals_size() == 0)
      throw ClientError("not_found", "the session has no interval to drag; give one with --interval");
    client.lossless_frame();  // loading and the first extraction are not what is measured
    Measured m = drag(client, *seconds);
    if (m.decode_ms.empty() || m.latency_ms.empty()) throw ClientError("timeout", "no frame came while the interval was dragged");
    double bytes = 0;
    for (const double b : m.bytes) bytes += b;
    const auto frames = m.decode_ms.size();
    const double fps = static_cast<double>(frames) / m.seconds;
    boost::json::object document{{"dataset", client.state().dataset()},
                                 {"device", m.device},
                                 {"seconds", m.seconds},
                                 {"frames", frames},
                                 {"fps", fps},
                                 {"inputs", m.inputs},
                                 {"input_to_decoded_ms", summary(m.latency_ms)},
                                 {"bytes_per_frame", bytes / static_cast<double>(frames)},
                                 {"tetrahedra", m.tetrahedra},
                                 {"extract_ms", summary(m.extract_ms)},
                                 {"draw_ms", summary(m.draw_ms)},
                                 {"encode_ms", summary(m.encode_ms)},
                                 {"decode_ms", summary(m.decode_ms)}};
    int width = 0, height = 0;
    parse_size(arguments->size, width, height);
    document["size"] = {width, height};
    if (*json) {
      std::printf("%s\n", boost::json::serialize(document).c_str());
      return;
    }
    std::printf("%zu frames in %.1f s: %.1f frames per second, %.0f bytes each, up to %lld tetrahedra on %s\n", frames, m.seconds,
                fps, bytes / static_cast<double>(frames), static_cast<long long>(m.tetrahedra), m.device.c_str());
    std::printf("input to decoded frame: p50 %.1f ms, p95 %.1f ms, max %.1f ms over %zu inputs\n", percentile(m.latency_ms, 0.5),
                percentile(m.latency_ms, 0.95), percentile(m.latency_ms, 1), m.latency_ms.size());
  });
}

}  // namespace isostrata::client
