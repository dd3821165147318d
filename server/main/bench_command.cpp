#include "main/commands.h"

namespace isostrata {

void add_bench_command(CLI::App& app) {
  CLI::App* bench = app.add_subcommand("bench", "Measures this machine: min, median and max of many runs, as JSON with --json");
  bench->require_subcommand(1);
  add_bench_encode_command(*bench);
  add_bench_extract_command(*bench);
  add_bench_hand_command(*bench);
  add_bench_neighbours_command(*bench);
  add_bench_open_command(*bench);
  add_bench_play_command(*bench);
  add_bench_render_command(*bench);
  add_bench_stream_command(*bench);
}

}  // namespace isostrata
