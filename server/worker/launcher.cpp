#include "worker/launcher.h"

#include <sys/syscall.h>
#include <unistd.h>

#include <optional>
#include <utility>

#include "base/error.h"
#include "base/temporary_directory.h"
#include "worker/worker_folder.h"

namespace isostrata {
namespace {

namespace fs = std::filesystem;

constexpr int kSocket = 3, kBoard = 4;

class LauncherHere final : public Launcher {
 public:
  LauncherHere(WorkerPlan plan, Spawn::Parent parent) : plan_(std::move(plan)), parent_(parent) {
    if (plan_.program.empty()) plan_.program = "/proc/self/exe";
    WorkerFolder::sweep();
  }

  Launched launch(int socket, int board) override {
    temporary_.reset();  // what a dead worker leaves behind goes with it; what cannot be removed is in nobody's way
    if (!folder_ || !folder_->exists()) {
      folder_.reset();
      folder_.emplace();
      keep_ = folder_->make("kept");
    }
    temporary_.emplace(folder_->path(), "worker-");
    Spawn spawn{.program = plan_.program, .words = {"isostrata"}, .environment = environment_without({"TMPDIR", "ISOSTRATA_TOKEN"})};
    spawn.environment.push_back("TMPDIR=" + temporary_->path().string());
    spawn.words.insert(spawn.words.end(), plan_.arguments.begin(), plan_.arguments.end());
    const pid_t parent = parent_ == Spawn::Parent::this_process ? getpid() : getppid();
    const auto say = [&](const char* option, const std::string& value) {
      spawn.words.emplace_back(option);
      spawn.words.push_back(value);
    };
    say("--socket", std::to_string(kSocket));
    say("--board", std::to_string(kBoard));
    say("--parent", std::to_string(parent));
    if (plan_.shut_in) {
      spawn.words.emplace_back("--shut-in");
      for (const fs::path& place : plan_.reach.read) say("--read", place.string());
      for (const fs::path& place : plan_.reach.names) say("--names", place.string());
      for (const fs::path& place : plan_.reach.write) say("--write", place.string());
      for (const fs::path& place : {temporary_->path(), keep_}) say("--write", place.string());
    }
    spawn.descriptors = {-1, -1, STDERR_FILENO, socket, board};
    spawn.parent = parent_;
    Launched launched;
    const int error = spawn_in_group(launched.id, spawn);
    if (error != 0)
      throw_system_error(plan_.program.string() + ": the worker process cannot be started", error);
    launched.process = Descriptor(static_cast<int>(syscall(SYS_pidfd_open, launched.id, 0)));
    launched.keep = keep_;
    return launched;
  }

 private:
  WorkerPlan plan_;
  const Spawn::Parent parent_;
  std::optional<WorkerFolder> folder_;
  std::optional<TemporaryDirectory> temporary_;
  fs::path keep_;
};

}  // namespace

std::unique_ptr<Launcher> make_launcher(WorkerPlan plan, Spawn::Parent parent) {
  return std::make_unique<LauncherHere>(std::move(plan), parent);
}

}  // namespace isostrata
