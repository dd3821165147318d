#include "engine/messages/activity.h"

namespace isostrata {
namespace {

constexpr auto kRelaxed = std::memory_order_relaxed;

std::uint32_t number(Stage stage) { return static_cast<std::uint32_t>(stage); }

}  // namespace

std::string to_string(Stage stage) {
  switch (stage) {
    case Stage::idle:
      return "idle";
    case Stage::starting:
      return "starting";
    case Stage::opening:
      return "reading data";
    case Stage::extracting:
      return "extracting";
    case Stage::drawing:
      return "drawing";
    case Stage::encoding:
      return "encoding";
  }
  return "idle";
}

Activity* Doing::take(ActivityBoard* board, Stage stage) {
  if (!board) return nullptr;
  for (std::size_t i = ActivityBoard::kRenderThread + 1; i < board->slots.size(); ++i) {
    std::uint32_t idle = number(Stage::idle);
    if (board->slots[i].stage.compare_exchange_strong(idle, number(stage), kRelaxed)) return &board->slots[i];
  }
  return nullptr;
}

Doing::Doing(ActivityBoard* board, Stage stage, std::uint64_t session, std::uint64_t request, std::uint64_t operation,
             std::uint32_t patience)
    : slot_(take(board, stage)), scope_(slot_ ? &slot_->pulse : nullptr) {
  if (!slot_) return;
  slot_->session.store(session, kRelaxed);
  slot_->request.store(request, kRelaxed);
  slot_->operation.store(operation, kRelaxed);
  slot_->patience.store(patience, kRelaxed);
  pulse();
}

Doing::Doing(OnRenderThread, ActivityBoard* board, Stage stage, std::uint64_t session, std::uint64_t request,
             std::uint32_t patience)
    : slot_(board ? &board->slots[ActivityBoard::kRenderThread] : nullptr), scope_(slot_ ? &slot_->pulse : nullptr) {
  if (!slot_) return;
  slot_->session.store(session, kRelaxed);
  slot_->request.store(request, kRelaxed);
  slot_->patience.store(patience, kRelaxed);
  slot_->stage.store(number(stage), kRelaxed);
  pulse();
}

Doing::~Doing() {
  if (!slot_) return;
  pulse();
  slot_->patience.store(1, kRelaxed);
  slot_->stage.store(number(Stage::idle), std::memory_order_release);
}

std::vector<ActivityFacts> read(const ActivityBoard& board) {
  std::vector<ActivityFacts> facts;
  for (std::size_t i = 0; i < board.slots.size(); ++i) {
    const Activity& of = board.slots[i];
    const std::uint32_t stage = of.stage.load(std::memory_order_acquire);
    const bool known = stage <= number(Stage::encoding);
    if (i != ActivityBoard::kRenderThread && (!known || stage == number(Stage::idle))) continue;
    facts.push_back({i, known ? static_cast<Stage>(stage) : Stage::idle, of.patience.load(kRelaxed), of.session.load(kRelaxed),
                     of.request.load(kRelaxed), of.operation.load(kRelaxed), of.pulse.load(kRelaxed),
                     of.waiting.load(kRelaxed) > 0});
  }
  return facts;
}

}  // namespace isostrata
