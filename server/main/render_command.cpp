#include "main/commands.h"

namespace isostrata {

void add_render_command(CLI::App&) {}

}  // namespace isostrata
