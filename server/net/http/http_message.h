// A request and its response as plain data, so that what answers them needs neither sockets nor Beast.
#pragma once

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace isostrata {

class EventStream;

using HttpHeaders = std::vector<std::pair<std::string, std::string>>;

/// What is to be done where whoever asked is gone before the answer. Set by what answers, on the io thread; called there, once.
struct ClientGone {
  std::function<void()> then;
};

struct HttpRequest {
  std::string method;  // "GET"
  std::string target;  // as it came: "/a%20b?x=1"
  std::string body;
  HttpHeaders headers;  // names in lower case
  std::shared_ptr<ClientGone> gone;  // null: nobody watches
  std::string address{};  // of who asks; empty: not known

  /// Empty if there is none.
  std::string_view header(std::string_view name) const {
    for (const auto& [key, value] : headers)
      if (key == name) return value;
    return {};
  }
  std::size_t header_count(std::string_view name) const {
    return static_cast<std::size_t>(
        std::count_if(headers.begin(), headers.end(), [&](const auto& h) { return h.first == name; }));
  }
};

struct HttpResponse {
  int status = 200;
  std::string content_type;
  std::string body;
  HttpHeaders headers;
  // In place of `body`:
  std::filesystem::path file{};           // its bytes, read while they are sent
  std::shared_ptr<EventStream> events{};  // until they end or the client goes
};

/// Called once, on the io thread, at once or later.
using HttpReply = std::function<void(HttpResponse response)>;

}  // namespace isostrata
