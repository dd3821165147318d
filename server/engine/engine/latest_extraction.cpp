#include "engine/engine/latest_extraction.h"

#include <algorithm>
#include <utility>

#include "engine/engine/scene_view.h"
#include "engine/picture/coarse_scene.h"

namespace isostrata {
namespace {

/// Arrays, besides the one that is cut, that the scene's colours and textures run over.
std::array<std::string, 2> color_arrays(const Scene& scene) { return {scene.color_by, scene.texture}; }

}  // namespace

bool is_whole(const std::shared_ptr<const ExtractedScene>& extracted) { return extracted && extracted->point_stride == 1; }

void LatestExtraction::take(Scene scene) {
  if (!scene_ || !same_extraction(*scene_, scene)) failure_.reset();
  scene_ = std::move(scene);
}

bool LatestExtraction::coarse_suffices(bool all_coarse) const {
  return level_ > 0 && all_coarse && is_whole(ready_.extracted) && ready_.scene.dataset == scene_->dataset && ready_.scene.step == scene_->step &&
         ready_.scene.axis_scale == scene_->axis_scale &&
         can_be_coarse(*ready_.extracted, *scene_);
}

bool LatestExtraction::is_of_other_data() const {
  return running_scene_.dataset != scene_->dataset || running_scene_.array != scene_->array || running_scene_.step != scene_->step;
}

LatestExtraction::Next LatestExtraction::next(bool all_coarse) const {
  if (!scene_ || scene_->dataset.empty() || failure_) return Next::nothing;
  const bool coarse = coarse_suffices(all_coarse);  // a hand moves the layers, and asks for no more
  if (running_) {
    const bool for_nobody = coarse && !running_is_coarse_;
    if (same_extraction(running_scene_, *scene_) && !for_nobody) return Next::nothing;
    if (for_nobody || is_of_other_data()) return Next::overtake_at_once;
    // Of two in a row at most one is cut short, so that a drag over slow data still shows every other one.
    return last_was_cut_short_ ? Next::nothing : Next::overtake_after_grace;
  }
  if (ready_for(*scene_) || (coarse && coarse_for(*scene_))) return Next::nothing;
  return coarse ? Next::extract_coarse : Next::extract;
}

void LatestExtraction::begin(std::shared_ptr<Operation> operation, bool coarse) {
  running_ = std::move(operation);
  running_scene_ = *scene_;
  running_is_coarse_ = coarse;
}

const RequestFailed* LatestExtraction::end(const std::optional<RequestFailed>& failure) {
  const bool given_up = running_->superseded();
  running_.reset();
  last_was_cut_short_ = failure && given_up;
  if (!failure || given_up || !same_extraction(running_scene_, *scene_)) return nullptr;
  failure_ = failure;
  failure_->revision = scene_->revision;
  return &*failure_;
}

LatestExtraction::Extracted LatestExtraction::ready_for(const Scene& of) const {
  return is_whole(ready_.extracted) && same_extraction(ready_.scene, of) ? ready_.extracted : nullptr;
}

LatestExtraction::Extracted LatestExtraction::coarse_for(const Scene& of) const {
  return coarse_.extracted && same_extraction(coarse_.scene, of) && coarse_arrays_ == color_arrays(of) ? coarse_.extracted : nullptr;
}

void LatestExtraction::take_ready(Extracted extracted, const Scene& of) {
  news_ = !is_whole(ready_.extracted) || ready_.scene.dataset != of.dataset || ready_.scene.array != of.array;
  ready_ = {std::move(extracted), of};
  if (!coarse_for(of)) coarse_.extracted.reset();
}

bool LatestExtraction::take_news() { return std::exchange(news_, false); }

void LatestExtraction::take_first_look(Extracted extracted, const Scene& of) {
  ready_ = {std::move(extracted), of};
  coarse_.extracted.reset();
  drawn_meanwhile_.reset();
}

void LatestExtraction::take_coarse(Extracted extracted, const Scene& of) {
  if (coarse_.extracted && coarse_.scene.revision > of.revision) return;
  coarse_ = {std::move(extracted), of};
  coarse_arrays_ = color_arrays(of);
}

std::uint64_t LatestExtraction::bytes() const {
  std::uint64_t bytes = 0;
  for (const Prepared* of : {&ready_, &coarse_})
    if (of->extracted) bytes += scene_bytes(*of->extracted);
  return bytes;
}

std::array<LatestExtraction::Extracted, 2> LatestExtraction::give_back() {
  return {std::exchange(ready_.extracted, nullptr), std::exchange(coarse_.extracted, nullptr)};
}

std::optional<LatestExtraction::Shown> LatestExtraction::show(const FrameRequest& request) {
  if (!ready_.extracted || !scene_) return std::nullopt;
  const bool whole = is_whole(ready_.extracted), coarse_at_hand = coarse_for(*scene_) != nullptr;
  Prepared* of = request.coarse > 0 && coarse_at_hand ? &coarse_ : &ready_;
  Shown shown;
  if (of == &coarse_ || ready_for(*scene_)) {
    shown.scene = *scene_;
    of->scene = *scene_;
    drawn_meanwhile_.reset();
  } else {
    // The intervals of the newest scene are still being extracted. The camera need not wait for them.
    if (request.lossless || (!whole && request.still)) return std::nullopt;
    if (request.coarse > 0 && coarse_.extracted && coarse_.scene.revision > ready_.scene.revision) of = &coarse_;
    if (of->scene.dataset != scene_->dataset || of->scene.axis_scale != scene_->axis_scale) return std::nullopt;
    shown.scene = of->scene;
    take_view(shown.scene, *scene_);
    if (!whole) shown.scene.revision = std::min(shown.scene.revision, scene_->revision - 1);  // it contains none wholly: who waits goes on
    if (of->drawn && same_view(drawn_meanwhile_ ? *drawn_meanwhile_ : of->scene, shown.scene)) return std::nullopt;
    drawn_meanwhile_ = shown.scene;
  }
  shown.coarse_at_hand = coarse_at_hand || of == &coarse_;
  shown.layers_may_be_coarse = whole && can_be_coarse(*ready_.extracted, *scene_);
  shown.extracted = of->extracted;
  shown.extract_ms = of->drawn ? 0 : of->extracted->extract_ms;
  of->drawn = true;
  return shown;
}

void LatestExtraction::undo_show(Mark before) {
  drawn_meanwhile_ = std::move(before.drawn_meanwhile);
  ready_.drawn = before.ready_drawn;
}

}  // namespace isostrata
