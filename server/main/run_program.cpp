#include "main/run_program.h"

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <exception>
#include <new>
#include <string>
#include <vector>

#include "base/nearest_name.h"
#include "main/cache_environment.h"
#include "main/ranks.h"
#include "session/journal/protobuf_log.h"

namespace isostrata {
namespace {

std::vector<std::string> command_names(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; })) names.push_back(command->get_name());
  std::erase_if(names, [](const std::string& name) { return name.empty(); });
  return names;
}

std::vector<std::string> option_names(const CLI::App& command) {
  std::vector<std::string> names;
  for (const CLI::Option* option : command.get_options())
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  return names;
}

/// The first word that nobody expected, and what was probably meant.
std::string unexpected(const CLI::App& command) {
  for (const std::string& word : command.remaining()) {
    if (!word.starts_with('-') || word == "--") continue;
    const std::string name = word.substr(0, word.find('='));
    return "there is no option '" + name + "'." + did_you_mean(name, option_names(command));
  }
  const std::vector<std::string> words = command.remaining();
  return words.empty() ? "" : "'" + words.front() + "' is one word too many.";
}

/// Without a full stop at its end.
std::string said(const CLI::ParseError& error) {
  std::string text = error.what();
  while (text.ends_with('\n') || text.ends_with('.')) text.pop_back();
  return text;
}

/// What is wrong and where to read on, as one line.
std::string wrong_usage(const CLI::App& app, const CLI::ParseError& error) {
  const std::vector<const CLI::App*> chosen = app.get_subcommands([&app](const CLI::App* command) { return app.got_subcommand(command->get_name()); });
  const CLI::App& command = chosen.empty() ? app : *chosen.front();
  const std::string name = chosen.empty() ? app.get_name() : app.get_name() + " " + command.get_name();
  std::string what = said(error) + ".";
  if (const std::vector<std::string> words = app.remaining(); chosen.empty() && !words.empty() && !words.front().starts_with('-'))
    what = "there is no command '" + words.front() + "'." + did_you_mean(words.front(), command_names(app));
  else if (const std::string word = unexpected(command); !word.empty())
    what = word;
  else if (chosen.empty() && dynamic_cast<const CLI::RequiredError*>(&error))
    what = "a command is missing.";
  return name + ": " + what + " " + name + " --help lists " + (chosen.empty() ? "the commands." : "what it takes.");
}

/// `help COMMAND` and `help` are COMMAND --help and --help.
std::vector<std::string> without_help_word(std::vector<std::string> words) {
  if (words.empty() || words.front() != "help") return words;
  words.erase(words.begin());
  words.resize(std::min<std::size_t>(words.size(), 1));
  words.push_back("--help");
  return words;
}

}  // namespace

int run_program(CLI::App& app, int argc, char** argv) {
  std::signal(SIGXFSZ, SIG_IGN);  // a limit on the size of files is an error of the write, not the end of the program
  silence_protobuf();             // a server has it speak through its log; a worker's lines would be nobody's
  app.set_version_flag("-V,--version", "isostrata " ISOSTRATA_VERSION);
  set_command_line(argc, argv);
  std::vector<std::string> words = without_help_word({argv + 1, argv + argc});
  if (words.empty()) words.push_back("--help");
  try {
    use_simd_level_of_environment();
    set_import_cache(import_cache_of_environment());
    std::reverse(words.begin(), words.end());  // CLI11 takes them from the back
    app.parse(words);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);
    std::fprintf(stderr, "%s\n", wrong_usage(app, error).c_str());
    return 2;
  } catch (const std::bad_alloc&) {
    std::fprintf(stderr, "isostrata: out of memory\n");
    return 1;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "isostrata: %s\n", error.what());
    return 1;
  }
  return 0;
}

}  // namespace isostrata
