// Commands that are programs of their own, which this one becomes.
#include <filesystem>
#include <string>
#include <vector>

#include "base/error.h"
#include "base/program_file.h"
#include "base/spawn.h"
#include "main/commands.h"

namespace isostrata {
namespace {

/// `before` stands in front of what is typed.
void add_program(CLI::App& app, const std::string& command_name, const std::string& help, const std::string& program_name, std::vector<std::string> before) {
  CLI::App* command = app.add_subcommand(command_name, help + " (" + program_name + ")");
  command->prefix_command();   // every word behind it is the other program's
  command->set_help_flag("");  // --help as well
  command->callback([command, program_name, before] {
    const std::filesystem::path program = program_file().parent_path() / program_name;
    if (!std::filesystem::exists(program)) throw Error(ErrorCode::unavailable, program.string() + " is not there; deploy/build " + program_name + " makes it");
    std::vector<std::string> words = before;
    for (const std::string& word : command->remaining()) words.push_back(word);
    become(program, words);
  });
}

}  // namespace

void add_bench_command(CLI::App& app) {
  add_program(app, "bench", "Measures this machine: extraction, drawing, codecs, what viewers get", "isostrata-bench", {});
}

void add_view_command(CLI::App& app) {
  add_program(app, "view", "Starts a server here or by ssh on another machine, [HOST:]PATH, and opens the browser here", "isostrata-client", {"view"});
}

}  // namespace isostrata
