#include "session/datasets/dataset_in_scene.h"

#include <algorithm>
#include <utility>

#include "scene/transfer_function.h"
#include "session/wire/wire.h"

namespace isostrata {
namespace {

v1::Error not_what_it_was(const DatasetFacts& facts, const char* when, const v1::Error& why) {
  return wire_error("bad_data", "dataset '" + facts.id + "' is not what it was" + when + " (" + why.message() + "); it is shown as if opened for the first time");
}

}  // namespace

ColorRange known_color_range(const Scene& drawn, const DatasetFacts* facts) {
  const ArrayFacts* array = facts ? facts->find_array(drawn.color_by.empty() ? drawn.array : drawn.color_by) : nullptr;
  return resolved(drawn.color_range, array ? array->lower : 1, array ? array->upper : 0);
}

void DatasetInScene::restore(const v1::State& kept, std::uint32_t last_interval_id) {
  state_.last_interval_id = last_interval_id;
  if (kept.dataset().empty()) {
    // Nothing but appearance; what cannot be restored is left at its default.
    restore_state(state_, kept, last_interval_id, {});
  } else {
    asleep_ = kept;
    state_.scene.dataset = kept.dataset();
  }
  state_.scene.revision = std::max<std::uint64_t>(kept.revision(), 1);
}

DatasetInScene::Shown DatasetInScene::show(const DatasetFacts& facts, bool reload, double aspect, bool incomplete) {
  first_look_.reset();
  if (reload) return show_again(facts, aspect);
  if (asleep_ && asleep_->dataset() == facts.id) return wake(facts);
  asleep_.reset();
  return show_first(facts, aspect, incomplete);
}

DatasetInScene::Shown DatasetInScene::show_first(const DatasetFacts& facts, double aspect, bool incomplete) {
  open_in_scene(state_, facts, aspect);
  if (incomplete) first_look_ = state_.scene;
  return {.changed = true};
}

DatasetInScene::Shown DatasetInScene::show_again(const DatasetFacts& facts, double aspect) {
  v1::State saved = to_wire(state_.scene);
  const auto steps = static_cast<std::int32_t>(facts.times.size());
  saved.set_step(std::clamp(saved.step(), 0, std::max(steps - 1, 0)));
  if (saved.has_time() && (facts.times.empty() || saved.time() < facts.times.front() || saved.time() > facts.times.back())) saved.clear_time();
  const std::uint64_t revision = state_.scene.revision;
  Shown shown{.changed = true};
  if (const auto error = restore_state(state_, saved, state_.last_interval_id, {&facts, 1})) {
    open_in_scene(state_, facts, aspect);
    shown.error = not_what_it_was(facts, "", *error);
  }
  state_.scene.revision = revision + 1;
  return shown;
}

DatasetInScene::Shown DatasetInScene::wake(const DatasetFacts& facts) {
  const v1::State saved = *std::exchange(asleep_, std::nullopt);
  const auto error = restore_state(state_, saved, state_.last_interval_id, {&facts, 1});
  if (!error) return {.woken = true};
  // Another file under the same name.
  open_in_scene(state_, facts);
  return {.woken = true, .changed = true, .error = not_what_it_was(facts, " when this session was kept", *error)};
}

bool DatasetInScene::ranges_read(const DatasetFacts* before, const DatasetFacts& facts) {
  const std::optional<Scene> first_look = std::exchange(first_look_, std::nullopt);
  if (!before) return false;
  // Layers that nobody has touched were chosen by what was known then.
  if (first_look && first_look->array == state_.scene.array && first_look->intervals == state_.scene.intervals && show_first_layers(state_, facts))
    return true;
  const Scene drawn = drawn_scene(state_.scene);
  if (known_color_range(drawn, &facts) == known_color_range(drawn, before)) return false;
  ++state_.scene.revision;
  return true;
}

}  // namespace isostrata
