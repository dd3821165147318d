// What a server has kept on disk.
#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <string>
#include <thread>

#include "support/run_isostrata.h"

namespace isostrata::testing {

/// What a server keeps is written by a thread of its own, and a kill before that would be another test: waits until a journal
/// below the folder has these bytes.
inline void wait_until_kept(const std::filesystem::path& folder, const std::string& text) {
  for (int i = 0; i < 3000; ++i) {
    for (const auto& file : std::filesystem::recursive_directory_iterator(folder))
      if (file.path().extension() == ".journal" && read_text(file.path()).find(text) != std::string::npos) return;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  ADD_FAILURE() << "the journal does not have " << text;
}

}  // namespace isostrata::testing
