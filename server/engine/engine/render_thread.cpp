#include "engine/engine/render_thread.h"

#include <exception>
#include <utility>

namespace isostrata {
namespace {

constexpr auto kIdlePulse = std::chrono::milliseconds(200);

}  // namespace

bool DeviceFailures::note(const std::optional<std::string>& failure) {
  in_a_row_ = failure ? in_a_row_ + 1 : 0;
  last_ = failure.value_or("");
  return in_a_row_ >= kMost;
}

std::string DeviceFailures::instead_of(const std::string& device) const {
  return " in place of " + device + ", which failed " + std::to_string(in_a_row_) + " frames in a row, the last with: " + last_;
}

RenderThread::RenderThread(Make make, Make fallback, ActivityBoard* board, Ports ports)
    : fallback_(std::move(fallback)), board_(board), ports_(std::move(ports)) {
  std::promise<std::string> started;
  auto device = started.get_future();
  thread_ = std::thread([this, make = std::move(make), &started] { run(make, started); });
  try {
    device_ = device.get();
  } catch (...) {
    thread_.join();
    throw;
  }
}

RenderThread::~RenderThread() { thread_.join(); }

void RenderThread::run(const Make& make, std::promise<std::string>& started) {
  std::unique_ptr<Renderer> renderer;
  try {
    const Doing starting(Doing::OnRenderThread{}, board_, Stage::starting, 0, 0, 1);
    renderer = make();
    ports_.take(*renderer, make, "");
    started.set_value(renderer->device());
  } catch (...) {
    started.set_exception(std::current_exception());
    return;
  }
  draw_all(std::move(renderer));
}

/// Between its slices others' frames have up to three quarters of the time, and one of them at least.
std::optional<std::string> RenderThread::draw(Renderer& renderer, PictureOrder order, const std::string& instead) {
  constexpr double kOthers = 3;
  std::optional<std::string> failure;
  Stopwatch slice;
  const auto between = [&, of = order.request] {
    const double longest_ms = kOthers * slice.elapsed_ms();
    for (const Stopwatch others; !failure && others.elapsed_ms() < longest_ms;) {
      auto frame = ports_.next_between(of);
      if (!frame) break;
      failure = ports_.draw(renderer, std::move(*frame), instead, {});
    }
    slice = {};
  };
  auto own = ports_.draw(renderer, std::move(order), instead, between);
  return own ? own : failure;
}

void RenderThread::draw_all(std::unique_ptr<Renderer> renderer) {
  DeviceFailures failures;
  std::string instead;  // what is drawn by, and why; empty: what was asked for
  for (;;) {
    std::optional<PictureOrder> order;
    const Ports::Turn turn = ports_.wait(kIdlePulse, order);
    if (turn == Ports::Turn::end) return;
    if (turn == Ports::Turn::idle) {
      if (board_) ++board_->slots[ActivityBoard::kRenderThread].pulse;
      continue;
    }
    const bool too_often = failures.note(draw(*renderer, std::move(*order), instead));
    if (!too_often || !instead.empty()) continue;
    try {
      auto replacement = fallback_();
      instead = failures.instead_of(renderer->device());
      renderer = std::move(replacement);
    } catch (const std::exception&) {
      failures.forget();  // go on as before; each frame says why it fails
      continue;
    }
    ports_.take(*renderer, fallback_, instead);
  }
}

}  // namespace isostrata
