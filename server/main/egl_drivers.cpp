#include "main/egl_drivers.h"

#include <dlfcn.h>
#include <gnu/libc-version.h>
#include <link.h>

#include <algorithm>
#include <boost/json.hpp>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>

namespace isostrata {
namespace {

namespace fs = std::filesystem;

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

std::vector<LoadedLibrary> egl_libraries() {
  std::vector<LoadedLibrary> libraries{load("libEGL.so.1", "libEGL.so.1")};
  if (libraries.front().ok)
    for (const fs::path& file : driver_files()) libraries.push_back(driver_of(file));
  return libraries;
}

}  // namespace isostrata
