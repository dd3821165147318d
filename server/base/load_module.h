// The program's modules: libraries of ours that are loaded when they are needed, or if they are there at all.
#pragma once

#include <string>

namespace isostrata {

struct LoadedModule {
  const void* entry = nullptr;  // what the module's function of no arguments returned; null: there is none
  std::string path;             // the file that is it, or was to be; empty: none was found
  std::string problem;          // or why there is none
};

/// `file` where the environment's `variable` says (empty there: none), beside the program, and in lib/isostrata/ beside the
/// program's folder. `function` is the name of its one function, which returns a struct that begins with the int `version`. Of several that
/// are found the first that can be loaded and is of this version; it stays for good. Any thread.
LoadedModule load_module(const char* file, const char* variable, const char* function, int version);

}  // namespace isostrata
