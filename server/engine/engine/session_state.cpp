#include "engine/engine/session_state.h"

#include <algorithm>
#include <utility>

#include "engine/picture/coarse_scene.h"

namespace isostrata {
namespace {

// The parts of a scene that a picture of older intervals can still follow. A smear's mesh is another one, so its mode stays with
// what was extracted.
void take_view(Scene& of, const Scene& from) {
  of.camera = from.camera;
  of.background = from.background;
  if ((of.mode == SceneMode::smear) == (from.mode == SceneMode::smear)) of.mode = from.mode;
  of.integral = from.integral;
  of.cycle = from.cycle;
  of.unit_distance = from.unit_distance;
  of.clip_planes = from.clip_planes;
  of.annotations = from.annotations;
  of.color_range = from.color_range;
  of.light = from.light;
}

bool same_view(const Scene& a, const Scene& b) {
  return a.camera == b.camera && a.background == b.background && a.mode == b.mode && a.integral == b.integral &&
         a.cycle.phase == b.cycle.phase && a.unit_distance == b.unit_distance && a.clip_planes == b.clip_planes &&
         a.annotations == b.annotations && a.color_range == b.color_range && a.light == b.light;
}

}  // namespace

bool is_whole(const std::shared_ptr<const ExtractedScene>& extracted) { return extracted && extracted->point_stride == 1; }

std::array<std::string, 2> color_arrays(const Scene& scene) { return {scene.color_by, scene.texture}; }

std::shared_ptr<const ExtractedScene> SessionState::ready_for(const Scene& of) const {
  return is_whole(ready.extracted) && same_extraction(ready.scene, of) ? ready.extracted : nullptr;
}

std::shared_ptr<const ExtractedScene> SessionState::coarse_for(const Scene& of) const {
  return coarse.extracted && same_extraction(coarse.scene, of) && coarse_arrays == color_arrays(of) ? coarse.extracted : nullptr;
}

void SessionState::take_coarse(std::shared_ptr<const ExtractedScene> extracted, const Scene& of) {
  if (coarse.extracted && coarse.scene.revision > of.revision) return;
  coarse = {std::move(extracted), of};
  coarse_arrays = color_arrays(of);
}

bool SessionState::coarse_suffices() const {
  return asks_coarse > 0 && std::all_of(waiting.begin(), waiting.end(), [](const FrameRequest& f) { return f.coarse > 0; }) && is_whole(ready.extracted) &&
         ready.scene.dataset == scene->dataset && ready.scene.step == scene->step && can_be_coarse(*ready.extracted, *scene);
}

void SessionState::give_back() {
  ready.extracted.reset();
  coarse.extracted.reset();
}

std::optional<PictureOrder> SessionState::next_order(const std::function<bool(const FrameRequest&)>& fits) {
  if (!ready.extracted || !scene) return std::nullopt;
  for (auto request = waiting.begin(); request != waiting.end(); ++request) {
    if (!fits(*request)) continue;
    auto order = order_of(*request);
    if (!order) continue;
    waiting.erase(request);
    pictures[order->request.request] = {order->task, order->scene.revision, order->request.until_newer};
    return order;
  }
  return std::nullopt;
}

std::optional<PictureOrder> SessionState::order_of(const FrameRequest& request) {
  const bool whole = is_whole(ready.extracted), coarse_at_hand = coarse_for(*scene) != nullptr;
  Prepared* of = request.coarse > 0 && coarse_at_hand ? &coarse : &ready;
  PictureOrder order;
  if (of == &coarse || ready_for(*scene)) {
    order.scene = *scene;
    of->scene = *scene;
    drawn_meanwhile.reset();
  } else {
    // The intervals of the newest scene are still being extracted. The camera need not wait for them.
    if (request.lossless || (!whole && is_still(request))) return std::nullopt;
    if (request.coarse > 0 && coarse.extracted && coarse.scene.revision > ready.scene.revision) of = &coarse;
    if (of->scene.dataset != scene->dataset) return std::nullopt;
    order.scene = of->scene;
    take_view(order.scene, *scene);
    if (!whole) order.scene.revision = std::min(order.scene.revision, scene->revision - 1);  // it contains none wholly: who waits goes on
    if (of->drawn && same_view(drawn_meanwhile ? *drawn_meanwhile : of->scene, order.scene)) return std::nullopt;
    drawn_meanwhile = order.scene;
  }
  order.request = request;
  order.task = std::make_shared<Task>();
  order.coarse_at_hand = coarse_at_hand || of == &coarse;
  order.extracted = of->extracted;
  order.extract_ms = of->drawn ? 0 : of->extracted->extract_ms;
  of->drawn = true;
  return order;
}

}  // namespace isostrata
