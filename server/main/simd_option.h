// --simd, which every command has.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "base/error.h"
#include "base/simd_level.h"

namespace isostrata {

/// Of the command and those below it; obeyed before the command's callback. What is not a level is wrong usage.
inline void add_simd_option(CLI::App& command) {
  const auto use = [](const std::string& level) {
    try {
      use_simd_level(level);
    } catch (const Error& error) {
      if (error.code() != ErrorCode::invalid_argument) throw;
      throw CLI::ValidationError("--simd", error.what());
    }
  };
  command
      .add_option_function<std::string>(
          "--simd", use, "Vector instructions: auto, avx512, avx2, sse4 or emulated (default: $ISOSTRATA_SIMD, else the best here)")
      ->trigger_on_parse();
  for (CLI::App* part : command.get_subcommands({})) add_simd_option(*part);
}

}  // namespace isostrata
