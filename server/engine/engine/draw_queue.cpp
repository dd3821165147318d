#include "engine/engine/draw_queue.h"

namespace isostrata {

bool DrawQueue::all_coarse() const {
  return std::all_of(waiting_.begin(), waiting_.end(), [](const FrameRequest& of) { return of.coarse > 0; });
}

std::optional<PictureOrder> DrawQueue::next(LatestExtraction& of, std::optional<PictureKind> kind) {
  for (auto request = waiting_.begin(); request != waiting_.end(); ++request) {
    if (kind && kind_of(*request) != *kind) continue;
    auto shown = of.show(*request);
    if (!shown) continue;
    PictureOrder order;
    order.request = std::move(*request);
    waiting_.erase(request);
    order.scene = std::move(shown->scene);
    order.extracted = std::move(shown->extracted);
    order.extract_ms = shown->extract_ms;
    order.task = std::make_shared<Task>();
    if (!is_still(order.request)) order.legend_place = legend_place_;
    order.coarse_at_hand = shown->coarse_at_hand;
    order.layers_may_be_coarse = shown->layers_may_be_coarse;
    begun_[order.request.request] = {order.task, order.scene.revision, order.request.until_newer};
    return order;
  }
  return std::nullopt;
}

void DrawQueue::put_back(const PictureOrder& order) {
  waiting_.push_front(order.request);
  begun_.erase(order.request.request);
}

void DrawQueue::forget(RequestId request) {
  std::erase_if(waiting_, [&](const FrameRequest& of) { return of.request == request; });
  if (const auto begun = begun_.find(request); begun != begun_.end()) begun->second.task->cancel();
}

void DrawQueue::cancel_older(std::uint64_t revision) {
  for (auto& [request, begun] : begun_)
    if (begun.until_newer && begun.revision < revision) begun.task->cancel();
}

void DrawQueue::cancel_all() {
  for (auto& [request, begun] : begun_) begun.task->cancel();
}

bool DrawQueue::take_lane(PictureKind kind) {
  if (lane_taken(kind) || std::none_of(waiting_.begin(), waiting_.end(), [&](const FrameRequest& of) { return kind_of(of) == kind; })) return false;
  return lane_taken(kind) = true;
}

}  // namespace isostrata
