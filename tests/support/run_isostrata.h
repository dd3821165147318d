// Runs the real program, as a person or a script would.
#pragma once

#include <sys/wait.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include "support/places.h"
#include "support/temporary_folder.h"

namespace isostrata::testing {

struct CommandResult {
  int status = -1;  // exit status; -1 if a signal ended it
  std::string out, err;
};

inline std::string read_text(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

/// A program of this build with arguments in the shell's syntax; `environment` goes before the command ("NAME=value").
inline CommandResult run_program(const std::string& program, const std::string& arguments, const std::string& environment = "") {
  const TemporaryFolder folder;
  const auto out = folder / "out", err = folder / "err";
  const std::string command =
      environment + " '" + isostrata::places::binaries() + "/" + program + "' " + arguments + " >'" + out.string() + "' 2>'" + err.string() + "'";
  const int state = std::system(command.c_str());
  return {WIFEXITED(state) ? WEXITSTATUS(state) : -1, read_text(out), read_text(err)};
}

/// `isostrata ARGUMENTS`.
inline CommandResult run_isostrata(const std::string& arguments, const std::string& environment = "") {
  return run_program("isostrata", arguments, environment);
}

}  // namespace isostrata::testing
