// What the main functions of our programs share.
#pragma once

#include <CLI/CLI.hpp>

#include "main/simd_option.h"

namespace isostrata {

/// Reads the environment, parses the command line, which runs the commands, and returns the exit status. What failed is one line on standard error.
int run_program(CLI::App& app, int argc, char** argv);

}  // namespace isostrata
