#include "worker/worker_folder.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

#include "base/error.h"

namespace isostrata {
namespace {

namespace fs = std::filesystem;
constexpr const char* kPrefix = "isostrata-worker-";

Descriptor open_folder(const fs::path& path) {
  return Descriptor(open(path.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC));
}

fs::path made_base() {
  std::error_code ignored;  // what cannot be made is told by who needs it
  fs::create_directories(temporary_base(), ignored);
  return temporary_base();
}

}  // namespace

WorkerFolder::WorkerFolder() : directory_(made_base(), kPrefix), lock_(open_folder(path())) {
  if (lock_) flock(lock_.get(), LOCK_EX | LOCK_NB);
}

bool WorkerFolder::exists() const {
  struct stat here {}, there {};
  return lock_ && fstat(lock_.get(), &here) == 0 && lstat(path().c_str(), &there) == 0 && here.st_ino == there.st_ino &&
         here.st_dev == there.st_dev;
}

fs::path WorkerFolder::make(const char* name) const {
  const fs::path folder = path() / name;
  if (mkdir(folder.c_str(), 0700) != 0)
    throw_system_error("cannot make the directory " + folder.string(), errno);
  return folder;
}

void WorkerFolder::sweep() {
  std::error_code error;
  fs::directory_iterator it(temporary_base(), fs::directory_options::skip_permission_denied, error);
  for (; !error && it != fs::directory_iterator(); it.increment(error)) {
    const fs::directory_entry& entry = *it;
    if (!entry.path().filename().string().starts_with(kPrefix)) continue;
    const Descriptor folder = open_folder(entry.path());
    struct stat facts {};
    // One that was made a moment ago may not be locked yet.
    if (!folder || fstat(folder.get(), &facts) != 0 || facts.st_uid != geteuid() || time(nullptr) - facts.st_mtime < 60) continue;
    if (flock(folder.get(), LOCK_EX | LOCK_NB) != 0) continue;
    std::error_code ignored;
    fs::remove_all(entry.path(), ignored);
  }
}

}  // namespace isostrata
