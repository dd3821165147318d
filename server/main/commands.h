// The commands of `isostrata`, one file each. Every add_*_command gives the app a subcommand whose callback does the work.
// Exit status: 0 done; 1 it failed (an Error, printed as one line); 2 wrong usage.
#pragma once

#include <CLI/CLI.hpp>

namespace isostrata {

void add_serve_command(CLI::App& app);
void add_info_command(CLI::App& app);
void add_first_view_command(CLI::App& app);
void add_extract_command(CLI::App& app);
void add_render_command(CLI::App& app);
void add_measure_command(CLI::App& app);
void add_components_command(CLI::App& app);
void add_section_command(CLI::App& app);
void add_partition_command(CLI::App& app);
void add_bench_command(CLI::App& app);
void add_tables_command(CLI::App& app);
void add_doctor_command(CLI::App& app);
void add_cache_command(CLI::App& app);
void add_view_command(CLI::App& app);
void add_worker_command(CLI::App& app);

}  // namespace isostrata
