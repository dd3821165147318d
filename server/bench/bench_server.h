// For measurements of what a viewer gets: a real server in this process, and isostrata-client in a process of its own.
#pragma once

#include <boost/json/value.hpp>
#include <filesystem>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "engine/first/first_view.h"
#include "net/server/server.h"

namespace isostrata {

/// Serves on a thread of its own until it goes.
class BenchServer {
 public:
  /// data: files or names of analytic data. renderer and device as --renderer and --device have them. Throws what opening a port
  /// throws.
  BenchServer(std::vector<std::string> data, const std::string& renderer, const std::string& device);
  ~BenchServer();
  BenchServer(const BenchServer&) = delete;
  BenchServer& operator=(const BenchServer&) = delete;

  unsigned short port() const { return server_->port(); }
  const std::string& token() const { return token_; }
  /// By this port, which may be that of a link that leads here.
  std::string url(unsigned short port) const;

 private:
  const std::string token_;
  std::unique_ptr<Server> server_;
  std::thread thread_;
};

/// The name of a file of our own in the temporary folder, which is gone with this.
struct ScratchFile {
  explicit ScratchFile(const char* extension);
  ~ScratchFile();
  ScratchFile(const ScratchFile&) = delete;
  ScratchFile& operator=(const ScratchFile&) = delete;
  const std::filesystem::path path;
};

/// What a session of the data begins with: the server's own choice. Throws not_found if there is nothing to show, and what
/// opening throws.
FirstView first_view_of(const std::string& data);

/// As --camera has it: that of a session which has just opened the data, in a window of this size ("1280x720").
std::string camera_text(const FirstView& view, const std::string& size);

/// Throws unavailable if it was not built.
std::filesystem::path beside_this_program(const char* name);

/// What the program prints. Throws unavailable with its own words if it fails, or does not end in time.
boost::json::value run_json(const std::filesystem::path& program, const std::vector<std::string>& arguments, double timeout_s);

}  // namespace isostrata
