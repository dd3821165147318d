// --ranks, which the commands have that one dataset can be shared out for; and the ranks themselves, in a program that is one of them.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "engine/picture/scene_ranks.h"

namespace isostrata {

/// Those of this process, from then on: commands ask them to extract and to draw. Before commands are added.
void use_ranks(SceneRanks* ranks);
SceneRanks* ranks_in_use();  // null in `isostrata` itself

/// What main() was called with, for --ranks to hand on.
void set_command_line(int argc, char** argv);

/// "mpirun -n 4" -> words, by the quotes of a shell. Throws invalid_argument if there is none.
std::vector<std::string> launcher_words(const std::string& launcher);
/// isostrata-rank beside this program. Throws unavailable, saying what a build needs to have it.
std::string rank_program();

/// Adds --ranks LAUNCHER unless this process is a rank.
void add_ranks_option(CLI::App& command, std::string& launcher);

/// Runs the same command by the ranks that the launcher starts and ends this process with their status. out: the file that the command writes,
/// or empty: one that is not there in the end is an error even if the launcher says that all is well. Throws unavailable.
void run_by_ranks(const std::string& launcher, const std::string& out);

}  // namespace isostrata
