#include "main/commands.h"

namespace isostrata {

void add_info_command(CLI::App&) {}

}  // namespace isostrata
