// export: the layers of a session as a mesh file.
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "arguments.h"

namespace isostrata::client {
namespace {

struct ExportArguments {
  SceneArguments scene;
  std::string out;
  std::vector<std::string> facets;
};

void export_layers(const Options& options, const ExportArguments& arguments) {
  const auto dot = arguments.out.rfind('.');
  const std::string format = dot == std::string::npos ? "" : arguments.out.substr(dot + 1);
  if (format != "vtu" && format != "vtkhdf" && format != "ply" && format != "stl")
    throw ClientError("bad_argument", "--out '" + arguments.out + "': expected a name that ends in .vtu, .vtkhdf, .ply or .stl");
  Client client = connect(options, arguments.scene);
  set_scene(client, arguments.scene);
  // It has its name only when it is complete.
  const std::string part = arguments.out + ".part";
  struct Remove {
    const std::string& path;
    ~Remove() {
      std::error_code ignored;
      std::filesystem::remove(path, ignored);
    }
  } remove{part};
  std::ofstream file(part, std::ios::binary | std::ios::trunc);
  if (!file) throw ClientError("unwritable", arguments.out + ": cannot be written");
  client.export_mesh(file, format, arguments.facets);
  file.close();
  std::error_code error;
  const auto bytes = std::filesystem::file_size(part, error);
  if (file) std::filesystem::rename(part, arguments.out, error);
  if (!file || error) throw ClientError("unwritable", arguments.out + ": cannot be written");
  std::fprintf(stderr, "%s: revision %llu, %llu bytes\n", arguments.out.c_str(),
               static_cast<unsigned long long>(client.state().revision()), static_cast<unsigned long long>(bytes));
}

}  // namespace

void add_export(CLI::App& app, Options& options) {
  CLI::App* command =
      app.add_subcommand("export", "Saves the layers of a session as a mesh, as `isostrata extract` would write it");
  const auto arguments = std::make_shared<ExportArguments>();
  arguments->scene.size.clear();
  add_scene_options(*command, arguments->scene);
  command->remove_option(command->get_option("--size"));
  command->add_option("--out", arguments->out, ".vtu, .vtkhdf: tetrahedra; .ply, .stl: their boundary")->required()->type_name("FILE");
  command->add_option("--facets", arguments->facets, "Of .ply and .stl, any of lower, upper and domain; by default all")
      ->delimiter(',')
      ->check(CLI::IsMember({"lower", "upper", "domain"}));
  command->callback([&options, arguments] { export_layers(options, *arguments); });
}

}  // namespace isostrata::client
