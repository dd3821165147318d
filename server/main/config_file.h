// Options of a command from a file.
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>

namespace isostrata {

/// Adds --config FILE: lines of TOML, the command's long options without their dashes (`port = 8080`, `data-root = ["a", "b"]`,
/// `no-auth = true`). What the command line or the environment gives comes first. A name that is not an option and a value that the
/// option does not take are errors (usage, exit status 2) that name the file.
void add_config_option(CLI::App& command);

}  // namespace isostrata
