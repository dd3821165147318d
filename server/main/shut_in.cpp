#include "main/shut_in.h"

#include <openssl/ssl.h>
#include <sys/stat.h>

#include <cstdlib>
#include <system_error>
#include <utility>

#include "data/open/import_cache.h"
#include "data/open/sandbox.h"

namespace isostrata {
namespace {

namespace fs = std::filesystem;

/// A folder for this user alone; one that cannot be made is told by who needs it.
void make(const fs::path& folder) {
  std::error_code ignored;
  fs::create_directories(folder.parent_path(), ignored);
  mkdir(folder.c_str(), 0700);
}

/// Drivers keep the shaders that they have compiled in one folder for all of a user's programs, which a worker does not reach: it has one of ours.
void choose_shader_cache(const fs::path& folder) {
  for (const char* variable : {"MESA_SHADER_CACHE_DIR", "__GL_SHADER_DISK_CACHE_PATH"}) setenv(variable, folder.c_str(), 0);
}

}  // namespace

ShutIn::ShutIn(const ServerPlaces& places) : reach_(reach_of_sources(places.sources)) {
  WorkerPlan plan{.shut_in = true, .reach = reach_};
  plan.reach.write.push_back(folder_.path());  // exports
  if (!places.ranks.empty()) {
    if (sandbox() == Sandbox::require)
      throw Error(ErrorCode::unavailable, "--ranks: ranks cannot be shut in, since MPI opens sockets and starts programs; expected --sandbox try or off, which is for a network "
                                          "whose users you trust");
    plan.shut_in = false;
    plan.arguments = {"worker", "--ranks", places.ranks};
  }
  if (const auto& cache = import_cache()) {
    make(cache->folder);
    make(cache->folder / "shaders");
    if (sandbox() != Sandbox::off) choose_shader_cache(cache->folder / "shaders");
    plan.reach.write.push_back(cache->folder);
  }
  StarterProcess::Duties duties = places.duties;
  duties.folders.push_back(folder_.path());
  helper_ = std::make_shared<StarterProcess>(std::move(plan), std::move(duties));
  setenv("TMPDIR", folder_.path().c_str(), 1);
  if (!places.state_dir.empty()) {
    make(places.state_dir);
    make(places.state_dir / "sessions");
    std::error_code ignored;
    fs::permissions(places.state_dir / "sessions", fs::perms::owner_all, ignored);  // later no rights can be changed
    reach_.write.push_back(places.state_dir);
  }
  reach_.write.push_back(folder_.path());
  reach_.read.insert(reach_.read.end(), places.files.begin(), places.files.end());
}

std::string ShutIn::confine() const {
  OPENSSL_init_ssl(0, nullptr);  // reads its settings
  return confine_server(reach_);
}

}  // namespace isostrata
