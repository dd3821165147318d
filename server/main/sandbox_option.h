// --sandbox, which the commands that read files have.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "data/open/sandbox.h"

namespace isostrata {

/// Obeyed before the command's callback. `otherwise` says what holds if neither it nor $ISOSTRATA_SANDBOX is given; `what` loses its rights.
inline void add_sandbox_option(CLI::App& command, const std::string& otherwise = "try", const std::string& what = "the process that reads files") {
  command
      .add_option_function<std::string>("--sandbox", [](const std::string& name) { use_sandbox(name); },
                                        "Take away the rights of " + what + ": require (and do nothing if the kernel cannot), try (as far as the kernel can) or off (default: $ISOSTRATA_SANDBOX, else " +
                                            otherwise + ")")
      ->check(CLI::IsMember({"require", "try", "off"}))
      ->type_name("HOW")
      ->trigger_on_parse();
}

}  // namespace isostrata
