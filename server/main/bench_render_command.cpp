#include "main/commands.h"

namespace isostrata {

void add_bench_render_command(CLI::App&) {}

}  // namespace isostrata
