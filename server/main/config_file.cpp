#include "main/config_file.h"

#include <fstream>
#include <memory>
#include <string>
#include <vector>

namespace isostrata {
namespace {

/// The parser takes any text for a name, so a file that is not a configuration is told by its first name.
void apply_file(CLI::App& command, const std::string& path) {
  std::ifstream in(path);
  if (!in) throw CLI::ValidationError("--config", path + ": cannot be read");
  for (const CLI::ConfigItem& item : CLI::ConfigTOML().from_config(in)) {
    if (item.name == "++" || item.name == "--") continue;  // the parser's marks where a [section] begins and ends
    CLI::Option* option = item.parents.empty() ? command.get_option_no_throw("--" + item.name) : nullptr;
    if (!option || option->get_lnames().empty() || item.name == "config" || item.name == "help")
      throw CLI::ValidationError("--config", path + ": no option '" + item.fullname() + "'; expected a long option of '" +
                                                 command.get_name() + "' without its dashes");
    if (option->count() > 0) continue;
    const bool flag = option->get_expected_max() == 0;
    if (flag && item.inputs.size() == 1 && (item.inputs[0] == "false" || item.inputs[0] == "0")) continue;
    try {
      option->add_result(flag ? std::vector<std::string>{option->get_flag_value(item.name, item.inputs.front())} : item.inputs);
      option->run_callback();
    } catch (const CLI::ParseError& error) {
      throw CLI::ValidationError("--config", path + ": " + item.name + ": " + error.what());
    }
  }
}

}  // namespace

void add_config_option(CLI::App& command) {
  const auto path = std::make_shared<std::string>();
  command.add_option("--config", *path, "Read further options from this TOML file: `port = 8080`; the command line comes first")
      ->type_name("FILE");
  command.parse_complete_callback([&command, path] {
    if (!path->empty()) apply_file(command, *path);
  });
}

}  // namespace isostrata
