#include "drag.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <condition_variable>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <numbers>
#include <thread>

#include "isostrata/scene.h"
#include "isostrata/video.h"

namespace isostrata::client {
namespace {

using Steady = std::chrono::steady_clock;

double now_ms() { return std::chrono::duration<double, std::milli>(Steady::now().time_since_epoch()).count(); }

/// The i-th of n inputs.
v1::ClientMessage input(const DragArguments& arguments, const v1::State& start, double since_ms, std::size_t i) {
  v1::ClientMessage message;
  if (arguments.camera) {
    *message.mutable_set_camera()->mutable_camera() =
        turned(start.camera(), arguments.degrees_per_input * static_cast<double>(i + 1), 0);
    return message;
  }
  // Down to 80 % of the interval's width and back, once in two seconds.
  const v1::Interval& dragged = start.intervals(0);
  const double width = (dragged.upper() - dragged.lower()) * (0.9 + 0.1 * std::cos(std::numbers::pi * since_ms / 1000));
  message.mutable_patch_interval()->set_id(dragged.id());
  message.mutable_patch_interval()->set_upper(dragged.lower() + width);
  return message;
}

v1::ClientMessage last_input(const DragArguments& arguments, const v1::State& start) {
  v1::ClientMessage message;
  if (arguments.camera) {
    *message.mutable_set_camera()->mutable_camera() = start.camera();
  } else {
    message.mutable_patch_interval()->set_id(start.intervals(0).id());
    message.mutable_patch_interval()->set_upper(start.intervals(0).upper());
  }
  return message;
}

std::string forecasts_of(const v1::Frame& frame) {
  std::string text;
  for (const v1::FormatForecast& of : frame.forecasts())
    text += (text.empty() ? "" : " ") + of.format() + " " + std::to_string(std::lround(10 * of.ms()) / 10.0).substr(0, 5);
  return text;
}

v1::ClientMessage interaction(bool active) {
  v1::ClientMessage message;
  message.mutable_interaction()->set_active(active);
  return message;
}

/// Others who look at the same session. Which input a frame of theirs shows is told by its camera.
class Audience {
 public:
  Audience(const Client& client, const Options& options, const DragArguments& arguments) {
    Options joining = options;
    joining.resume_token = client.welcome().resume_token();
    for (int i = 0; i < arguments.silent; ++i) silent_.push_back(std::make_unique<Client>(joining));
    for (int i = 0; i < arguments.viewers; ++i) watching_.push_back(std::make_unique<Client>(joining));
    for (auto& viewer : watching_) threads_.emplace_back([this, &viewer] { watch(*viewer); });
    // Their coming, each with the whole state and a lossless picture, is not what is measured.
    std::unique_lock lock(mutex_);
    seated_.wait_for(lock, kToSit, [&] { return have_a_picture_ == watching_.size(); });
  }
  ~Audience() { end(); }

  void note(const v1::Camera& camera, double at_ms) {
    std::lock_guard lock(mutex_);
    sent_[key(camera)] = at_ms;
  }
  void end() {
    ended_ = true;
    for (std::thread& thread : threads_) thread.join();
    threads_.clear();
  }
  /// After end().
  std::vector<double> take_latency() { return std::move(latency_ms_); }
  std::size_t frames() const { return frames_; }

 private:
  static constexpr std::chrono::seconds kToSit{10};
  static std::array<double, 3> key(const v1::Camera& camera) { return {camera.eye().x(), camera.eye().y(), camera.eye().z()}; }

  void watch(Client& viewer) {
    std::vector<double> mine;
    std::size_t frames = 0;
    try {
      while (!ended_) {
        const auto message = viewer.receive(std::chrono::milliseconds(50));
        if (!message || !message->has_frame()) continue;
        const double arrived = now_ms();
        ++frames;
        std::lock_guard lock(mutex_);
        if (frames == 1 && ++have_a_picture_ == watching_.size()) seated_.notify_one();
        if (const auto it = sent_.find(key(message->frame().camera())); it != sent_.end()) mine.push_back(arrived - it->second);
      }
    } catch (const ClientError&) {
      // Its connection has ended; what it saw counts.
    }
    std::lock_guard lock(mutex_);
    latency_ms_.insert(latency_ms_.end(), mine.begin(), mine.end());
    frames_ += frames;
  }

  std::vector<std::unique_ptr<Client>> silent_, watching_;
  std::vector<std::thread> threads_;
  std::atomic<bool> ended_{false};
  std::mutex mutex_;  // guards what follows
  std::condition_variable seated_;
  std::size_t have_a_picture_ = 0;
  std::map<std::array<double, 3>, double> sent_;
  std::vector<double> latency_ms_;
  std::size_t frames_ = 0;
};

void throw_error(const v1::ServerMessage& message) {
  if (message.has_error()) throw ClientError(message.error().code(), message.error().message());
}

/// Waits for the lossless frame that contains the message `seq`.
void rest(Client& client, FrameDecoder& decoder, std::uint64_t seq, double since_ms, std::chrono::milliseconds timeout,
          Dragged& dragged) {
  const double give_up = now_ms() + static_cast<double>(timeout.count());
  while (now_ms() < give_up) {
    const auto message = client.receive(std::chrono::milliseconds(50));
    if (!message) continue;
    throw_error(*message);
    if (!message->has_frame()) continue;
    const v1::Frame& frame = message->frame();
    std::optional<Picture> picture = client.decode_frame(decoder, frame);
    if (!picture || frame.input_seq() < seq) continue;
    if (frame.phase() == v1::FRAME_PHASE_SETTLED && dragged.rest_to_settled_ms == 0)
      dragged.rest_to_settled_ms = now_ms() - since_ms;
    if (frame.phase() != v1::FRAME_PHASE_LOSSLESS) continue;
    dragged.rest_to_lossless_ms = now_ms() - since_ms;
    dragged.lossless_bytes = static_cast<double>(frame.payload().size());
    dragged.lossless = std::move(*picture);
    return;
  }
  throw ClientError("timeout", "no lossless frame came after the drag");
}

}  // namespace

Dragged drag(Client& client, const Options& options, const DragArguments& arguments) {
  const v1::State start = client.state();
  FrameDecoder decoder(video_decoder);
  Dragged dragged;
  dragged.seconds = arguments.seconds;
  Audience audience(client, options, arguments);
  client.send(interaction(true));

  struct Input {
    std::uint64_t seq;
    double at_ms;
  };
  std::deque<Input> inputs;
  double newest_shown_ms = 0;
  const double period = 1000 / arguments.inputs_per_second;
  const double began = dragged.began_at_ms = now_ms(), end = began + arguments.seconds * 1000, give_up = end + 10000;
  for (double next = began;;) {
    const double now = now_ms();
    if (now < end && now >= next) {
      v1::ClientMessage message = input(arguments, start, now - began, dragged.inputs);
      if (message.has_set_camera()) audience.note(message.set_camera().camera(), now);
      inputs.push_back({client.send(std::move(message)), now});
      ++dragged.inputs;
      next = std::max(next + period, now);
    }
    if (now >= end && (inputs.empty() || now >= give_up)) break;
    const double wait = now < end ? next - now : 50;
    const auto message = client.receive(std::chrono::milliseconds(static_cast<long>(std::clamp(std::ceil(wait), 0.0, 50.0))));
    if (!message) continue;
    throw_error(*message);
    if (!message->has_frame()) continue;
    const v1::Frame& frame = message->frame();
    const double arrived = now_ms();
    if (!client.decode_frame(decoder, frame)) continue;
    const double decoded = now_ms();
    for (; !inputs.empty() && inputs.front().seq <= frame.input_seq(); inputs.pop_front()) {
      newest_shown_ms = inputs.front().at_ms;
      dragged.latency.push_back({inputs.front().at_ms, decoded - inputs.front().at_ms});
    }
    dragged.tetrahedra = std::max<std::int64_t>(dragged.tetrahedra, frame.facts().tetrahedra());
    dragged.device = frame.facts().device();
    if (arrived > end || newest_shown_ms == 0) continue;  // before the first input is shown there is nothing to be late
    const v1::StageTimes& stages = frame.stages();
    dragged.frames.push_back({decoded, newest_shown_ms, static_cast<double>(frame.payload().size()), decoded - arrived,
                              stages.extract_ms(), stages.order_ms() + stages.draw_ms() + stages.readback_ms(),
                              stages.encode_ms(), static_cast<int>(frame.width()), static_cast<int>(frame.height()),
                              frame.format(), forecasts_of(frame)});
  }
  audience.end();
  dragged.viewers_latency_ms = audience.take_latency();
  dragged.viewers_frames = audience.frames();

  const double last_at = now_ms();
  const std::uint64_t last = client.send(last_input(arguments, start));
  client.send(interaction(false));
  rest(client, decoder, last, last_at, options.timeout, dragged);
  return dragged;
}

}  // namespace isostrata::client
