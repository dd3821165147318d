// A way to a server that is cut as cables are: a TCP proxy of 127.0.0.1 with a thread of its own.
#pragma once

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cstdint>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace isostrata::testing {

class CuttingProxy {
 public:
  /// To the server of this address, http://127.0.0.1:PORT/...
  explicit CuttingProxy(const std::string& url) {
    const auto colon = url.rfind(':'), slash = url.find('/', colon);
    to_ = static_cast<std::uint16_t>(std::stoi(url.substr(colon + 1, slash - colon - 1)));
    listener_ = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_in address = loopback(0);
    socklen_t size = sizeof address;
    EXPECT_EQ(bind(listener_, reinterpret_cast<sockaddr*>(&address), size), 0);
    EXPECT_EQ(listen(listener_, 16), 0);
    getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &size);
    url_ = "http://127.0.0.1:" + std::to_string(ntohs(address.sin_port)) + url.substr(slash);
    thread_ = std::thread([this] { run(); });
  }
  ~CuttingProxy() {
    over_ = true;
    thread_.join();
    close(listener_);
  }
  CuttingProxy(const CuttingProxy&) = delete;
  CuttingProxy& operator=(const CuttingProxy&) = delete;

  const std::string& url() const { return url_; }
  /// Ends all connections that there are, at once and without a goodbye; new ones pass again. Returns when it is done.
  void cut() {
    const int before = cuts_;
    cut_ = true;
    while (cuts_ == before) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  /// Until the next cut nothing passes from the server.
  void swallow_answers() { swallow_ = true; }

 private:
  struct Pair {
    int client, server;
  };

  static sockaddr_in loopback(std::uint16_t port) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(port);
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    return address;
  }

  // False: the connection has ended.
  static bool pass(int from, int to, bool swallow) {
    char bytes[65536];
    const ssize_t size = recv(from, bytes, sizeof bytes, 0);
    if (size <= 0) return false;
    for (ssize_t at = 0; at < size && !swallow;) {
      const ssize_t sent = send(to, bytes + at, static_cast<std::size_t>(size - at), MSG_NOSIGNAL);
      if (sent <= 0) return false;
      at += sent;
    }
    return true;
  }

  static void end(const Pair& pair) {
    const linger hard{1, 0};  // a reset, as from a machine that has forgotten the connection
    setsockopt(pair.client, SOL_SOCKET, SO_LINGER, &hard, sizeof hard);
    close(pair.client);
    close(pair.server);
  }

  void run() {
    std::vector<Pair> pairs;
    while (!over_) {
      if (cut_.exchange(false)) {
        for (const Pair& pair : pairs) end(pair);
        pairs.clear();
        swallow_ = false;
        ++cuts_;
      }
      std::vector<pollfd> polled{{listener_, POLLIN, 0}};
      for (const Pair& pair : pairs) {
        polled.push_back({pair.client, POLLIN, 0});
        polled.push_back({pair.server, POLLIN, 0});
      }
      if (poll(polled.data(), polled.size(), 2) <= 0) continue;
      std::vector<Pair> going_on;
      for (std::size_t i = 0; i < pairs.size(); ++i) {
        bool open = true;
        if (polled[1 + 2 * i].revents) open = pass(pairs[i].client, pairs[i].server, false);
        if (open && polled[2 + 2 * i].revents) open = pass(pairs[i].server, pairs[i].client, swallow_);
        if (open)
          going_on.push_back(pairs[i]);
        else
          close(pairs[i].client), close(pairs[i].server);
      }
      pairs = std::move(going_on);
      if (!polled[0].revents) continue;
      const int client = accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC);
      const int server = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
      const sockaddr_in address = loopback(to_);
      if (client >= 0 && connect(server, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0) {
        pairs.push_back({client, server});
      } else {
        if (client >= 0) close(client);
        close(server);
      }
    }
    for (const Pair& pair : pairs) end(pair);
  }

  std::uint16_t to_ = 0;
  int listener_ = -1;
  std::string url_;
  std::atomic<bool> over_ = false, cut_ = false, swallow_ = false;
  std::atomic<int> cuts_ = 0;
  std::thread thread_;
};

}  // namespace isostrata::testing
