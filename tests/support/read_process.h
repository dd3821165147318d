// Files of /proc, of processes that may end while they are read.
#pragma once

#include <filesystem>
#include <fstream>
#include <ios>
#include <iterator>
#include <string>

namespace isostrata::testing {

/// Empty once the process is gone.
inline std::string read_process(const std::filesystem::path& file) {
  try {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  } catch (const std::ios_base::failure&) {  // ESRCH
    return {};
  }
}

}  // namespace isostrata::testing
