// What one port serves: the page, the API, probes and metrics, and whether a WebSocket may open. Every rule of access is applied
// here, in one order; every answer is counted and logged here.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "net/http/access.h"
#include "net/http/http_message.h"
#include "net/http/places.h"
#include "net/rest/rest_api.h"
#include "net/site/metrics.h"
#include "net/site/site_log.h"
#include "net/site/static_files.h"

namespace isostrata {

struct SiteOptions {
  std::string base_path = "/";  // "/" or "/prefix/"
  std::filesystem::path web_root;
  AccessOptions access;
  LogSink log;
};

/// Not thread-safe: lives on the io thread.
class Site {
 public:
  Site(SiteOptions options, Sessions& sessions);

  /// Answers anything that is not a WebSocket; replies once, now or later. The answer names its request, by X-Request-Id: the
  /// client's own where it sends a decent one.
  void handle(const HttpRequest& request, HttpReply reply);
  /// The connection answered by itself: what came was no request, or too large.
  void refused(int status) { metrics_.http_answered("", "", status, 0, 0); }
  /// Says 503 at /readyz from now on: the server ends.
  void end(const std::string& reason) { ending_ = reason.empty() ? "the server ends" : reason; }
  /// Open connections, for the metrics.
  void set_connections(std::size_t open) { connections_ = open; }

  Metrics& metrics() { return metrics_; }
  const SiteLog& log() const { return log_; }
  const RestApi& api() const { return api_; }
  /// What a request's head says before anything else of it is read.
  struct Head {
    Caller caller = Caller::stranger;
    bool may_send_body = false;  // it is answered without its body where not
    bool wrong_token = false;    // it brings one, and no right one
  };
  Head look_at_head(const HttpRequest& head) const;
  /// Nothing if the upgrade is welcome, else the refusal. admission: which session an invitation opens; empty for the server's
  /// own token.
  std::optional<HttpResponse> refuse_upgrade(const HttpRequest& request, Sessions::Admission& admission) const;

  const std::string& base_path() const { return options_.base_path; }

 private:
  /// Sets `route` to the template that was found.
  void dispatch(const HttpRequest& request, const std::optional<RequestTarget>& target, HttpReply reply, std::string* route);
  HttpResponse ready() const;
  HttpResponse metrics_text();
  HttpResponse unauthorized(bool page) const;
  /// Whether the request brings the token of an invitation that is good, and for what.
  std::optional<Sessions::Admission> invited(const HttpRequest& request, const RequestTarget& target) const;
  /// The segments below the base path; nothing if the target is not below it.
  std::optional<std::vector<std::string>> below_base(const RequestTarget& target) const;

  const SiteOptions options_;
  const std::vector<std::string> base_segments_;
  const Access access_;
  const StaticFiles files_;
  Sessions& sessions_;
  Metrics metrics_;
  SiteLog log_;
  RestApi api_;
  std::size_t connections_ = 0;
  std::uint64_t last_request_ = 0;
  const std::string request_prefix_;  // so that numbers of two runs differ
  std::string ending_;                // why; empty: it goes on
};

/// "/prefix/" from "prefix", "/prefix" or "https://name/prefix"; of the last also the host. Throws invalid_argument.
std::string parse_base_url(const std::string& url, std::string& host);

}  // namespace isostrata
