// isostrata: the server and its offline twin.
#include "main/commands.h"
#include "main/run_program.h"

int main(int argc, char** argv) {
  CLI::App app{"Isostrata: interval volumes of scalar fields, extracted exactly, rendered here, seen in a browser", "isostrata"};
  app.require_subcommand(1);
  isostrata::add_serve_command(app);
  isostrata::add_info_command(app);
  isostrata::add_first_view_command(app);
  isostrata::add_extract_command(app);
  isostrata::add_render_command(app);
  isostrata::add_measure_command(app);
  isostrata::add_components_command(app);
  isostrata::add_section_command(app);
  isostrata::add_partition_command(app);
  isostrata::add_tables_command(app);
  isostrata::add_doctor_command(app);
  isostrata::add_cache_command(app);
  isostrata::add_worker_command(app);
  for (CLI::App* command : app.get_subcommands({})) isostrata::add_simd_option(*command);
  isostrata::add_bench_command(app);  // its own program has that option
  isostrata::add_view_command(app);
  return isostrata::run_program(app, argc, argv);
}
