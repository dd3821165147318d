// What `isostrata serve` is asked for.
#pragma once

#include <CLI/CLI.hpp>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace isostrata {

struct ServeArguments {
  std::vector<std::string> paths;
  std::vector<std::string> data_roots;
  std::string host = "127.0.0.1";
  int port = 8080;
  std::string socket;
  std::string base_url = "/";
  std::string token;
  std::string token_file;
  bool no_auth = false;
  std::vector<std::string> allowed_hosts;
  std::string tls_certificate, tls_key;
  std::string renderer = "auto", device = "auto";
  std::size_t max_sessions = 32;
  std::size_t max_viewers = 64;
  std::string max_viewer_size = "4096x2160";
  std::string state_dir;
  long session_ttl_s = 600;
  long idle_timeout_s = 0;
  std::uint64_t max_memory = 8ull << 30;
  int threads = 0;
  std::string ranks;
  std::string ready_file;
  std::string log_format = "text";
  std::string web_root;
  std::string watch = "auto";
};

/// Also those of a configuration file.
void add_serve_options(CLI::App& command, ServeArguments& arguments);

}  // namespace isostrata
