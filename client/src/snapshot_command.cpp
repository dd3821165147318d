#include <cstdio>
#include <fstream>
#include <memory>

#include "commands.h"

namespace isostrata::client {
namespace {

void save(const std::string& path, const std::string& bytes) {
  std::ofstream file(path, std::ios::binary);
  file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  file.close();
  if (!file) throw Error("unavailable", path + " cannot be written");
}

}  // namespace

void add_snapshot_command(CLI::App& app, const std::string& url) {
  struct Arguments {
    SceneArguments scene;
    std::string session;
    std::string out;
    double timeout_s = 120;
  };
  auto* command = app.add_subcommand("snapshot", "Saves one lossless frame as PNG: of a scene given here, or of a living session");
  auto arguments = std::make_shared<Arguments>();
  arguments->scene.add_to(*command);
  command->add_option("--session", arguments->session, "Id of a living session: saves what it shows, changes nothing");
  command->add_option("--out", arguments->out, "File to write (.png)")->required();
  command->add_option("--timeout", arguments->timeout_s, "Seconds to wait for the picture")->capture_default_str();
  command->callback([&url, arguments] {
    if (!arguments->out.ends_with(".png")) throw Error("invalid_argument", arguments->out + ": a snapshot is a .png");
    const auto timeout = std::chrono::milliseconds(static_cast<long>(arguments->timeout_s * 1000));
    if (!arguments->session.empty()) {
      std::uint32_t width = 0, height = 0;
      parse_size(arguments->scene.size, width, height);
      save(arguments->out, http_get(parse_address(url),
                                    "api/v1/sessions/" + arguments->session + "/image?width=" + std::to_string(width) +
                                        "&height=" + std::to_string(height) + "&format=png",
                                    timeout));
      return;
    }
    std::uint64_t seq = 0;
    Connection connection = arguments->scene.open(url, seq);
    v1::ClientMessage message;
    message.mutable_request_still();
    connection.send(std::move(message));
    const v1::Frame frame = connection.wait_for_frame(seq, true, timeout);
    save(arguments->out, frame.payload());
    std::fprintf(stderr, "%s: %ux%u, %lld tetrahedra, %s, %s\n", arguments->out.c_str(), frame.width(), frame.height(),
                 static_cast<long long>(frame.facts().tetrahedra()), frame.facts().order().c_str(), frame.facts().device().c_str());
  });
}

}  // namespace isostrata::client
