#include "main/commands.h"

namespace isostrata {

void add_serve_command(CLI::App&) {}

}  // namespace isostrata
