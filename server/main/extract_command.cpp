#include "main/commands.h"

namespace isostrata {

void add_extract_command(CLI::App&) {}

}  // namespace isostrata
