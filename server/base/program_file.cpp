#include "base/program_file.h"

#include <dlfcn.h>

#include <cinttypes>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <string>
#include <system_error>

namespace isostrata {
namespace {

namespace fs = std::filesystem;

/// The file of the kernel's map (`start-end rights offset device inode file`) that holds this very code. The rooms are static libraries, so
/// that is the program's.
fs::path file_of_this_code() {
  const auto here = reinterpret_cast<std::uintptr_t>(&file_of_this_code);
  std::ifstream maps("/proc/self/maps");
  for (std::string line; std::getline(maps, line);) {
    std::uintptr_t start = 0, end = 0;
    int file = 0;
    if (std::sscanf(line.c_str(), "%" SCNxPTR "-%" SCNxPTR " %*s %*s %*s %*s %n", &start, &end, &file) < 2) continue;
    if (here >= start && here < end) return file > 0 ? fs::path(line.substr(static_cast<std::size_t>(file))) : fs::path();
  }
  return {};
}

/// As whoever started the program called it: a process that is shut in without a /proc of its own may not read its maps, but it was started by a whole path.
fs::path file_by_its_call() {
  Dl_info found{};
  const bool known = dladdr(reinterpret_cast<const void*>(&file_of_this_code), &found) != 0 && found.dli_fname != nullptr;
  return known && *found.dli_fname == '/' ? fs::path(found.dli_fname) : fs::path();
}

fs::path started_file() {
  std::error_code error;
  return fs::read_symlink("/proc/self/exe", error);
}

}  // namespace

fs::path program_file() {
  static const fs::path file = [] {
    fs::path mapped = file_of_this_code();
    return mapped.empty() ? file_by_its_call() : mapped;
  }();
  return file;
}

fs::path program_loader() {
  static const fs::path started = started_file();
  return started == program_file() || program_file().empty() ? fs::path() : started;
}

}  // namespace isostrata
