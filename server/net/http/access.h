// Who may ask: the token, and the Host and Origin allow-lists that keep other web pages and rebound names out.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "net/http/http_message.h"
#include "net/http/request_target.h"

namespace isostrata {

struct AccessOptions {
  std::string token;                       // empty: everyone may ask (--no-auth)
  std::vector<std::string> allowed_hosts;  // "name" (any port) or "name:port", lower case; beside the loopback names
  std::vector<std::string> own_hosts;      // as these, of Host alone: the address that is listened on
  bool secure = false;                     // served over TLS: the cookies go nowhere else
  std::string base_path = "/";             // "/" or "/prefix/": where they go
  unsigned short port = 0;                 // being served; names the cookie, since browsers share cookies between ports
};

class Access {
 public:
  explicit Access(AccessOptions options);

  /// Host is one of localhost, 127.0.0.1, [::1] at any port (a tunnel may end at another one) or on the list. Exactly one Host
  /// header.
  bool host_allowed(const HttpRequest& request) const;
  /// Origin, if there is one, is that of Host itself, http or https, or on the list of allowed_hosts; "null" never is. A name
  /// without a port stands for the port that its scheme has by default, so what else runs on this machine is another origin.
  bool origin_allowed(const HttpRequest& request) const;

  /// By cookie, "Authorization: Bearer", or ?token=. Compared in constant time.
  bool token_accepted(const HttpRequest& request, const RequestTarget& target) const;
  bool token_in_query(const RequestTarget& target) const;
  /// What a cookie holds: a random id, and the proof that whoever made it knew the token. A thief of the one does not have the other,
  /// and it is good as long as the token is, also for a server that was started anew.
  struct Cookie {
    std::string id, proof;
  };
  /// All that the request brings: tokens by query and header, and cookies.
  struct Offered {
    std::vector<std::string> tokens;
    std::vector<Cookie> cookies, guest_cookies;
    bool nothing() const { return tokens.empty() && cookies.empty() && guest_cookies.empty(); }
  };
  Offered offered(const HttpRequest& request, const RequestTarget& target) const;
  /// Set-Cookie's value for a page.
  std::string set_cookie() const;
  /// The same for a page that an invitation opened; both cookies can live in one browser. secret: what its proofs are made with.
  std::string set_guest_cookie(const std::string& secret) const;
  bool token_needed() const { return !options_.token.empty(); }

 private:
  bool is_token(std::string_view text) const;
  std::string cookie(const std::string& name, const std::string& secret) const;
  bool listed(std::string_view host_and_port) const;

  const AccessOptions options_;
  const std::string cookie_, guest_cookie_;
};

}  // namespace isostrata
