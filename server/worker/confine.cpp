#include "worker/confine.h"

#include <linux/capability.h>
#include <sys/auxv.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cinttypes>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <set>
#include <sstream>
#include <string_view>
#include <system_error>

#include "base/drop_capabilities.h"
#include "base/error.h"
#include "base/landlock.h"
#include "base/program_file.h"
#include "data/dataset/analytic.h"
#include "data/files/zarr_folder.h"
#include "data/open/sandbox.h"
#include "worker/refused_calls.h"

namespace isostrata {
namespace {

namespace fs = std::filesystem;

// What says how much there is of what, for both processes.
constexpr std::array kFacts = {"/proc/self",        "/proc/meminfo",  "/proc/stat",        "/proc/loadavg", "/proc/cpuinfo", "/proc/version",
                               "/proc/filesystems", "/proc/mounts",   "/proc/sys/kernel",  "/proc/sys/vm",  "/sys/fs/cgroup", "/sys/devices/system",
                               "/dev/random",       "/dev/urandom",   "/etc/localtime",    "/usr/share/zoneinfo"};

// Libraries, drivers, and what they look at: readable for everybody on any machine, whatever the distribution.
constexpr std::array kSystem = {"/usr",           "/lib",           "/lib32",          "/lib64",         "/libx32",      "/opt/amdgpu",     "/opt/amdgpu-pro",
                                "/opt/rocm",      "/nix/store",     "/gnu/store",      "/run/opengl-driver", "/run/opengl-driver-32", "/run/host",
                                "/etc/ld.so.cache", "/etc/ld.so.conf", "/etc/ld.so.conf.d", "/etc/glvnd", "/etc/egl",  "/etc/vulkan",     "/etc/OpenCL",
                                "/etc/drirc",     "/etc/nvidia",    "/etc/alternatives", "/etc/nsswitch.conf", "/etc/passwd",
                                "/sys",           "/proc/driver",   "/proc/devices",   "/proc/bus/pci"};

// Devices that draw, by how their names begin, and those that are no more than files.
constexpr std::array kDevices = {"dri", "nvidia", "kfd", "dxg", "udmabuf", "dma_heap", "mali", "null", "zero", "full"};

// Where the operator has said that drivers and libraries are.
constexpr std::array kPlaceVariables = {"LD_LIBRARY_PATH",      "LIBGL_DRIVERS_PATH",   "GBM_BACKENDS_PATH",  "__EGL_VENDOR_LIBRARY_DIRS", "__EGL_VENDOR_LIBRARY_FILENAMES",
                                        "__EGL_EXTERNAL_PLATFORM_CONFIG_DIRS", "VK_DRIVER_FILES", "VK_ICD_FILENAMES", "OCL_ICD_VENDORS", "ISOSTRATA_OIIO"};
constexpr std::array kCacheVariables = {"MESA_SHADER_CACHE_DIR", "__GL_SHADER_DISK_CACHE_PATH"};

std::vector<fs::path> places_in(const char* variable) {
  const char* value = std::getenv(variable);
  std::istringstream list(value ? value : "");
  std::vector<fs::path> places;
  for (std::string place; std::getline(list, place, ':');)
    if (!place.empty()) places.emplace_back(place);
  return places;
}

/// The folders of all that this process has loaded, and the file that the kernel loads programs with.
std::set<fs::path> loaded_from(fs::path& interpreter) {
  std::set<fs::path> folders;
  const auto base = static_cast<std::uintptr_t>(getauxval(AT_BASE));
  std::ifstream maps("/proc/self/maps");
  for (std::string line; std::getline(maps, line);) {
    std::uintptr_t start = 0;
    int name = 0;
    if (std::sscanf(line.c_str(), "%" SCNxPTR "-%*s %*s %*s %*s %*s %n", &start, &name) < 1 || name == 0) continue;
    const fs::path file = line.substr(static_cast<std::size_t>(name));
    if (!file.is_absolute()) continue;
    if (start == base) interpreter = file;
    if (file.native().find(".so") != std::string::npos || file == program_file()) folders.insert(file.parent_path());
  }
  return folders;
}

void allow_system(const PathRules& rules) {
  fs::path interpreter = program_loader();
  const bool started_by_it = !interpreter.empty();
  fs::path found;
  for (const fs::path& folder : loaded_from(found)) rules.allow(folder, PathRules::kRead);
  if (!started_by_it) interpreter = found;
  for (const char* place : kSystem) rules.allow(place, PathRules::kRead);
  for (const char* variable : kPlaceVariables)
    for (const fs::path& place : places_in(variable)) rules.allow(place, PathRules::kRead);
  for (const char* variable : kCacheVariables)
    for (const fs::path& place : places_in(variable)) rules.allow(place, PathRules::kWrite);
  const fs::path folder = program_file().parent_path();
  rules.allow(folder.parent_path() / "lib/isostrata", PathRules::kRead);
  for (const char* reader : {"isostrata-import", "isostrata-import-all"}) rules.allow(folder / reader, PathRules::kReadFile | PathRules::kExecute);
  rules.allow(interpreter, PathRules::kReadFile | PathRules::kExecute);
  std::error_code error;
  for (fs::directory_iterator it("/dev", error), end; !error && it != end; it.increment(error)) {
    const std::string name = it->path().filename().string();
    if (std::any_of(kDevices.begin(), kDevices.end(), [&](std::string_view device) { return name.starts_with(device); }))
      rules.allow(it->path(), PathRules::kDevice);
  }
}

bool confine_files(const ReachablePlaces& reach, bool worker) {
  const PathRules rules(worker);  // the server ends the worker, which is not below it; seccomp keeps it from ending others
  if (!rules.usable()) return false;
  for (const char* place : kFacts) rules.allow(place, PathRules::kRead);
  if (worker) allow_system(rules);
  for (const fs::path& place : reach.read) rules.allow(place, PathRules::kRead);
  for (const fs::path& place : reach.names) rules.allow(place, PathRules::kReadFolder);
  for (const fs::path& place : reach.write) rules.allow(place, PathRules::kWrite);
  return rules.enforce();
}

std::string confine(const ReachablePlaces& reach, bool worker, const std::function<bool()>& refuse_calls) {
#ifdef ISOSTRATA_SANITIZED
  return {};  // sanitizers start programs and look at other processes when they find something
#endif
  if (sandbox() == Sandbox::off) return {};
  SandboxSupport holds = sandbox_support();
  if (prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0) holds = {};  // both need it
  if (holds.landlock > 0 && !confine_files(reach, worker)) holds.landlock = 0;
  drop_capabilities_but((1u << CAP_DAC_READ_SEARCH) | (1u << CAP_DAC_OVERRIDE));  // root may go on opening what belongs to others, which is what it was started for
  if (holds.seccomp) holds.seccomp = refuse_calls();
  if (const std::string missing = missing_of(holds); sandbox() == Sandbox::require && !missing.empty())
    throw Error(ErrorCode::unavailable, "--sandbox require: this machine lacks " + missing);
  const std::string landlock = holds.landlock > 0 ? "Landlock " + std::to_string(holds.landlock) : "";
  return landlock + (!landlock.empty() && holds.seccomp ? " and " : "") + (holds.seccomp ? "seccomp" : "");
}

/// A home directory, or what lies above one.
bool is_of_people(const fs::path& folder) {
  const char* home = std::getenv("HOME");
  for (const fs::path& person : {fs::path(home ? home : ""), fs::path("/root"), fs::path("/home"), fs::path("/tmp"), fs::path("/var/tmp")}) {
    std::error_code error;
    const fs::path real = fs::canonical(person, error);
    if (!error && std::mismatch(folder.begin(), folder.end(), real.begin(), real.end()).first == folder.end()) return true;
  }
  return folder.parent_path() == "/home";
}

void reach_folder_of(const fs::path& file, ReachablePlaces& reach) {
  std::error_code error;
  const fs::path folder = fs::canonical(file.parent_path(), error);
  if (error) return;
  if (!is_of_people(folder)) return reach.read.push_back(folder);
  reach.names.push_back(folder);
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error))
    if (!it->path().filename().native().starts_with('.')) reach.read.push_back(it->path());
}

}  // namespace

std::string confine_worker(const ReachablePlaces& reach) { return confine(reach, true, refuse_calls_of_worker); }

std::string confine_server(const ReachablePlaces& reach) {
  const long descriptor = syscall(SYS_pidfd_open, getpid(), 0);
  if (descriptor >= 0) close(static_cast<int>(descriptor));
  return confine(reach, false, [descriptor] { return refuse_calls_of_server(descriptor < 0); });
}

ReachablePlaces reach_of_sources(const std::vector<std::string>& sources) {
  ReachablePlaces reach;
  for (const std::string& source : sources) {
    if (is_analytic(source)) continue;
    std::error_code error;
    const fs::path path = fs::absolute(source);
    if (fs::is_directory(path, error)) {
      reach.read.push_back(path);
      for (const fs::path& above : zarr_files_above(path)) reach.read.push_back(above);
    } else {
      reach_folder_of(path, reach);
      if (fs::is_symlink(path, error)) reach_folder_of(fs::canonical(path, error), reach);
    }
  }
  for (auto* places : {&reach.read, &reach.names}) {
    std::sort(places->begin(), places->end());
    places->erase(std::unique(places->begin(), places->end()), places->end());
  }
  return reach;
}

}  // namespace isostrata
