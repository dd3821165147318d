// isostrata-import and isostrata-import-all, each loaded once. Most of what it costs to read a small file is to load 45 or 115 libraries, so one process
// loads them and makes a copy of itself (fork) for each file. A copy does what the program would do that is started for the file: it takes its own rights away, and
// reads. The process that is copied looks at no file.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "data/files/recognise.h"
#include "data/open/child_process.h"

namespace isostrata {

/// All variables that it is told of ours, "NAME=VALUE": no token, no name, no path of programs.
std::vector<std::string> importer_environment();

/// Starts a reader by the process that is there already, or that is started now, of the file's default_importer(): `words` are the arguments that the
/// program would be started with, the file first, whose needs these are. It is as nice as the thread that asks. The process ends when this one does. Throws unavailable. Any thread.
std::unique_ptr<Child> start_loaded_importer(const std::vector<std::string>& words, const ReaderNeeds& needs, int out, int err);

/// Begins to load both, so that the first file does not wait; that it cannot be started is said with that file.
void load_importer();

}  // namespace isostrata
