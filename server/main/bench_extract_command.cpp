#include "main/commands.h"

namespace isostrata {

void add_bench_extract_command(CLI::App&) {}

}  // namespace isostrata
