#include "server_address.h"

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <ranges>
#include <string_view>

namespace isostrata::client {
namespace {

constexpr auto npos = std::string_view::npos;

// Takes from text what stands before the first of `ends`, and leaves the rest with it.
std::string_view take_until(std::string_view& text, std::string_view ends) {
  const std::string_view taken = text.substr(0, text.find_first_of(ends));
  text.remove_prefix(taken.size());
  return taken;
}

// A value of a query without its escapes; false if one is broken.
bool unescape(std::string_view text, std::string& to) {
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] != '%') {
      to += text[i] == '+' ? ' ' : text[i];
      continue;
    }
    unsigned char byte = 0;
    const char* const end = text.data() + std::min(i + 3, text.size());
    const auto [stopped, wrong] = std::from_chars(text.data() + i + 1, end, byte, 16);
    if (wrong != std::errc{} || stopped != text.data() + i + 3) return false;
    to += static_cast<char>(byte);
    i += 2;
  }
  return true;
}

bool is_port(std::string_view text) {
  std::uint16_t port = 0;
  const auto [stopped, wrong] = std::from_chars(text.data(), text.data() + text.size(), port);
  return wrong == std::errc{} && stopped == text.data() + text.size();
}

bool take_token(std::string_view query, ServerAddress& address) {
  if (!query.starts_with('?')) return true;
  query = query.substr(1, query.find('#') - 1);
  while (!query.empty()) {
    std::string_view parameter = take_until(query, "&");
    if (parameter.starts_with("token=")) {
      address.token.clear();
      if (!unescape(parameter.substr(6), address.token)) return false;
    }
    if (!query.empty()) query.remove_prefix(1);
  }
  return true;
}

bool split(std::string_view url, ServerAddress& address) {
  if (std::ranges::any_of(url, [](char c) { return c <= ' ' || c >= 0x7f; })) return false;
  if (url.starts_with("unix:")) {
    url.remove_prefix(5);
    address.host = address.connect_to = "localhost";
    address.port = "80";
    address.base_path = "/";
    return unescape(take_until(url, "?#"), address.unix_path) && address.unix_path.starts_with('/') && take_token(url, address);
  }
  address.tls = url.starts_with("https://");
  if (!address.tls && !url.starts_with("http://")) return false;
  url.remove_prefix(address.tls ? 8 : 7);

  std::string_view place = take_until(url, "/?#");
  const std::size_t closing = place.starts_with('[') ? place.find(']') : 0;  // of an IPv6 address, which has colons of its own
  if (closing == npos) return false;
  const std::size_t colon = place.find(':', closing);
  address.host = place.substr(0, colon);
  address.connect_to = closing ? address.host.substr(1, closing - 1) : address.host;
  address.port = colon == npos ? address.tls ? "443" : "80" : place.substr(colon + 1);
  if (address.connect_to.empty() || (closing && address.host.size() != closing + 1) || !is_port(address.port) ||
      address.connect_to.find_first_of("@[]%") != npos)
    return false;

  address.base_path = take_until(url, "?#");
  if (!address.base_path.ends_with('/')) address.base_path += '/';

  return take_token(url, address);
}

}  // namespace

ServerAddress parse_address(const Options& options) {
  ServerAddress address;
  address.token = options.token;
  if (!split(options.url, address))
    throw ClientError("bad_url", "'" + options.url.substr(0, options.url.find('?')) +
                                     "' is not a server's address; expected http://HOST:PORT/, https://HOST:PORT/ or unix:/PATH");
  return address;
}

}  // namespace isostrata::client
