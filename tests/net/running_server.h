// A real server on a free port, in this process, with a renderer that needs no OpenGL.
#pragma once

#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <thread>

#include "isostrata/client.h"
#include "net/raw_socket.h"
#include "net/server/server.h"
#include "support/plain_renderer.h"
#include "support/temporary_folder.h"

namespace isostrata {

class RunningServer {
 public:
  static constexpr const char* kToken = "0123456789abcdef0123456789abcdef0123456789abcdef";
  static inline const std::string kBearer = std::string("Authorization: Bearer ") + kToken + "\r\n";

  explicit RunningServer(ServerOptions options = {}) {
    options.port = 0;
    options.token = kToken;
    if (options.engine.catalogue.entries().empty()) options.engine.catalogue = Catalogue::from_sources({"torus:12", "tets:6"});
    options.engine.renderer = [control = control] { return std::make_unique<PlainRenderer>(control); };
    server_ = std::make_unique<Server>(std::move(options));
    thread_ = std::thread([this] { server_->run(false); });
  }
  ~RunningServer() { end(); }
  void end() {
    if (!thread_.joinable()) return;
    server_->stop("the test ends");
    thread_.join();
  }

  const FrameEngine& engine() const { return server_->engine(); }
  unsigned short port() const { return server_->port(); }
  client::Options client_options() const {
    client::Options options;
    options.url = server_->url();
    options.timeout = std::chrono::milliseconds(20000);
    options.width = 64;
    options.height = 48;
    return options;
  }
  /// The response to one request; the token goes along.
  std::string ask(const std::string& method, const std::string& target, const std::string& body = "",
                  const std::string& headers = "") const {
    RawSocket socket(port());
    socket.send(method + " " + target + " HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\nAuthorization: Bearer " + kToken +
                "\r\n" + headers + (body.empty() ? "" : "Content-Length: " + std::to_string(body.size()) + "\r\n") + "\r\n" +
                body);
    return socket.read_all();
  }
  /// What /healthz says to whoever has the token.
  std::string health() const { return ask("GET", "/healthz"); }
  bool answers() const {
    return raw("GET /healthz HTTP/1.1\r\nHost: x\r\nConnection: close\r\n\r\n").starts_with("HTTP/1.1 200");
  }
  std::string raw(const std::string& bytes) const {
    RawSocket socket(port());
    socket.send(bytes);
    return socket.read_all();
  }

  std::shared_ptr<PlainRendererControl> control = std::make_shared<PlainRendererControl>();

 private:
  std::unique_ptr<Server> server_;
  std::thread thread_;
};

inline int status_of(const std::string& response) { return response.size() > 12 ? std::atoi(response.c_str() + 9) : 0; }
inline bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

}  // namespace isostrata
