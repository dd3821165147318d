#include "import/limits/opened_paths.h"

#include <dirent.h>
#include <dlfcn.h>
#include <fcntl.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <climits>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "data/files/zarr_folder.h"

namespace isostrata {
namespace {

struct Places {
  std::string directory, output;
  std::vector<std::string> files;
};
const Places* only = nullptr;  // null: every path

/// Where a path leads; empty if nowhere. Of a file that is not there yet, where it would be.
std::string real_path(const std::string& path) {
  char real[PATH_MAX];
  if (realpath(path.c_str(), real)) return real;
  if (errno != ENOENT) return {};
  const auto slash = path.rfind('/');
  const std::string name = path.substr(slash == std::string::npos ? 0 : slash + 1);
  if (name.empty() || name == ".." || !realpath(slash == std::string::npos ? "." : path.substr(0, slash + 1).c_str(), real)) return {};
  return std::string(real) + "/" + name;
}

/// The rest of a path below a folder, if it lies there.
bool is_below(const std::string& path, const std::string& folder, std::string& rest) {
  if (folder.empty() || !path.starts_with(folder)) return false;
  rest = path.substr(folder.size());
  return rest.empty() || rest.front() == '/' || folder == "/";
}

bool may_open(const std::string& path) {
  if (!only) return true;
  const std::string real = real_path(path);
  std::string rest;
  if (real.empty()) return false;
  if (is_below(real, only->output, rest)) return true;
  for (const std::string& file : only->files)
    if (real == file) return true;
  if (!is_below(real, only->directory, rest)) return false;
  rest.erase(0, rest.find_first_not_of('/'));
  return !is_hidden(rest.substr(0, rest.find('/')));
}

bool refused(const char* path, int directory = AT_FDCWD) {
  const bool relative = path && path[0] != '/' && directory != AT_FDCWD;
  if (!only || !path || may_open(relative ? "/proc/self/fd/" + std::to_string(directory) + "/" + path : path)) return false;
  errno = EACCES;
  return true;
}

int opened(int directory, const char* path, int flags, mode_t mode) {
  return refused(path, directory) ? -1 : static_cast<int>(syscall(SYS_openat, directory, path, flags, mode));
}

mode_t mode_of(int flags, std::va_list words) { return flags & (O_CREAT | __O_TMPFILE) ? static_cast<mode_t>(va_arg(words, int)) : 0; }

/// The C library's own function of this name.
template <class Function>
Function* next(const char* name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
}

}  // namespace

void open_only(const std::filesystem::path& directory, const std::vector<std::filesystem::path>& files, const std::filesystem::path& output) {
  auto* places = new Places{real_path(directory), real_path(output), {}};  // for good
  for (const std::filesystem::path& file : files) places->files.push_back(real_path(file));
  only = places;
}

}  // namespace isostrata

#ifndef ISOSTRATA_SANITIZED  // sanitizers have these places
// A program's functions take the place of a library's of the same name, for all libraries that it loads.
#pragma GCC visibility push(default)
extern "C" {

int open(const char* path, int flags, ...) {
  std::va_list words;
  va_start(words, flags);
  const mode_t mode = isostrata::mode_of(flags, words);
  va_end(words);
  return isostrata::opened(AT_FDCWD, path, flags, mode);
}

int openat(int directory, const char* path, int flags, ...) {
  std::va_list words;
  va_start(words, flags);
  const mode_t mode = isostrata::mode_of(flags, words);
  va_end(words);
  return isostrata::opened(directory, path, flags, mode);
}

FILE* fopen(const char* path, const char* mode) {
  static const auto function = isostrata::next<FILE*(const char*, const char*)>("fopen");
  return isostrata::refused(path) ? nullptr : function(path, mode);
}

DIR* opendir(const char* path) {
  static const auto function = isostrata::next<DIR*(const char*)>("opendir");
  return isostrata::refused(path) ? nullptr : function(path);
}

// The names for large files: here a file's size has 64 bits by either.
int open64(const char* path, int flags, ...) __attribute__((alias("open")));
int openat64(int directory, const char* path, int flags, ...) __attribute__((alias("openat")));
FILE* fopen64(const char* path, const char* mode) __attribute__((alias("fopen")));

}  // extern "C"
#pragma GCC visibility pop
#endif
