// A catalogue that follows what happens in its folders. A thread of its own, which gives way to others, watches them, lists what has changed, and hands out a new
// catalogue; whoever has an older one keeps it.
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "data/files/folder_watch.h"
#include "engine/data/catalogue.h"

namespace isostrata {

struct LivingOptions {
  FolderWatchOptions watch;
  std::chrono::milliseconds keep_gone{15 * 60 * 1000};  // that an entry is listed as gone
  std::size_t most_gone = 1000;
};

class LivingCatalogue {
 public:
  /// Lists them once, as Catalogue::from_sources does, and throws what that throws.
  explicit LivingCatalogue(std::vector<std::string> sources, LivingOptions options = {});
  /// As stop.
  ~LivingCatalogue();

  /// From now on `told` is called, on the thread, with each new catalogue. Call it once.
  using Told = std::function<void(std::shared_ptr<const Catalogue>)>;
  void follow(Told told);

  /// Ends the thread; nothing is told afterwards.
  void stop();

  /// The newest. Any thread.
  std::shared_ptr<const Catalogue> now() const;
  /// Whether changes are told by inotify, or by looking again and again, and why. Any thread.
  std::string how() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace isostrata
