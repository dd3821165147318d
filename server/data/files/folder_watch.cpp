#include "data/files/folder_watch.h"

#include <dirent.h>
#include <fcntl.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/inotify.h>
#include <sys/stat.h>
#include <sys/vfs.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <memory>
#include <thread>
#include <vector>

#include "data/files/zarr_folder.h"

namespace isostrata {
namespace {

namespace fs = std::filesystem;
using std::chrono::milliseconds;

/// File systems on which other machines write without this kernel's knowledge: their f_type (statfs(2), linux/magic.h, and those of Lustre, GPFS, BeeGFS, PanFS).
bool others_may_write(const fs::path& folder) {
  struct statfs about {};
  if (statfs(folder.c_str(), &about) != 0) return true;
  constexpr std::array<std::uint32_t, 13> kShared = {0x6969, 0xff534d42, 0xfe534d42, 0x517b, 0x65735546, 0x01021997, 0x00c36400, 0x5346414f,
                                                     0x6b414653, 0x0bd00bd0, 0x47504653, 0x19830326, 0xaad7aaea};
  return std::find(kShared.begin(), kShared.end(), static_cast<std::uint32_t>(about.f_type)) != kShared.end();
}

}  // namespace

FolderWatch::FolderWatch(FolderWatchOptions options) : options_(options), stop_(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {
  if (!options_.inotify) {
    without_inotify_ = "inotify is switched off";
  } else if ((inotify_ = inotify_init1(IN_CLOEXEC | IN_NONBLOCK)) < 0) {
    without_inotify_ = std::string("inotify: ") + std::strerror(errno);
  }
}

FolderWatch::~FolderWatch() {
  if (inotify_ >= 0) close(inotify_);
  if (stop_ >= 0) close(stop_);
}

void FolderWatch::stop() {
  const std::uint64_t one = 1;
  if (write(stop_, &one, sizeof one) < 0) return;  // it has been told already
}

bool FolderWatch::add_watch(const fs::path& folder) {
  if (inotify_ < 0) return false;
  if (descriptors_.size() >= options_.most_watches || others_may_write(folder)) {
    without_inotify_ = descriptors_.size() >= options_.most_watches ? "more folders than " + std::to_string(options_.most_watches) : "a file system of other machines, " + folder.string();
    return false;
  }
  const int watch = inotify_add_watch(inotify_, folder.c_str(),
                                      IN_CREATE | IN_MODIFY | IN_CLOSE_WRITE | IN_ATTRIB | IN_MOVED_FROM | IN_MOVED_TO | IN_DELETE | IN_DELETE_SELF |
                                          IN_MOVE_SELF | IN_ONLYDIR | IN_EXCL_UNLINK);
  if (watch < 0) {
    without_inotify_ = std::string("inotify: ") + (errno == ENOSPC ? "no more watches (fs.inotify.max_user_watches)" : std::strerror(errno));
    return false;
  }
  if (const auto old = watched_.find(watch); old != watched_.end()) descriptors_.erase(old->second);  // the folder has been renamed
  watched_[watch] = folder;
  descriptors_[folder] = watch;
  return true;
}

void FolderWatch::remove_watch(const fs::path& folder) {
  polled_.erase(folder);
  const auto at = descriptors_.find(folder);
  if (at == descriptors_.end()) return;
  inotify_rm_watch(inotify_, at->second);
  watched_.erase(at->second);
  descriptors_.erase(at);
}

std::set<fs::path> FolderWatch::watch(const std::set<fs::path>& folders, const std::set<fs::path>& lone) {
  std::vector<fs::path> over;
  const auto wanted = [&](const fs::path& folder) { return folders.contains(folder) || lone.contains(folder); };
  for (const auto& [folder, descriptor] : descriptors_)
    if (!wanted(folder)) over.push_back(folder);
  for (const auto& [folder, polled] : polled_)
    if (!wanted(folder)) over.push_back(folder);
  for (const fs::path& folder : over) remove_watch(folder);
  std::set<fs::path> added;
  for (const std::set<fs::path>* some : {&folders, &lone})
    for (const fs::path& folder : *some) {
      if (descriptors_.contains(folder) || polled_.contains(folder)) continue;
      added.insert(folder);
      if (add_watch(folder)) continue;
      Polled& polled = polled_[folder];
      polled.lone = some == &lone && !folders.contains(folder);
      News none;
      poll_folder(folder, polled, none);
      for (const auto& [name, stamp] : polled.files) writing_.erase((folder / name).string());  // as it is found, it is
    }
  return added;
}

void FolderWatch::note_written(const fs::path& folder, const std::string& name, News& news) {
  Writing& of = writing_[(folder / name).string()];
  const auto now = Clock::now();
  of.last = now;
  if (now - of.told < options_.renew) return;
  of.told = now;
  news.folders.insert(folder);
}

void FolderWatch::read_events(News& news) {
  alignas(inotify_event) std::array<char, 64 << 10> buffer;
  for (;;) {
    const ssize_t count = read(inotify_, buffer.data(), buffer.size());
    if (count <= 0) return;
    for (ssize_t at = 0; at < count;) {
      const auto* event = reinterpret_cast<const inotify_event*>(buffer.data() + at);
      at += static_cast<ssize_t>(sizeof(inotify_event) + event->len);
      if (event->mask & IN_Q_OVERFLOW) news.everything = true;
      const auto of = watched_.find(event->wd);
      if (of == watched_.end()) continue;
      const fs::path folder = of->second;
      if (event->mask & (IN_DELETE_SELF | IN_MOVE_SELF | IN_IGNORED)) {
        if (!(event->mask & IN_IGNORED)) inotify_rm_watch(inotify_, event->wd);
        descriptors_.erase(folder);
        watched_.erase(of);
        news.folders.insert(folder);
        news.folders.insert(folder.parent_path());
        continue;
      }
      const std::string name = event->len > 0 ? event->name : "";
      if (!(event->mask & IN_ISDIR) && !name.empty()) {
        if (event->mask & (IN_CREATE | IN_MODIFY)) {
          note_written(folder, name, news);
          continue;
        }
        if (event->mask & (IN_CLOSE_WRITE | IN_MOVED_FROM | IN_MOVED_TO | IN_DELETE)) writing_.erase((folder / name).string());
      }
      news.folders.insert(folder);
    }
  }
}

void FolderWatch::settle(News& news) {
  const auto now = Clock::now();
  std::erase_if(writing_, [&](const auto& of) {
    if (of.second.polled || now - of.second.last < options_.quiet) return false;
    news.folders.insert(fs::path(of.first).parent_path());
    return true;
  });
}

void FolderWatch::poll_folder(const fs::path& folder, Polled& polled, News& news) {
  std::map<std::string, FileStamp> found;
  const std::unique_ptr<DIR, int (*)(DIR*)> listed(opendir(folder.c_str()), closedir);
  const bool there = listed != nullptr;
  if (there != polled.there) news.folders.insert(folder);
  polled.there = there;
  if (polled.lone) news.folders.insert(folder);
  if (!there || polled.lone) return;
  const auto wall = std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::system_clock::now().time_since_epoch()).count();
  for (const dirent* it = readdir(listed.get()); it; it = readdir(listed.get())) {
    struct stat about {};
    const std::string name = it->d_name;
    if (is_hidden(name) || fstatat(dirfd(listed.get()), it->d_name, &about, 0) != 0) continue;
    const FileStamp stamp = stamp_of(about);
    const auto before = polled.files.find(name);
    const std::string path = (folder / name).string();
    if (before != polled.files.end() && before->second == stamp) {
      if (writing_.erase(path) > 0) news.folders.insert(folder);
    } else {
      // What was moved here in one piece has an older time.
      if (S_ISREG(about.st_mode) && wall - stamp.changed_ns < 2'000'000'000) {
        writing_[path] = {Clock::now(), Clock::now(), true};
      } else {
        writing_.erase(path);
      }
      news.folders.insert(folder);
    }
    found.emplace(name, stamp);
  }
  for (const auto& [name, stamp] : polled.files)
    if (!found.contains(name)) {
      news.folders.insert(folder);
      writing_.erase((folder / name).string());
    }
  polled.files = std::move(found);
}

void FolderWatch::poll_folders(News& news) {
  if (polled_.empty()) return;
  const auto began = Clock::now();
  if (began < next_poll_) return;
  for (auto& [folder, polled] : polled_) poll_folder(folder, polled, news);
  const auto now = Clock::now();
  next_poll_ = now + std::max<Clock::duration>(options_.poll, 10 * (now - began));
}

FolderWatch::Clock::time_point FolderWatch::next_due() const {
  Clock::time_point due = polled_.empty() ? Clock::time_point::max() : next_poll_;
  for (const auto& [path, of] : writing_)
    if (!of.polled) due = std::min(due, of.last + options_.quiet);
  return due;
}

FolderWatch::News FolderWatch::wait(milliseconds at_most) {
  News news;
  const auto end = Clock::now() + at_most;
  for (bool gathered = false;;) {
    if (inotify_ >= 0) read_events(news);
    settle(news);
    poll_folders(news);
    const auto now = Clock::now();
    if (!news.empty()) {
      if (gathered) return news;
      gathered = true;
      std::this_thread::sleep_for(options_.gather);
      continue;
    }
    if (now >= end) return news;
    const auto left = std::chrono::ceil<milliseconds>(std::clamp<Clock::duration>(std::min(next_due(), end) - now, milliseconds(0), end - now));
    std::array<pollfd, 2> fds{pollfd{stop_, POLLIN, 0}, pollfd{inotify_, POLLIN, 0}};
    ::poll(fds.data(), inotify_ >= 0 ? 2 : 1, static_cast<int>(left.count()));
    if (fds[0].revents & POLLIN) return news;
  }
}

std::set<std::string> FolderWatch::writing() const {
  std::set<std::string> paths;
  for (const auto& [path, of] : writing_) paths.insert(path);
  return paths;
}

std::string FolderWatch::how() const {
  if (polled_.empty()) return inotify_ >= 0 ? "inotify" : without_inotify_ + ": every folder is looked at every " + std::to_string(options_.poll.count()) + " ms";
  return without_inotify_ + ": " + std::to_string(polled_.size()) + " folders are looked at every " + std::to_string(options_.poll.count()) + " ms";
}

}  // namespace isostrata
