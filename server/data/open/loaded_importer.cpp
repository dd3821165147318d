#include "data/open/loaded_importer.h"

#include <poll.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/descriptor.h"
#include "base/pass_descriptors.h"
#include "base/spawn.h"
#include "data/open/import_door.h"
#include "data/open/importer_request.h"

namespace isostrata {
namespace {

namespace fs = std::filesystem;

std::pair<Descriptor, Descriptor> line_of_packets() {
  int ends[2];
  if (socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends) != 0) throw_system_error("no line to the process that reads files", errno);
  return {Descriptor(ends[0]), Descriptor(ends[1])};
}

/// Ends with its line.
class LoadedImporter {
 public:
  LoadedImporter(const fs::path& program, bool ahead) {
    auto [here, there] = line_of_packets();
    // All symbols at once if there is time: what is found late is found again in each copy, but a third of them is all that one file needs. Huge pages for what malloc gives: to touch the memory of 5 million
    // tetrahedra page by page took three quarters of the time that they are read in.
    Spawn spawn{.program = program,
                .words = {program.string(), kForkForFiles},
                .environment = importer_environment(),
                .descriptors = {there.get(), -1, STDERR_FILENO}};
    spawn.environment.emplace_back("GLIBC_TUNABLES=glibc.malloc.hugetlb=1");
    if (ahead) spawn.environment.emplace_back("LD_BIND_NOW=1");
    if (const int error = spawn_in_group(id_, spawn); error != 0) throw_system_error(program.string() + ": cannot be started", error);
    line_ = std::move(here);
  }
  ~LoadedImporter() {
    line_.close();
    while (waitpid(id_, nullptr, 0) < 0 && errno == EINTR) {
    }
  }
  LoadedImporter(const LoadedImporter&) = delete;
  LoadedImporter& operator=(const LoadedImporter&) = delete;

  bool ask(const std::string& request, int out, int err, int control) const {
    return send_passing(line_.get(), request.data(), request.size(), {out, err, control}) == static_cast<ssize_t>(request.size());
  }

 private:
  Descriptor line_;
  pid_t id_ = 0;
};

/// One of the two programs of this process. One that has died is started again.
class OneImporter {
 public:
  explicit OneImporter(bool all_readers) : all_readers_(all_readers) {}

  void ask(const std::string& request, int out, int err, int control) {
    const std::lock_guard lock(mutex_);
    if (loaded(false).ask(request, out, err, control)) return;
    importer_.reset();
    if (!loaded(false).ask(request, out, err, control))
      throw Error(ErrorCode::unavailable, default_importer(all_readers_).string() + ": ended as soon as it was started");
  }
  void load() {
    const std::lock_guard lock(mutex_);
    loaded(true);
  }

 private:
  const LoadedImporter& loaded(bool ahead) {
    if (!importer_) importer_.emplace(default_importer(all_readers_), ahead);
    return *importer_;
  }

  const bool all_readers_;
  std::mutex mutex_;
  std::optional<LoadedImporter> importer_;
};

OneImporter& importer(bool all_readers) {
  static OneImporter small(false), whole(true);
  return all_readers ? whole : small;
}

/// Known by its control: closed here it ends the reader, closed there the reader is gone.
class ForkedChild final : public Child {
 public:
  explicit ForkedChild(Descriptor control) : control_(std::move(control)) {}
  ~ForkedChild() override {
    if (!control_) return;
    shutdown(control_.get(), SHUT_WR);
    int status = 0;
    while (read(control_.get(), &status, sizeof status) < 0 && errno == EINTR) {
    }
  }
  ForkedChild(const ForkedChild&) = delete;
  ForkedChild& operator=(const ForkedChild&) = delete;

  bool ended(int& status) override {
    pollfd ready{control_.get(), POLLIN, 0};
    if (poll(&ready, 1, 0) <= 0) return false;
    const ssize_t got = read(control_.get(), &status, sizeof status);
    if (got < 0 && errno == EINTR) return false;
    control_.close();
    if (got != static_cast<ssize_t>(sizeof status)) throw Error(ErrorCode::unavailable, "the process that reads files has ended");
    return true;
  }

 private:
  Descriptor control_;
};

}  // namespace

std::vector<std::string> importer_environment() {
  std::vector<std::string> out{"HDF5_USE_FILE_LOCKING=FALSE", "MALLOC_ARENA_MAX=1"};  // an arena is 64 MiB of address space a thread
  for (const char* name : {"TMPDIR", "LD_LIBRARY_PATH", "ISOSTRATA_SIMD"})
    if (const char* value = std::getenv(name)) out.push_back(std::string(name) + "=" + value);
#ifdef ISOSTRATA_SANITIZED
  for (const char* name : {"ASAN_OPTIONS", "UBSAN_OPTIONS", "TSAN_OPTIONS"})
    if (const char* value = std::getenv(name)) out.push_back(std::string(name) + "=" + value);
#endif
  return out;
}

std::unique_ptr<Child> start_loaded_importer(const std::vector<std::string>& words, const ReaderNeeds& needs, int out, int err) {
  auto [here, there] = line_of_packets();
  std::vector<std::string> environment = importer_environment();
  if (needs.pictures) environment.push_back(std::string(kPictureVariable) + "=yes");
  const int nice = getpriority(PRIO_PROCESS, 0);  // of this thread
  importer(needs.all_readers).ask(to_packet({words, std::move(environment), nice}), out, err, there.get());
  return std::make_unique<ForkedChild>(std::move(here));
}

void load_importer() {
  for (const bool all_readers : {false, true}) {
    try {
      importer(all_readers).load();
    } catch (const Error&) {  // the first file says it
    }
  }
}

}  // namespace isostrata
