// What the commands of isostrata-client have in common.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "isostrata/client.h"

namespace isostrata::client {

/// How a session is set before it is looked at.
struct SceneArguments {
  std::string dataset;  // id or name; empty: what the session shows, else the first
  std::string array;
  std::vector<std::string> intervals;
  std::string transfer;  // file; empty: none
  std::string size = "800x600";
  std::string camera;
  std::string session;  // id, or resume token, of the session to join
};

void add_scene_options(CLI::App& command, SceneArguments& arguments);

/// Connects at the wanted size, joining the session that is named. Throws ClientError.
Client connect(Options options, const SceneArguments& arguments);
/// Opens the dataset and sets array, intervals and camera as far as they are given.
void set_scene(Client& client, const SceneArguments& arguments);

/// Writes a file that has its name only when it is complete. Throws ClientError.
void write_file(const std::string& path, const std::string& bytes);

/// "LOWER:UPPER[,color=#rrggbb|map:NAME][,opacity=X][,priority=N]". Throws ClientError "bad_argument".
v1::Interval parse_interval(const std::string& text, std::size_t index);
/// "eye=x,y,z;at=x,y,z;up=x,y,z;fov=deg", each part optional over `base`.
v1::Camera parse_camera(const std::string& text, const v1::Camera& base);
void parse_size(const std::string& text, int& width, int& height);

void add_info(CLI::App& app, Options& options);
void add_snapshot(CLI::App& app, Options& options);
void add_set(CLI::App& app, Options& options);
void add_export(CLI::App& app, Options& options);
void add_record(CLI::App& app, Options& options);
void add_watch(CLI::App& app, Options& options);
void add_latency(CLI::App& app, Options& options);
void add_tunnel(CLI::App& app, Options& options);
void add_view(CLI::App& app, Options& options);

}  // namespace isostrata::client
