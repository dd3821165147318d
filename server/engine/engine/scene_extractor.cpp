#include "engine/engine/scene_extractor.h"

#include <utility>

#include "base/work.h"

namespace isostrata {

SceneExtractor::SceneExtractor(ActivityBoard* board, SceneRanks* ranks, OpenDatasets& datasets, SharedMeshes& shared, WorkAhead& ahead, Ports ports)
    : board_(board), ranks_(ranks), datasets_(datasets), shared_(shared), ahead_(ahead), ports_(std::move(ports)) {}

void SceneExtractor::post(ExtractionJob job) {
  const SessionKey session = job.session;
  extractors_.post(session, [this, job = std::move(job)] { extract(job); });
}

RendererTraits SceneExtractor::renderer() {
  const std::lock_guard lock(mutex_);
  return renderer_;
}

void SceneExtractor::extract(const ExtractionJob& job) {
  Extracted extracted;
  std::exception_ptr failure;
  const RendererTraits renderer = this->renderer();
  try {
    const Doing extracting(board_, Stage::extracting, job.session, 0, job.operation->id());
    const Task& task = job.operation->task();
    task.check();
    const Work work(job.session, WorkClass::scene, {&task, true, extracting.waiting()});
    extracted = job.coarse ? shared_.coarse.extract_for_motion(job.before.extracted->dataset, job.scene, job.level, task, renderer.draws_bricks) : extract_all(job, renderer);
  } catch (...) {
    failure = std::current_exception();
  }
  job.operation->finish();
  if (extracted && !job.coarse) {
    ahead_.prepare_mesh(job.session, *extracted, job.scene, job.before.extracted.get(), renderer.cuts_intervals);
    if (job.before.extracted) ahead_.read_step(*extracted, job.scene, job.before.scene);
  }
  ports_.done(job, extracted, failure);
  if (extracted && job.coarse) ahead_.find_error(*extracted);
}

/// All points; if they take long to be found, every n-th point first.
SceneExtractor::Extracted SceneExtractor::extract_all(const ExtractionJob& job, const RendererTraits& renderer) {
  const Scene& scene = job.scene;
  const Prepared& before = job.before;
  const Task& task = job.operation->task();
  const CatalogueEntry source = datasets_.entry(scene.dataset);
  const StepSource steps = ranks_ ? datasets_.steps(source) : shared_.scaled_steps(datasets_.steps(source), scene.axis_scale);  // each rank scales its part
  SceneAids aids;
  aids.bricks = &shared_.bricks;
  aids.ordered = &shared_.ordered;
  aids.faces = &shared_.faces;
  aids.bases = &shared_.bases;
  leave_to(renderer, aids);
  aids.max_bytes = ports_.room_for(job.session, false);
  // With other intervals, or at another step.
  const bool shows_it = is_whole(before.extracted) && before.scene.dataset == scene.dataset && before.scene.array == scene.array &&
                        before.scene.axis_scale == scene.axis_scale;
  if (!ranks_ && !shows_it)
    if (auto first = shared_.coarse.extract(steps, scene, task, renderer.draws_bricks)) ports_.first_look(job, std::move(first));
  if (!ranks_ && before.extracted) ahead_.lay_out_played(job.session, scene, *before.extracted, before.scene, steps, task);
  const auto extract_now = [&] { return extract_by(ranks_, {source.source, source.id}, steps, scene, before.extracted, task, aids); };
  try {
    return extract_now();
  } catch (const Error& error) {
    const std::uint64_t room = error.code() == ErrorCode::too_large ? ports_.room_for(job.session, true) : 0;
    if (room <= aids.max_bytes) throw;
    aids.max_bytes = room;
    return extract_now();
  }
}

}  // namespace isostrata
