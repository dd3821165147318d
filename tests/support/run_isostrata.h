// Runs the real program, as a person or a script would.
#pragma once

#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

namespace isostrata::testing {

struct CommandResult {
  int status = -1;  // exit status; -1 where a signal ended it
  std::string out, err;
};

/// A folder that is removed with everything in it.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "isostrata-test-XXXXXX").string();
    if (!mkdtemp(name.data())) std::abort();
    path_ = name;
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }

 private:
  std::filesystem::path path_;
};

inline std::string read_text(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

/// `isostrata ARGUMENTS`, the arguments in the shell's syntax; `environment` goes before the command ("NAME=value").
inline CommandResult run_isostrata(const std::string& arguments, const std::string& environment = "") {
  const TemporaryFolder folder;
  const auto out = folder / "out", err = folder / "err";
  const std::string command =
      environment + " '" ISOSTRATA_BIN_DIR "/isostrata' " + arguments + " >'" + out.string() + "' 2>'" + err.string() + "'";
  const int state = std::system(command.c_str());
  return {WIFEXITED(state) ? WEXITSTATUS(state) : -1, read_text(out), read_text(err)};
}

}  // namespace isostrata::testing
