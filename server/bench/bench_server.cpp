#include "bench/bench_server.h"

#include <algorithm>
#include <array>
#include <boost/json/parse.hpp>
#include <cstdio>
#include <system_error>

#include "base/error.h"
#include "base/program_file.h"
#include "data/open/child_process.h"
#include "engine/data/catalogue.h"
#include "main/arguments.h"
#include "main/layer_arguments.h"
#include "main/picture_arguments.h"
#include "session/wire/random_token.h"

namespace isostrata {

BenchServer::BenchServer(std::vector<std::string> data, const std::string& renderer, const std::string& device)
    : token_(random_token(192)) {
  ServerOptions options;
  options.engine.catalogue = Catalogue::from_sources(data);
  options.engine.renderer_choice = {renderer, device};
  options.port = 0;
  options.token = token_;
  server_ = std::make_unique<Server>(std::move(options));
  thread_ = std::thread([this] { server_->run(false); });
}

BenchServer::~BenchServer() {
  server_->stop("the measurement is over");
  thread_.join();
}

std::string BenchServer::url(unsigned short port) const {
  return "http://127.0.0.1:" + std::to_string(port) + "/?token=" + token_;
}

ScratchFile::ScratchFile(const char* extension)
    : path(std::filesystem::temp_directory_path() / ("isostrata-bench-" + random_token(64) + extension)) {}

ScratchFile::~ScratchFile() {
  std::error_code ignored;
  std::filesystem::remove(path, ignored);
}

FirstView first_view_of(const std::string& data) {
  const StepSource steps = step_source(data);
  FirstView view = first_view(*steps(0, command_task()), steps, {}, command_task());
  if (view.array.empty()) throw Error(ErrorCode::not_found, data + ": nothing to show: " + view.array_reason);
  return view;
}

std::string camera_text(const FirstView& view, const std::string& size) {
  const auto [width, height] = parse_size(size);
  const Camera camera = view.camera(std::min(1.0, static_cast<double>(width) / height));
  std::array<char, 400> text{};
  std::snprintf(text.data(), text.size(), "eye=%.17g,%.17g,%.17g;at=%.17g,%.17g,%.17g;up=%.17g,%.17g,%.17g;fov=%.17g",
                camera.eye.x, camera.eye.y, camera.eye.z, camera.at.x, camera.at.y, camera.at.z, camera.up.x, camera.up.y,
                camera.up.z, camera.fov_deg);
  return text.data();
}

std::filesystem::path beside_this_program(const char* name) {
  const std::filesystem::path path = program_file().parent_path() / name;
  if (!std::filesystem::exists(path))
    throw Error(ErrorCode::unavailable, path.string() + " is not there; build the target " + name);
  return path;
}

boost::json::value run_json(const std::filesystem::path& program, const std::vector<std::string>& arguments, double timeout_s) {
  std::string text;
  const ChildResult result =
      run_child({program, arguments, {}}, timeout_s, command_task(), [&](std::string_view line) { text += line; });
  if (result.signal != 0 || result.exit_status != 0)
    throw Error(ErrorCode::unavailable, program.filename().string() + " failed: " + result.errors);
  return boost::json::parse(text);
}

}  // namespace isostrata
