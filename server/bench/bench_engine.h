// For measurements of what a session waits for: an engine in this process, asked as a session asks it.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <string>

#include "data/open/import_cache.h"
#include "engine/engine/engine.h"

namespace isostrata {

class BenchEngine {
 public:
  /// data: a file or the name of analytic data. Throws what Catalogue::from_sources and Engine throw.
  explicit BenchEngine(const std::string& data);

  /// What a session is told when it opens the data. Throws what the engine answers in place of it.
  DatasetFacts open();
  /// The first picture of the scene that comes after this call, as a moving frame (JPEG). before: gets each that comes earlier, of what was there or of
  /// some of the points.
  FrameReady picture(Scene scene, int width, int height, const std::function<void(const FrameReady&)>& before = {});
  /// What a session of this dataset begins with. Throws not_found if there is nothing to show.
  Scene first_scene(const DatasetFacts& facts, double aspect) const;

 private:
  EngineEvent wait_for(RequestId request);

  std::mutex mutex_;  // guards `events_`
  std::condition_variable changed_;
  std::deque<EngineEvent> events_;
  std::string dataset_;
  RequestId next_ = 1;
  std::uint64_t revision_ = 0;
  std::unique_ptr<Engine> engine_;  // destroyed first
};

/// While it lives, this process imports into a cache of its own in a new folder, and the environment's temporary folder is beside it.
class ScratchCache {
 public:
  ScratchCache();
  ~ScratchCache();
  ScratchCache(const ScratchCache&) = delete;
  ScratchCache& operator=(const ScratchCache&) = delete;
  /// In both.
  std::uint64_t bytes() const;

 private:
  std::filesystem::path folder_;
  std::optional<ImportCache> before_;
  std::string temporary_before_;
  bool had_temporary_ = false;
};

/// Memory of this process that is not a file's, after what is free was given back.
std::uint64_t resident_bytes();

/// Bytes of a file, a folder, or all files of a series; 0 of analytic data.
std::uint64_t source_bytes(const std::string& data);

}  // namespace isostrata
