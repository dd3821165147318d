#include "main/egl_drivers.h"

#include <dlfcn.h>
#include <gnu/libc-version.h>
#include <link.h>

#include <algorithm>
#include <boost/json.hpp>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>

#include "base/run_in_child.h"

namespace isostrata {
namespace {

namespace fs = std::filesystem;

constexpr std::chrono::seconds kDriverLimit{30};

/// Its path, or why it cannot be loaded.
LoadedLibrary load(const std::string& name, const std::string& shown) {
  void* library = dlopen(name.c_str(), RTLD_LAZY | RTLD_LOCAL);
  if (!library) {
    const char* why = dlerror();
    return {shown, false, why ? why : "cannot be loaded"};
  }
  link_map* map = nullptr;
  return {shown, true, dlinfo(library, RTLD_DI_LINKMAP, &map) == 0 && map ? map->l_name : name};
}

std::vector<std::string> words_of(const char* variable, const char* otherwise) {
  const char* text = std::getenv(variable);
  std::istringstream list(text ? text : otherwise);
  std::vector<std::string> words;
  for (std::string word; std::getline(list, word, ':');)
    if (!word.empty()) words.push_back(word);
  return words;
}

std::vector<fs::path> driver_files() {
  if (std::getenv("__EGL_VENDOR_LIBRARY_FILENAMES")) {
    const std::vector<std::string> named = words_of("__EGL_VENDOR_LIBRARY_FILENAMES", "");
    return {named.begin(), named.end()};
  }
  std::vector<fs::path> files;
  for (const std::string& folder : words_of("__EGL_VENDOR_LIBRARY_DIRS", "/etc/glvnd/egl_vendor.d:/usr/share/glvnd/egl_vendor.d")) {
    std::error_code error;
    std::vector<fs::path> here;
    for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error))
      if (it->path().extension() == ".json") here.push_back(it->path());
    std::sort(here.begin(), here.end());
    files.insert(files.end(), here.begin(), here.end());
  }
  return files;
}

LoadedLibrary driver_of(const fs::path& file) {
  const std::string name = file.filename().string();
  std::ifstream in(file);
  if (!in) return {name, false, file.string() + " cannot be read"};
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  boost::system::error_code error;
  const boost::json::value document = boost::json::parse(text, error);
  const boost::json::object* icd = document.is_object() && document.as_object().contains("ICD") ? document.at("ICD").if_object() : nullptr;
  const boost::json::value* library = icd ? icd->if_contains("library_path") : nullptr;
  if (error || !library || !library->is_string()) return {name, false, file.string() + " names no driver (ICD.library_path)"};
  const std::string driver(library->as_string());
  return load(driver, name + ": " + driver);
}

}  // namespace

LoadedLibrary c_library() { return load("libc.so.6", std::string("C library ") + gnu_get_libc_version()); }

// What the child says of each is three words that end with a zero byte: name, "ok" or nothing, detail.
std::vector<LoadedLibrary> egl_libraries() {
  std::vector<LoadedLibrary> libraries;
  std::vector<fs::path> files = driver_files();
  files.insert(files.begin(), "libEGL.so.1");
  while (libraries.size() < files.size() && (libraries.empty() || libraries.front().ok)) {
    const ChildRun run = run_in_child(
        [&](const Say& say) {
          for (std::size_t i = libraries.size(); i < files.size(); ++i) {
            const LoadedLibrary of = i == 0 ? load(files[0], files[0]) : driver_of(files[i]);
            say(of.name + '\0' + (of.ok ? "ok" : "") + '\0' + of.detail + '\0');
            if (i == 0 && !of.ok) return;
          }
        },
        kDriverLimit);
    std::istringstream said(run.said);
    for (LoadedLibrary of; std::getline(said, of.name, '\0');) {
      std::string ok;
      std::getline(said, ok, '\0');
      std::getline(said, of.detail, '\0');
      of.ok = !ok.empty();
      libraries.push_back(of);
    }
    if (!run.ended.empty() && libraries.size() < files.size())
      libraries.push_back({files[libraries.size()].filename().string(), false, "loading it ended the process that tried it: " + run.ended});
  }
  return libraries;
}

}  // namespace isostrata
