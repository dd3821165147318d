#include "engine/engine/session_state.h"

#include <algorithm>

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
}

bool same_view(const Scene& a, const Scene& b) {
  return a.camera == b.camera && a.background == b.background && a.mode == b.mode && a.integral == b.integral &&
         a.cycle.phase == b.cycle.phase && a.unit_distance == b.unit_distance && a.clip_planes == b.clip_planes &&
         a.annotations == b.annotations && a.color_range == b.color_range;
}

}  // namespace

bool is_whole(const std::shared_ptr<const ExtractedScene>& extracted) { return extracted && extracted->point_stride == 1; }

std::array<std::string, 2> color_arrays(const Scene& scene) { return {scene.color_by, scene.texture}; }

std::shared_ptr<const ExtractedScene> SessionState::ready_for(const Scene& of) const {
  return is_whole(ready) && same_extraction(ready_scene, of) ? ready : nullptr;
}

std::optional<PictureOrder> SessionState::next_order(const std::function<bool(const FrameRequest&)>& fits) {
  if (!ready || !scene) return std::nullopt;
  const bool whole = is_whole(ready), newest = whole && same_extraction(ready_scene, *scene);
  PictureOrder order;
  const auto request = std::find_if(waiting.begin(), waiting.end(), [&](const FrameRequest& f) {
    return fits(f) && (newest || !f.lossless) && (whole || !is_still(f));
  });
  if (request == waiting.end()) return std::nullopt;
  if (newest) {
    order.scene = *scene;
    ready_scene = *scene;
    drawn_meanwhile.reset();
  } else {
    // The intervals of the newest scene are still being extracted. The camera need not wait for them.
    if (ready_scene.dataset != scene->dataset) return std::nullopt;
    order.scene = ready_scene;
    take_view(order.scene, *scene);
    if (!whole) order.scene.revision = std::min(order.scene.revision, scene->revision - 1);  // it contains none wholly: who waits goes on
    const bool seen = ready_drawn && drawn_meanwhile
                          ? same_view(*drawn_meanwhile, order.scene)
                          : ready_drawn && same_view(ready_scene, order.scene);
    if (seen) return std::nullopt;
    drawn_meanwhile = order.scene;
  }
  order.request = *request;
  waiting.erase(request);
  order.task = std::make_shared<Task>();
  pictures[order.request.request] = {order.task, order.scene.revision, order.request.band_bytes > 0};
  order.coarse_at_hand = newest && ready_coarse && coarse_arrays == color_arrays(order.scene);
  order.extracted = order.coarse_at_hand && order.request.coarse ? ready_coarse : ready;
  order.extract_ms = ready_drawn ? 0 : ready->extract_ms;
  ready_drawn = true;
  return order;
}

}  // namespace isostrata
