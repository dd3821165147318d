#include "main/commands.h"

namespace isostrata {

void add_doctor_command(CLI::App&) {}

}  // namespace isostrata
