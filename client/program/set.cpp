// set: changes what a session shows, for scripts; and its whole state as a file.
#include <algorithm>
#include <charconv>
#include <cstdio>
#include <fstream>
#include <sstream>

#include "arguments.h"

namespace isostrata::client {
namespace {

struct SetArguments {
  SceneArguments scene;
  std::vector<std::string> moves;
  std::string load, save;
};

// "ID=LOWER:UPPER".
struct Move {
  std::uint32_t id = 0;
  double lower = 0, upper = 0;
};
Move parse_move(const std::string& text) {
  const auto equals = text.find('=');
  Move move;
  const char* end = text.data() + std::min(equals, text.size());
  const auto [at, error] = std::from_chars(text.data(), end, move.id);
  if (equals == std::string::npos || error != std::errc{} || at != end)
    throw ClientError("bad_argument", "--move '" + text + "': expected ID=LOWER:UPPER; `info --session` tells the ids");
  const v1::Interval ends = parse_interval(text.substr(equals + 1), 0);
  move.lower = ends.lower();
  move.upper = ends.upper();
  return move;
}

void set(const Options& options, const SetArguments& arguments) {
  std::vector<Move> moves;  // wrong usage is said before anything is changed
  for (const std::string& text : arguments.moves) moves.push_back(parse_move(text));
  Client client = connect(options, arguments.scene);
  if (!arguments.load.empty()) {
    std::ifstream file(arguments.load, std::ios::binary);
    std::ostringstream text;
    text << file.rdbuf();
    if (!file) throw ClientError("not_found", arguments.load + ": cannot be read");
    client.restore_state(text.str());
  }
  set_scene(client, arguments.scene);
  for (const Move& move : moves) client.move_interval(move.id, move.lower, move.upper);
  if (!arguments.save.empty()) write_file(arguments.save, client.save_state() + "\n");
  std::printf("session  %s shows %s at revision %llu\n", client.welcome().session().c_str(), client.state().dataset().c_str(),
              static_cast<unsigned long long>(client.state().revision()));
}

}  // namespace

void add_set(CLI::App& app, Options& options) {
  CLI::App* command =
      app.add_subcommand("set", "Changes what a session shows before whoever looks at it; keeps and brings back states");
  const auto arguments = std::make_shared<SetArguments>();
  arguments->scene.size.clear();
  add_scene_options(*command, arguments->scene);
  command->remove_option(command->get_option("--size"));
  command->add_option("--move", arguments->moves, "ID=LOWER:UPPER: gives one interval other ends; may be repeated")
      ->type_name("ID=LOWER:UPPER");
  command->add_option("--load-state", arguments->load, "A saved state, which comes first")->type_name("FILE.json");
  command->add_option("--save-state", arguments->save, "Where the state goes after all changes")->type_name("FILE.json");
  command->callback([&options, arguments] { set(options, *arguments); });
}

}  // namespace isostrata::client
