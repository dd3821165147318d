// The commands of `isostrata-client URL COMMAND`, one file each, and the arguments that they share.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "isostrata/client.h"

namespace isostrata::client {

void add_info_command(CLI::App& app, const std::string& url);
void add_snapshot_command(CLI::App& app, const std::string& url);
void add_latency_command(CLI::App& app, const std::string& url);

/// "WxH", both 1..16384. Throws "invalid_argument".
void parse_size(const std::string& text, std::uint32_t& width, std::uint32_t& height);

/// "LOWER:UPPER[,color=#rrggbb|map:NAME][,opacity=X][,priority=N]"; the same words as `isostrata render`. Throws "invalid_argument".
v1::Interval parse_interval(const std::string& text, std::size_t index);

/// What snapshot and latency show: everything optional.
struct SceneArguments {
  std::string dataset;  // id or name
  std::string array;
  std::string color_by;
  std::vector<std::string> intervals;
  std::string view;  // "reset", "+x", ...
  std::string size = "800x600";
  std::string resume;

  void add_to(CLI::App& command);
  /// Connects and brings the session to what the arguments say; last_seq is the last command's, 0 where none was needed.
  Connection open(const std::string& url, std::uint64_t& last_seq) const;
};

}  // namespace isostrata::client
