#include "engine/engine/work_ahead.h"

#include <cstdlib>
#include <exception>
#include <string>
#include <utility>

#include "base/work.h"
#include "engine/picture/without_mesh.h"
#include "extraction/surfaces/base_tetrahedra.h"

namespace isostrata {

std::optional<int> step_ahead(const Scene& scene, const Scene& before, int steps) {
  if (scene.time || before.time || scene.dataset != before.dataset || std::abs(scene.step - before.step) != 1) return std::nullopt;
  const int next = scene.step + (scene.step - before.step);
  return next >= 0 && next < steps ? std::optional(next) : std::nullopt;
}

Preparation to_prepare(const ExtractedScene& extracted, const Scene& scene, const ExtractedScene* previous, const GridFacts& facts) {
  using What = Preparation::What;
  constexpr std::uint64_t kLittle = 8;  // of the memory
  const LayerRequest& request = extracted.request;
  const bool same_steps = previous && previous->steps == extracted.steps;
  if (extracted.base || (same_steps && previous->request == request)) return {};
  const bool played = previous && !same_steps && previous->dataset && previous->dataset->grid.storage == extracted.dataset->grid.storage;
  const bool opened = !same_steps && !played;
  const bool may_be_played = opened && extracted.dataset->times.size() > 1;
  const bool waited_for = !opened && !played;  // who plays has waited for it already, if that pays
  if (const Grid& grid = extracted.dataset->grid; !only_tetrahedra(*extracted.dataset)) {
    const bool looks_for_faces = !grid.structured() && !grid.flat() && request.facets && request.values == FieldValues::interpolated && !request.time;
    const bool little = FaceMemory::foreseen_bytes(grid) <= facts.max_bytes / kLittle;
    return looks_for_faces && little && !facts.knows_faces() ? Preparation{What::faces, !opened} : Preparation{};
  }
  if (opened && base_tetrahedra_bytes(*extracted.dataset) > facts.max_bytes / kLittle) return {};
  if (!played && !may_be_played && facts.renderer_cuts && cuts_exactly(scene, extracted.array) && !facts.has_base())
    return same_steps && previous->request.intervals == request.intervals ? Preparation{} : Preparation{What::base, waited_for};
  const bool lay_out = request.terms.empty() && !request.time && !facts.knows_order();
  return lay_out ? Preparation{What::order, waited_for} : Preparation{};
}

constexpr int kStepsThatPay = 3;  // a layout takes as long as three steps save by it

WorkAhead::WorkAhead(WorkAheadOptions options, OpenDatasets& datasets, SharedMeshes& shared, Ports ports)
    : options_(options), datasets_(datasets), shared_(shared), ports_(std::move(ports)) {}

void WorkAhead::stop() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
    if (preparation_.task) preparation_.task->cancel();
  }
  ahead_task_.cancel();
}

/// One at a time. A hand that moves, or who plays, waits for it, and does not wait for what was begun for later and yields to everything: if that is the
/// layout it goes on in a hurry, else it is begun anew. Null: not now.
std::shared_ptr<Task> WorkAhead::begin_preparation(const Preparation& wanted, const Grid& grid) {
  const std::lock_guard lock(mutex_);
  if (stopping_ || (preparation_.task && (preparation_.of.waited_for || !wanted.waited_for))) return nullptr;
  const bool goes_on = preparation_.task && wanted.what == Preparation::What::order && is_being_made(wanted.what, grid);
  if (preparation_.task && !goes_on) preparation_.task->cancel();
  preparation_ = {goes_on ? preparation_.task : std::make_shared<Task>(), wanted, grid.storage};
  return preparation_.task;
}

bool WorkAhead::is_being_made(Preparation::What what, const Grid& grid) const {
  return preparation_.task && preparation_.of.what == what && preparation_.grid.lock() == grid.storage;
}

bool WorkAhead::has_order(const Grid& grid) {
  if (!shared_.ordered.knows(grid)) return false;
  const std::lock_guard lock(mutex_);
  return !is_being_made(Preparation::What::order, grid) || preparation_.of.waited_for;
}

void WorkAhead::prepare_mesh(SessionKey session, const ExtractedScene& extracted, const Scene& scene, const ExtractedScene* previous,
                             bool renderer_cuts) {
  const Preparation wanted = to_prepare(extracted, scene, previous,
                                        {renderer_cuts, options_.max_bytes, [&] { return shared_.bases.find(extracted.dataset, extracted.array) != nullptr; },
                                         [&] { return has_order(extracted.dataset->grid); }, [&] { return shared_.faces.knows(extracted.dataset->grid); }});
  prepare(session, wanted, extracted.dataset, extracted.array);
}

void WorkAhead::prepare(SessionKey session, const Preparation& wanted, const std::shared_ptr<const Dataset>& dataset, const std::string& array) {
  if (wanted.what == Preparation::What::nothing) return;
  const std::shared_ptr<Task> task = begin_preparation(wanted, dataset->grid);
  if (!task) return;
  const SessionKey of = wanted.waited_for ? session : 0;
  Lanes& lanes = wanted.waited_for ? movers_ : wanted.what == Preparation::What::order ? layouts_ : preparers_;
  lanes.post(of, [this, of, wanted, dataset, array, task] {
    const Doing extracting(options_.board, Stage::extracting, 0, 0);
    try {
      const Work work(of, wanted.waited_for ? WorkClass::scene : WorkClass::idle, {task.get(), true, extracting.waiting()});
      if (wanted.what == Preparation::What::base)
        shared_.bases.make(dataset, array, *task);
      else if (wanted.what == Preparation::What::order)
        shared_.ordered.make(dataset->grid, *task);
      else
        shared_.faces.make(dataset->grid, *task);
    } catch (const std::exception&) {  // extraction goes on without it
    }
    const std::lock_guard lock(mutex_);
    if (preparation_.task == task) preparation_ = {};
  });
}

void WorkAhead::lay_out_played(SessionKey session, const Scene& scene, const ExtractedScene& previous, const Scene& before, const StepSource& steps,
                               const Task& task) {
  const LayerRequest& request = previous.request;
  const bool cuts_mesh = previous.dataset && !previous.base && !previous.bricks && previous.parts.empty() && request.terms.empty() && !request.time;
  const int steps_of_it = cuts_mesh ? static_cast<int>(previous.dataset->times.size()) : 0;
  const auto next = step_ahead(scene, before, steps_of_it);
  const int behind_it = scene.step > before.step ? steps_of_it - 1 - scene.step : scene.step;
  if (!next || (behind_it < kStepsThatPay && !datasets_.holds(scene.dataset, *next))) return;  // what is there already is played once more
  const auto dataset = steps(scene.step, task);
  if (dataset->grid.storage != previous.dataset->grid.storage || !only_tetrahedra(*dataset)) return;
  if (!has_order(dataset->grid)) prepare(session, {Preparation::What::order, true}, dataset, previous.array);
  try {
    shared_.ordered.make(dataset->grid, task);
  } catch (const std::exception&) {  // extraction goes on without it
    task.check();
  }
}

void WorkAhead::read_step(const ExtractedScene& extracted, const Scene& scene, const Scene& before) {
  const auto next = step_ahead(scene, before, static_cast<int>(extracted.dataset->times.size()));
  if (!next || !datasets_.has_room_for(scene.dataset, *next)) return;
  ahead_.post(std::hash<std::string>()(scene.dataset), [this, dataset = scene.dataset, step = *next] {
    const Doing opening(options_.board, Stage::opening, 0, 0);
    try {
      const Work work(0, WorkClass::background, {&ahead_task_, true, opening.waiting()});
      datasets_.acquire(datasets_.entry(dataset), step, ahead_task_);
    } catch (const std::exception&) {  // who asks for it is told why
    }
  });
}

void WorkAhead::prepare_motion(SessionKey session, const Extracted& extracted, const Scene& scene, bool facets_alone) {
  if (options_.by_ranks || extracted->base || !can_be_coarse(*extracted, scene)) return;
  if (tetrahedra_of(*extracted) < options_.least_coarse_tetrahedra) return prepare_samples(session, extracted, scene);
  movers_.post(session, [this, session, extracted, scene, facets_alone] {
    if (!ports_.wants_coarse(session, extracted, scene_bytes(*extracted) / 3)) return;
    Extracted coarse;
    try {
      const Doing extracting(options_.board, Stage::extracting, 0, 0);
      // As urgent as pictures: until it is there, those of a hand that moves are made from all points, and take as long as this does.
      const Work work(session, WorkClass::frame, {&ahead_task_, true, extracting.waiting()});
      coarse = shared_.coarse.extract_for_motion(extracted->dataset, scene, 1, ahead_task_, facets_alone);
    } catch (const std::exception&) {  // a hand turns all points then
      return;
    }
    if (!coarse) return;
    find_error(*coarse);
    ports_.take_coarse(session, extracted, std::move(coarse), scene);
  });
}

void WorkAhead::prepare_samples(SessionKey session, const Extracted& extracted, const Scene& scene) {
  const Grid& grid = extracted->dataset->grid;
  if (grid.structured()) return;
  preparers_.post(0, [this, session, extracted, scene, bytes = 16 * static_cast<std::uint64_t>(grid.point_count())] {
    if (!ports_.wants_coarse(session, extracted, bytes)) return;
    try {
      const Doing extracting(options_.board, Stage::extracting, 0, 0);
      const Work work(0, WorkClass::idle, {&ahead_task_, true, extracting.waiting()});
      shared_.coarse.keep_samples(extracted->dataset, scene, ahead_task_);
    } catch (const std::exception&) {  // a hand that moves layers makes them, as it does if it is sooner
    }
  });
}

// What waits here holds no layers: a hand makes new ones at every move, in the memory of those before.
void WorkAhead::find_error(const ExtractedScene& coarse) {
  if (!coarse.coarse_error || coarse.coarse_error->get()) return;
  preparers_.post(0, [this, dataset = coarse.dataset, array = coarse.array] {
    try {
      const Doing extracting(options_.board, Stage::extracting, 0, 0);
      const Work work(0, WorkClass::idle, {&ahead_task_, true, extracting.waiting()});
      shared_.coarse.find_error(dataset, array, options_.max_bytes, ahead_task_);
    } catch (const std::exception&) {  // the pictures do without it
    }
  });
}

}  // namespace isostrata
