#include "bench/bench_engine.h"

#include <malloc.h>
#include <stdlib.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>

#include "base/kept_blocks.h"
#include "bench/bench_sums.h"
#include "data/files/file_series.h"
#include "engine/first/first_scene.h"
#include "main/arguments.h"
#include "session/wire/random_token.h"

namespace isostrata {

namespace fs = std::filesystem;

BenchEngine::BenchEngine(const std::string& data) {
  EngineOptions options;
  options.catalogue = Catalogue::from_sources({data});
  options.renderer_choice = {"native", "auto"};
  if (options.catalogue.entries().empty()) throw Error(ErrorCode::not_found, data + ": nothing to open");
  dataset_ = options.catalogue.entries().front().id;
  engine_ = std::make_unique<Engine>(std::move(options), [this](EngineEvent event) {
    const std::lock_guard lock(mutex_);
    events_.push_back(std::move(event));
    changed_.notify_all();
  });
}

EngineEvent BenchEngine::wait_for(RequestId request) {
  std::unique_lock lock(mutex_);
  for (;;) {
    while (events_.empty()) {
      changed_.wait_for(lock, std::chrono::milliseconds(50));
      command_task().check();
    }
    EngineEvent event = std::move(events_.front());
    events_.pop_front();
    if (const auto* failed = std::get_if<RequestFailed>(&event); failed && (failed->request == request || failed->request == 0))
      throw Error(failed->code, failed->message);
    const bool answer = std::holds_alternative<DatasetReady>(event) || std::holds_alternative<FrameReady>(event);
    if (answer && request_of(event) == request) return event;
  }
}

DatasetFacts BenchEngine::open() {
  const RequestId request = next_++;
  engine_->post(OpenRequest{1, request, dataset_});
  return std::get<DatasetReady>(wait_for(request)).facts;
}

FrameReady BenchEngine::picture(Scene scene, int width, int height, const std::function<void(const FrameReady&)>& before) {
  scene.dataset = dataset_;
  scene.revision = ++revision_;
  engine_->post(SceneUpdate{1, std::move(scene)});
  for (;;) {
    FrameRequest request;
    request.session = 1;
    request.request = next_++;
    request.width = width;
    request.height = height;
    engine_->post(request);
    FrameReady frame = std::get<FrameReady>(wait_for(request.request));
    if (frame.revision == revision_) return frame;
    if (before) before(frame);
  }
}

Scene BenchEngine::first_scene(const DatasetFacts& facts, double aspect) const {
  if (facts.first_view.array.empty()) throw Error(ErrorCode::not_found, facts.name + ": nothing to show: " + facts.first_view.array_reason);
  return isostrata::first_scene(facts.first_view, aspect);
}

ScratchCache::ScratchCache() : folder_(fs::temp_directory_path() / ("isostrata-bench-" + random_token(64))), before_(import_cache()) {
  fs::create_directories(folder_ / "tmp");
  if (const char* temporary = std::getenv("TMPDIR")) temporary_before_ = temporary, had_temporary_ = true;
  setenv("TMPDIR", (folder_ / "tmp").c_str(), 1);
  ImportCache cache;
  cache.folder = folder_ / "cache";
  cache.max_bytes = std::uint64_t{1} << 40;
  cache.least_seconds = 0;
  set_import_cache(cache);
}

ScratchCache::~ScratchCache() {
  set_import_cache(before_);
  had_temporary_ ? setenv("TMPDIR", temporary_before_.c_str(), 1) : unsetenv("TMPDIR");
  std::error_code ignored;
  fs::remove_all(folder_, ignored);
}

std::uint64_t ScratchCache::bytes() const {
  std::uint64_t sum = 0;
  std::error_code error;
  for (fs::recursive_directory_iterator it(folder_, error), end; !error && it != end; it.increment(error))
    if (it->is_regular_file(error)) sum += it->file_size(error);
  return sum;
}

std::uint64_t resident_bytes() {
  free_kept_blocks();
  malloc_trim(0);
  return anonymous_bytes(getpid());
}

std::uint64_t source_bytes(const std::string& data) {
  std::error_code error;
  if (is_series_pattern(data)) {
    std::uint64_t sum = 0;
    for (const SeriesFile& file : series_files(data)) sum += fs::file_size(file.path, error);
    return sum;
  }
  const auto size = fs::file_size(data, error);
  return error ? 0 : size;
}

}  // namespace isostrata
