// The commands of `isostrata-bench`, one file each, as those of `isostrata` are (main/commands.h).
#pragma once

#include <CLI/CLI.hpp>

namespace isostrata {

void add_bench_encode_command(CLI::App& bench);
void add_bench_extract_command(CLI::App& bench);
void add_bench_hand_command(CLI::App& bench);
void add_bench_neighbours_command(CLI::App& bench);
void add_bench_open_command(CLI::App& bench);
void add_bench_play_command(CLI::App& bench);
void add_bench_render_command(CLI::App& bench);
void add_bench_stream_command(CLI::App& bench);

}  // namespace isostrata
