#include "net/http/access.h"

#include "session/wire/random_token.h"

namespace isostrata {
namespace {

std::string lower(std::string_view text) {
  std::string out(text);
  for (char& c : out) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return out;
}

// "name:80" -> "name"; "[::1]:80" -> "[::1]". Empty if the port is not a number.
std::string_view name_of(std::string_view host) {
  const auto bracket = host.rfind(']');
  const auto colon = host.rfind(':');
  if (colon == std::string_view::npos || (bracket != std::string_view::npos && colon < bracket)) return host;
  const std::string_view port = host.substr(colon + 1);
  if (port.empty() || port.size() > 5 || port.find_first_not_of("0123456789") != std::string_view::npos) return {};
  return host.substr(0, colon);
}

/// Names that a browser takes from https alone, and the first of them from this very host alone (RFC 6265bis, section 4.1.3).
std::string prefix_of(const AccessOptions& options) {
  if (!options.secure) return "";
  return options.base_path == "/" ? "__Host-" : "__Secure-";
}

}  // namespace

Access::Access(AccessOptions options)
    : options_(std::move(options)),
      cookie_(prefix_of(options_) + "isostrata_" + std::to_string(options_.port)),
      guest_cookie_(prefix_of(options_) + "isostrata_guest_" + std::to_string(options_.port)) {}

bool Access::listed(std::string_view host_and_port) const {
  const std::string_view name = name_of(host_and_port);
  if (name == "localhost" || name == "127.0.0.1" || name == "[::1]") return true;
  if (name.empty()) return false;
  for (const auto* list : {&options_.allowed_hosts, &options_.own_hosts})
    for (const std::string& allowed : *list)
      if (allowed == host_and_port || allowed == name) return true;
  return false;
}

bool Access::host_allowed(const HttpRequest& request) const {
  return request.header_count("host") == 1 && listed(lower(request.header("host")));
}

bool Access::origin_allowed(const HttpRequest& request) const {
  const std::size_t count = request.header_count("origin");
  if (count == 0) return true;
  if (count > 1) return false;
  std::string origin = lower(request.header("origin"));
  if (origin.starts_with("https://"))
    origin.erase(0, 8);
  else if (origin.starts_with("http://"))
    origin.erase(0, 7);
  else
    return false;
  if (origin == lower(request.header("host"))) return true;
  for (const std::string& allowed : options_.allowed_hosts)
    if (allowed == origin) return true;
  return false;
}

bool Access::is_token(std::string_view text) const { return equal_in_constant_time(std::string(text), options_.token); }

bool Access::token_in_query(const RequestTarget& target) const {
  const auto it = target.query.find("token");
  return token_needed() && it != target.query.end() && is_token(it->second);
}

Access::Offered Access::offered(const HttpRequest& request, const RequestTarget& target) const {
  Offered all;
  if (const auto it = target.query.find("token"); it != target.query.end()) all.tokens.push_back(it->second);
  for (const auto& [name, value] : request.headers) {
    if (name == "authorization" && lower(std::string_view(value).substr(0, 7)) == "bearer ") {
      all.tokens.push_back(value.substr(7));
    } else if (name == "cookie") {
      std::string_view rest = value;
      while (!rest.empty()) {
        const auto at = rest.find(';');
        std::string_view pair = rest.substr(0, at);
        rest = at == std::string_view::npos ? std::string_view{} : rest.substr(at + 1);
        while (pair.starts_with(' ')) pair.remove_prefix(1);
        for (const auto& [cookie, to] : {std::pair{&cookie_, &all.cookies}, std::pair{&guest_cookie_, &all.guest_cookies}}) {
          if (!pair.starts_with(*cookie) || !pair.substr(cookie->size()).starts_with('=')) continue;
          const std::string_view held = pair.substr(cookie->size() + 1);
          const auto dot = held.find('.');
          to->push_back({std::string(held.substr(0, dot)), std::string(dot == std::string_view::npos ? "" : held.substr(dot + 1))});
        }
      }
    }
  }
  return all;
}

bool Access::token_accepted(const HttpRequest& request, const RequestTarget& target) const {
  if (!token_needed()) return true;
  const Offered all = offered(request, target);
  bool accepted = false;
  for (const std::string& token : all.tokens) accepted = is_token(token) || accepted;
  for (const Cookie& cookie : all.cookies)
    accepted = equal_in_constant_time(proof_of(options_.token, cookie.id), cookie.proof) || accepted;
  return accepted;
}

std::string Access::cookie(const std::string& name, const std::string& secret) const {
  const std::string id = random_token(128);
  return name + "=" + id + "." + proof_of(secret, id) + "; Path=" + options_.base_path + "; HttpOnly; SameSite=Strict" +
         (options_.secure ? "; Secure" : "");
}

std::string Access::set_cookie() const { return cookie(cookie_, options_.token); }

std::string Access::set_guest_cookie(const std::string& secret) const { return cookie(guest_cookie_, secret); }

}  // namespace isostrata
