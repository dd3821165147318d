// isostrata-bench: the benchmarks, which `isostrata bench` starts. A program of its own, so that the server carries none of it.
#include "bench/commands.h"
#include "main/run_program.h"

int main(int argc, char** argv) {
  CLI::App app{"Measures this machine: min, median and max of many runs, as JSON with --json", "isostrata bench"};
  app.require_subcommand(1);
  isostrata::add_bench_encode_command(app);
  isostrata::add_bench_extract_command(app);
  isostrata::add_bench_hand_command(app);
  isostrata::add_bench_neighbours_command(app);
  isostrata::add_bench_open_command(app);
  isostrata::add_bench_play_command(app);
  isostrata::add_bench_render_command(app);
  isostrata::add_bench_stream_command(app);
  isostrata::add_simd_option(app);
  return isostrata::run_program(app, argc, argv);
}
