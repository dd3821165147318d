#include "main/commands.h"

namespace isostrata {

void add_tables_command(CLI::App&) {}

}  // namespace isostrata
