// A server, a link and a client on a ticked clock: FrameScheduler decides, pictures take their time to be made, a bottleneck with
// a queue carries them, the client acknowledges. For laws of flow control without sockets and without waiting.
#pragma once

#include <algorithm>
#include <cmath>
#include <deque>
#include <functional>
#include <random>
#include <vector>

#include "session/pacing/frame_scheduler.h"

namespace isostrata {

inline double ms_of(Duration d) { return std::chrono::duration<double, std::milli>(d).count(); }
inline Duration of_ms(double ms) { return std::chrono::duration_cast<Duration>(std::chrono::duration<double, std::milli>(ms)); }

struct SimulatedWorld {
  double round_trip_ms = 40;
  std::function<double(double at_ms)> bits_per_second = [](double) { return 20e6; };
  double jitter_ms = 0;       // of each arrival, evenly from 0
  double stall_every_ms = 0;  // a lost segment: nothing arrives for stall_ms, then all of it
  double stall_ms = 0;
  double draw_ms = 10, encode_ms = 6;
  double full_bytes = 33000;  // of a moving frame at full size and quality 90
  double lossless_bytes = 130000;
  double inputs_per_second = 60;
  double rests_at_ms = 1e18;  // no more input from then on
};

struct SimulatedFrame {
  FrameOrder order;
  double ordered_ms = 0, sent_ms = 0, arrived_ms = 0;
  double input_ms = 0;  // the newest input that it shows
  double bytes = 0;
};

struct SimulatedRun {
  std::vector<SimulatedFrame> frames;              // as they arrived
  std::vector<std::pair<double, double>> latency;  // of each input: when it was made, until it was seen; ms
  double most_held_ms = 0;                         // worth of the link's rate, that waited on it at any time

  double percentile(double p, double from_ms = 0, double to_ms = 1e18) const {
    std::vector<double> values;
    for (const auto& [at, ms] : latency)
      if (at >= from_ms && at < to_ms) values.push_back(ms);
    if (values.empty()) return 1e18;
    std::sort(values.begin(), values.end());
    return values[static_cast<std::size_t>(p * static_cast<double>(values.size() - 1))];
  }
  double fps(double from_ms, double to_ms) const {
    const auto n = std::count_if(frames.begin(), frames.end(),
                                 [&](const auto& f) { return f.arrived_ms >= from_ms && f.arrived_ms < to_ms; });
    return 1000 * static_cast<double>(n) / (to_ms - from_ms);
  }
  const SimulatedFrame* first(FramePhase phase, double from_ms) const {
    for (const SimulatedFrame& frame : frames)
      if (frame.order.phase == phase && frame.arrived_ms >= from_ms) return &frame;
    return nullptr;
  }
};

/// What libjpeg-turbo makes of pictures of volumes, roughly, and not by the ladder's own formula.
inline double jpeg_bytes(const SimulatedWorld& world, const FrameOrder& order, int full_width) {
  const double scale = static_cast<double>(order.width) / full_width, q = order.quality / 90.0;
  return std::max(800.0, world.full_bytes * std::pow(scale, 1.6) * (0.2 + 0.8 * q * q));
}

inline SimulatedRun simulate(const SimulatedWorld& world, double seconds) {
  constexpr int kWidth = 1280, kHeight = 720;
  constexpr double kTick = 0.5;
  const TimePoint origin = TimePoint{} + std::chrono::hours(1);
  std::mt19937 random(5);
  FrameScheduler scheduler;
  SimulatedRun run;
  double now = 0;
  const auto at = [&](double ms) { return origin + of_ms(ms); };
  scheduler.set_viewport(kWidth, kHeight, false, at(0));
  scheduler.round_trip(of_ms(world.round_trip_ms), at(0));  // the ping that follows the handshake

  struct Event {
    double at_ms;
    std::function<void()> happen;
  };
  std::deque<Event> events;  // few: the earliest is looked for
  const auto later = [&](double ms, std::function<void()> happen) { events.push_back({now + ms, std::move(happen)}); };

  double renderer_free = 0, encoder_free = 0;
  double queue_bits = 0;                                  // at the bottleneck
  std::deque<std::pair<double, SimulatedFrame>> on_link;  // with the bits before and of it that must still pass
  double next_input = 0, stalled_until = 0, next_stall = world.stall_every_ms, last_arrival = 0;
  std::uint64_t revision = 0;
  std::vector<std::pair<std::uint64_t, double>> inputs;  // revision, when
  std::size_t seen = 0;

  const auto input_of = [&](std::uint64_t of) {
    double when = 0;
    for (const auto& [r, ms] : inputs) {
      if (r > of) break;
      when = ms;
    }
    return when;
  };
  std::function<void()> pump = [&] {
    scheduler.withdraw_order();
    const auto order = scheduler.next(at(now));
    if (!order) return;
    SimulatedFrame frame;
    frame.order = *order;
    frame.ordered_ms = now;
    const double start = std::max(now, renderer_free);
    renderer_free = start + world.draw_ms;
    const double drawn = renderer_free;
    encoder_free = std::max(encoder_free, drawn) + world.encode_ms;
    const double made = encoder_free;
    later(start - now, [&, frame, made]() mutable {
      const std::uint64_t shows = revision;  // the newest when the drawing begins
      scheduler.started(shows);
      frame.input_ms = input_of(shows);
      later(made - now, [&, frame, shows]() mutable {
        frame.bytes = frame.order.lossless ? world.lossless_bytes : jpeg_bytes(world, frame.order, kWidth);
        frame.sent_ms = now;
        const std::uint64_t id = scheduler.sent(frame.order, shows, static_cast<std::size_t>(frame.bytes), at(now));
        queue_bits += frame.bytes * 8;
        run.most_held_ms = std::max(run.most_held_ms, queue_bits / world.bits_per_second(now) * 1000);
        on_link.emplace_back(queue_bits, frame);
        on_link.back().second.order.bitrate_kbps = static_cast<int>(id);  // carries the id; nothing else reads it here
        pump();
      });
      pump();
    });
  };

  while (now < seconds * 1000) {
    if (now >= next_input && now < world.rests_at_ms) {
      inputs.emplace_back(++revision, now);
      scheduler.scene_changed(revision, true, at(now));
      next_input += 1000 / world.inputs_per_second;
      pump();
    }
    if (world.stall_every_ms > 0 && now >= next_stall) {
      stalled_until = now + world.stall_ms;
      next_stall += world.stall_every_ms;
    }
    // The bottleneck passes bits in order.
    if (queue_bits > 0 && now >= stalled_until) {
      const double passed = std::min(queue_bits, world.bits_per_second(now) * kTick / 1000);
      queue_bits -= passed;
      for (auto& [left, frame] : on_link) left -= passed;
      while (!on_link.empty() && on_link.front().first <= 1e-6) {
        SimulatedFrame frame = on_link.front().second;
        on_link.pop_front();
        const double jitter = world.jitter_ms > 0 ? std::uniform_real_distribution<double>(0, world.jitter_ms)(random) : 0;
        const double arrival = std::max(last_arrival, now + world.round_trip_ms / 2 + jitter);  // in order, as TCP has it
        last_arrival = arrival;
        later(arrival - now, [&, frame]() mutable {
          frame.arrived_ms = now;
          for (; seen < inputs.size() && inputs[seen].second <= frame.input_ms; ++seen)
            run.latency.emplace_back(inputs[seen].second, now + world.round_trip_ms / 2 - inputs[seen].second);
          const auto id = static_cast<std::uint64_t>(frame.order.bitrate_kbps);
          run.frames.push_back(frame);
          later(world.round_trip_ms / 2, [&, id] {
            scheduler.acknowledged(id, at(now));
            pump();
          });
        });
      }
    }
    for (std::size_t i = 0; i < events.size();) {
      if (events[i].at_ms > now) {
        ++i;
        continue;
      }
      const auto happen = std::move(events[i].happen);
      events.erase(events.begin() + static_cast<std::ptrdiff_t>(i));
      happen();
      i = 0;
    }
    if (const auto wake = scheduler.wake_at(at(now)); wake && *wake <= at(now)) pump();
    now += kTick;
  }
  return run;
}

}  // namespace isostrata
