// Which EGL this program loads, and from where.
#pragma once

#include <string>
#include <vector>

namespace isostrata {

struct LoadedLibrary {
  std::string name;    // "libEGL.so.1", "10_nvidia.json: libEGL_nvidia.so.0"
  bool ok = false;
  std::string detail;  // the file that it is, or why it cannot be loaded
};

/// The C library, which a driver has to be content with, and its version.
LoadedLibrary c_library();

/// libEGL.so.1, then the drivers that it asks in turn: those that the files in $__EGL_VENDOR_LIBRARY_FILENAMES name, else those in the
/// folders of $__EGL_VENDOR_LIBRARY_DIRS, else in those where GLVND looks by itself ("EGL ICD enumeration" in GLVND's documentation). They
/// are loaded by another process, which one of them may end. Any thread.
std::vector<LoadedLibrary> egl_libraries();

}  // namespace isostrata
