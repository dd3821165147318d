// Which folders have changed since somebody last asked: by inotify, and by looking again and again where inotify says nothing (file systems of other machines) or
// has no more watches to give.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <map>
#include <set>
#include <string>

#include "data/files/look_at_folder.h"

namespace isostrata {

struct FolderWatchOptions {
  bool inotify = true;              // false: everything is looked at again and again
  std::size_t most_watches = 4096;  // of this process; the user's other programs need some, too
  std::chrono::milliseconds poll{1000};    // between two looks at folders without a watch; ten times as long as a look takes, if that is more
  std::chrono::milliseconds quiet{1000};   // a file that was written to and not closed is complete once nobody has written to it for so long
  std::chrono::milliseconds renew{2000};   // a file that is written to all the time is told of so often
  std::chrono::milliseconds gather{50};    // after the first news, for more of the same
};

/// One thread uses it; any thread may call stop.
class FolderWatch {
 public:
  explicit FolderWatch(FolderWatchOptions options = {});
  ~FolderWatch();
  FolderWatch(const FolderWatch&) = delete;
  FolderWatch& operator=(const FolderWatch&) = delete;

  /// From now on these folders, real paths, and no others. Those that were not watched before: what happened to them until now is not told, so look at them again.
  /// lone: folders of which a few files count, and which are not looked at for others; if they have no watch they are told of at every look.
  std::set<std::filesystem::path> watch(const std::set<std::filesystem::path>& folders, const std::set<std::filesystem::path>& lone = {});

  struct News {
    std::set<std::filesystem::path> folders;
    bool everything = false;  // too much has happened to say what
    bool empty() const { return folders.empty() && !everything; }
  };
  /// Waits so long for news, or until stop.
  News wait(std::chrono::milliseconds at_most);
  void stop();

  /// Files that are being written now.
  std::set<std::string> writing() const;
  /// "inotify", or why and where folders are looked at instead.
  std::string how() const;

 private:
  using Clock = std::chrono::steady_clock;
  struct Writing {
    Clock::time_point last{};  // somebody wrote
    Clock::time_point told{};
    bool polled = false;  // complete at the first look that finds it as it was
  };
  struct Polled {
    bool lone = false;
    bool there = true;
    std::map<std::string, FileStamp> files;  // and folders
  };

  bool add_watch(const std::filesystem::path& folder);
  void remove_watch(const std::filesystem::path& folder);
  void read_events(News& news);
  void settle(News& news);
  void poll_folders(News& news);
  void poll_folder(const std::filesystem::path& folder, Polled& polled, News& news);
  void note_written(const std::filesystem::path& folder, const std::string& name, News& news);
  Clock::time_point next_due() const;

  const FolderWatchOptions options_;
  int inotify_ = -1, stop_ = -1;
  std::string without_inotify_;  // why
  std::map<int, std::filesystem::path> watched_;
  std::map<std::filesystem::path, int> descriptors_;
  std::map<std::filesystem::path, Polled> polled_;
  std::map<std::string, Writing> writing_;
  Clock::time_point next_poll_{};
};

}  // namespace isostrata
