#include "session/pacing/frames_in_making.h"

#include <algorithm>
#include <utility>

namespace isostrata {
namespace {

bool same_picture(const FrameRequest& a, const FrameRequest& b) {
  if (a.video.has_value() != b.video.has_value()) return false;
  // Whoever needs a key frame cannot do with an ordinary one; the other way round is not a loss.
  if (a.video && (a.video->stream != b.video->stream || (b.video->key && !a.video->key))) return false;
  return a.width == b.width && a.height == b.height && a.lossless == b.lossless && a.jpeg == b.jpeg &&
         a.coarse == b.coarse && a.samples == b.samples && a.jpeg_quality == b.jpeg_quality && a.band_bytes == b.band_bytes && a.until_newer == b.until_newer;
}

/// Whether who ordered `wanted` can do with the picture that is made for another's order. Moving pictures that are less than the
/// viewport deserves need not be of one's own step, nor size: else many who look over ways that differ a little would have a
/// drawing each, and all would wait for all of them.
bool does_for(const FrameRequest& made, const FrameOrder& other, const FrameRequest& wanted, const FrameOrder& order) {
  if (same_picture(made, wanted)) return true;
  const bool moving =
      order.phase == FramePhase::moving && other.phase == FramePhase::moving && made.jpeg && !made.video && !wanted.video;
  return moving && order.viewport_width == other.viewport_width && order.viewport_height == other.viewport_height &&
         other.step > 0 && order.step > 0 && other.step >= order.step - 1 && other.step <= order.step + 2;
}

FrameOrder as_made(FrameOrder order, const FrameOrder& made) {
  if (order.phase == FramePhase::moving) order.step = made.step, order.codec = made.codec;
  return order;
}

}  // namespace

bool FramesInMaking::crowded() const {
  return std::ranges::count_if(making_, [](const auto& of) { return of.second.started; }) >= kMostMaking;
}

std::optional<FramesInMaking::Kept> FramesInMaking::kept_for(const FrameRequest& wanted, const FrameOrder& order, std::uint64_t revision) const {
  for (const Done& done : kept_)
    if (done.ready.revision == revision && does_for(done.request, done.order, wanted, order)) return Kept{as_made(order, done.order), done.ready};
  return std::nullopt;
}

std::optional<FramesInMaking::Joined> FramesInMaking::join(ViewerKey viewer, const FrameRequest& wanted, const FrameOrder& order,
                                                       std::uint64_t revision) {
  for (auto& [id, making] : making_) {
    if ((making.started && making.revision != revision) || !does_for(making.request, making.order, wanted, order) ||
        making.takers.contains(viewer))
      continue;
    making.takers[viewer] = as_made(order, making.order);
    return Joined{id, making.started};
  }
  return std::nullopt;
}

void FramesInMaking::ask(RequestId id, const FrameRequest& request, const FrameOrder& order, std::uint64_t revision, ViewerKey viewer) {
  making_[id] = {request, order, revision, false, {{viewer, order}}};
}

bool FramesInMaking::leave(RequestId id, ViewerKey viewer) {
  const auto it = making_.find(id);
  if (it == making_.end()) return false;
  it->second.takers.erase(viewer);
  if (!it->second.takers.empty()) return false;
  making_.erase(it);
  return true;
}

std::vector<RequestId> FramesInMaking::leave_all(ViewerKey viewer) {
  std::vector<RequestId> unwanted;
  for (auto& [id, making] : making_)
    if (making.takers.erase(viewer) > 0 && making.takers.empty() && !making.request.video) unwanted.push_back(id);
  for (const RequestId id : unwanted) making_.erase(id);
  return unwanted;
}

const FramesInMaking::Making* FramesInMaking::start(RequestId id, std::uint64_t revision) {
  const auto it = making_.find(id);
  if (it == making_.end()) return nullptr;
  it->second.revision = std::max(it->second.revision, revision);
  it->second.started = true;
  return &it->second;
}

std::optional<FramesInMaking::Making> FramesInMaking::finish(RequestId id) {
  auto node = making_.extract(id);
  if (node.empty()) return std::nullopt;
  return std::move(node.mapped());
}

void FramesInMaking::keep(const Making& made, const FrameReady& ready, std::uint64_t revision) {
  if (ready.video || made.request.video || ready.revision != revision) return;
  kept_.push_front({made.request, made.order, ready});
  if (kept_.size() > kMostKept) kept_.pop_back();
}

}  // namespace isostrata
