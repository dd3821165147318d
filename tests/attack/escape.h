// Runs tests/attack/sandbox_escape.cpp: one act of somebody who has taken a process over, tried from inside.
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "data/files.h"
#include "data/open/child_process.h"
#include "support/places.h"

namespace isostrata::attack {

namespace fs = std::filesystem;

struct Who {
  const char* name;
  std::vector<std::string> words;
};

/// This user and, if this is root, another one.
inline std::vector<Who> users() {
  std::vector<Who> out{{geteuid() == 0 ? "as root" : "as this user", {}}};
  if (geteuid() == 0) out.push_back({"as nobody", {"nobody"}});
  return out;
}

/// What the escape prints, of a new folder in which everything is its own.
inline ChildResult tried(const std::string& act, const std::string& how, std::vector<std::string> words, std::string& line) {
  const test::Scratch scratch;
  for (const char* name : {"data/field.vtk", "data/.hidden", "data/deep/more.vtk", "out/mine", "other/secret", "other/victim"})
    scratch.write(name, "1");
  fs::copy_file("/bin/true", scratch / "other/program");
  fs::permissions(scratch.path(), fs::perms::owner_all | fs::perms::group_exec | fs::perms::others_exec);
  if (std::find(words.begin(), words.end(), "nobody") != words.end())
    for (const auto& entry : fs::recursive_directory_iterator(scratch.path()))
      if (chown(entry.path().c_str(), 65534, 65534) != 0) ADD_FAILURE() << entry.path();
  std::vector<std::string> arguments{scratch.path(), act, how};
  arguments.insert(arguments.end(), words.begin(), words.end());
  line.clear();
  return run_child({fs::path(places::binaries()) / "isostrata-sandbox-escape", arguments, {}}, 60, Task(),
                   [&](std::string_view text) { line = text; });
}

inline void expect_refused(const std::string& act, const Who& who, const std::string& how = "try") {
  std::string line;
  const ChildResult result = tried(act, how, who.words, line);
  EXPECT_EQ(result.exit_status, 0) << act << " " << who.name << ": " << line;
  EXPECT_EQ(result.signal, 0) << act << " " << who.name;
  EXPECT_TRUE(line.starts_with("refused: ")) << act << " " << who.name << ": " << line;
}

inline void expect_done(const std::string& act, const Who& who, const std::string& how) {
  std::string line;
  const ChildResult result = tried(act, how, who.words, line);
  EXPECT_EQ(result.exit_status, 1) << act << " " << who.name << ": " << line;
  EXPECT_EQ(line, "done") << act << " " << who.name;
}

}  // namespace isostrata::attack
