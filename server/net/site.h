// What one port serves: the page, the API, and whether a WebSocket may open. Every rule of access is applied here, in one order.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "net/access.h"
#include "net/http_message.h"
#include "net/rest_api.h"
#include "net/static_files.h"

namespace isostrata {

struct SiteOptions {
  std::string base_path = "/";  // "/" or "/prefix/"
  std::filesystem::path web_root;
  AccessOptions access;
};

/// Not thread-safe: lives on the io thread.
class Site {
 public:
  Site(SiteOptions options, Sessions& sessions);

  /// Answers anything that is not a WebSocket; replies once, now or later.
  void handle(const HttpRequest& request, HttpReply reply);
  /// Nothing where the upgrade is welcome, else the refusal. admission: which session an invitation opens; empty for the server's
  /// own token.
  std::optional<HttpResponse> refuse_upgrade(const HttpRequest& request, Sessions::Admission& admission) const;

  const std::string& base_path() const { return options_.base_path; }

 private:
  HttpResponse unauthorized(bool page) const;
  /// Whether the request brings the token of an invitation that is good, and for what.
  std::optional<Sessions::Admission> invited(const HttpRequest& request, const RequestTarget& target) const;
  /// The segments below the base path; nothing where the target is not below it.
  std::optional<std::vector<std::string>> below_base(const RequestTarget& target) const;

  const SiteOptions options_;
  const std::vector<std::string> base_segments_;
  const Access access_;
  const StaticFiles files_;
  RestApi api_;
  Sessions& sessions_;
};

/// "/prefix/" from "prefix", "/prefix" or "https://name/prefix"; of the last also the host. Throws invalid_argument.
std::string parse_base_url(const std::string& url, std::string& host);

}  // namespace isostrata
