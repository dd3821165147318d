// snapshot: the lossless picture of a session, as a file.
#include <cstdio>
#include <fstream>

#include "arguments.h"

namespace isostrata::client {

void add_snapshot(CLI::App& app, Options& options) {
  CLI::App* command = app.add_subcommand("snapshot", "Saves the lossless picture of a session");
  const auto arguments = std::make_shared<SceneArguments>();
  const auto out = std::make_shared<std::string>();
  add_scene_options(*command, *arguments);
  command->add_option("--out", *out, "The PNG file to write")->required()->type_name("FILE.png");
  command->callback([&options, arguments, out] {
    if (!out->ends_with(".png"))
      throw ClientError("bad_argument", "--out '" + *out + "': lossless pictures are PNG; expected a name that ends in .png");
    Client client = connect(options, *arguments);
    set_scene(client, *arguments);
    const v1::Frame frame = client.lossless_frame();
    std::ofstream file(*out, std::ios::binary | std::ios::trunc);
    file.write(frame.payload().data(), static_cast<std::streamsize>(frame.payload().size()));
    if (!file.flush()) throw ClientError("bad_argument", *out + ": cannot be written");
    std::fprintf(stderr, "%s: %ux%u, revision %llu, %lld tetrahedra, drawn in %.1f ms on %s\n", out->c_str(), frame.width(),
                 frame.height(), static_cast<unsigned long long>(frame.revision()),
                 static_cast<long long>(frame.facts().tetrahedra()), frame.stages().total_ms(), frame.facts().device().c_str());
  });
}

}  // namespace isostrata::client
