// snapshot: the picture of a session, as a file.
#include <cstdio>

#include "arguments.h"

namespace isostrata::client {

void add_snapshot(CLI::App& app, Options& options) {
  CLI::App* command = app.add_subcommand("snapshot", "Saves the picture of a session, as `isostrata render` would draw it");
  const auto arguments = std::make_shared<SceneArguments>();
  const auto out = std::make_shared<std::string>();
  const auto format = std::make_shared<std::string>();
  add_scene_options(*command, *arguments);
  command->add_option("--out", *out, "The file to write, - for standard output; its end says the format")
      ->required()
      ->type_name("FILE");
  command->add_option("--format", *format,
                      "png (lossless), jpeg, or another that the server knows; by default as FILE ends, or png");
  command->callback([&options, arguments, out, format] {
    if (format->empty()) {
      const auto dot = out->rfind('.');
      const std::string end = dot == std::string::npos || out->find('/', dot) != std::string::npos ? "" : out->substr(dot + 1);
      if (end.empty() && *out != "-")
        throw ClientError("bad_argument", "--out '" + *out + "': expected a name that ends in .png, .jpg, ..., or --format");
      *format = end.empty() ? "png" : end == "jpg" ? "jpeg" : end;
    }
    Options still = options;
    still.hidden = true;  // one picture is wanted, not a stream of them
    Client client = connect(still, *arguments);
    set_scene(client, *arguments);
    int width = 0, height = 0;
    parse_size(arguments->size, width, height);
    const std::string bytes = client.still(width, height, *format);
    if (*out == "-")
      std::fwrite(bytes.data(), 1, bytes.size(), stdout);
    else
      write_file(*out, bytes);
    std::fprintf(stderr, "%s: %dx%d, revision %llu, %zu bytes\n", *out == "-" ? "standard output" : out->c_str(), width, height,
                 static_cast<unsigned long long>(client.state().revision()), bytes.size());
  });
}

}  // namespace isostrata::client
