// One process that has all libraries loaded, and makes a reader for each file (data/open/loaded_importer.h).
#pragma once

#include <functional>
#include <string>
#include <vector>

namespace isostrata {

/// Takes requests from standard input (data/open/importer_request.h) until its other end is closed: then all readers end, and the process. A reader has a process
/// group of its own, standard output and error of its request, no other descriptor but /dev/null, and the variables of its request alone; it runs
/// read_one(words), which does not return. Looks at no file. Before there are threads.
[[noreturn]] void fork_for_files(const std::function<void(const std::vector<std::string>& words)>& read_one);

}  // namespace isostrata
