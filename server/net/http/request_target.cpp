#include "net/http/request_target.h"

#include <cctype>
#include <utility>

#include "base/hex_digit.h"

namespace isostrata {
std::optional<std::string> decode_percent(std::string_view text, bool plus_is_space) {
  std::string out;
  for (std::size_t i = 0; i < text.size(); ++i) {
    char c = text[i];
    if (c == '%') {
      if (i + 2 >= text.size()) return std::nullopt;
      const int high = hex_digit(text[i + 1]), low = hex_digit(text[i + 2]);
      if (high < 0 || low < 0) return std::nullopt;
      c = static_cast<char>(high * 16 + low);
      i += 2;
    } else if (c == '+' && plus_is_space) {
      c = ' ';
    }
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) return std::nullopt;
    out += c;
  }
  return out;
}

std::string encode_percent(std::string_view text) {
  std::string out;
  for (const char c : text) {
    const auto u = static_cast<unsigned char>(c);
    if ((u < 128 && std::isalnum(u)) || c == '-' || c == '.' || c == '_' || c == '~') {
      out += c;
    } else {
      out += '%';
      out += "0123456789ABCDEF"[u >> 4];
      out += "0123456789ABCDEF"[u & 15];
    }
  }
  return out;
}

std::string RequestTarget::path() const {
  std::string out;
  for (const std::string& segment : segments) out += "/" + segment;
  return out.empty() ? "/" : out;
}

std::optional<RequestTarget> parse_target(std::string_view target) {
  if (target.size() > 8192 || !target.starts_with('/')) return std::nullopt;
  RequestTarget out;
  std::string_view query;
  if (const auto at = target.find('?'); at != std::string_view::npos) {
    query = target.substr(at + 1);
    target = target.substr(0, at);
  }
  if (target.find('#') != std::string_view::npos) return std::nullopt;
  out.trailing_slash = target.ends_with('/');
  target.remove_prefix(1);
  while (!target.empty()) {
    const auto at = target.find('/');
    auto segment = decode_percent(target.substr(0, at), false);
    if (!segment || segment->empty() || *segment == "." || *segment == ".." || segment->find_first_of("/\\") != std::string::npos)
      return std::nullopt;
    out.segments.push_back(std::move(*segment));
    target = at == std::string_view::npos ? std::string_view{} : target.substr(at + 1);
  }
  while (!query.empty()) {
    const auto at = query.find('&');
    const std::string_view pair = query.substr(0, at);
    query = at == std::string_view::npos ? std::string_view{} : query.substr(at + 1);
    if (pair.empty()) continue;
    const auto equals = pair.find('=');
    auto key = decode_percent(pair.substr(0, equals), true);
    auto value = decode_percent(equals == std::string_view::npos ? std::string_view{} : pair.substr(equals + 1), true);
    if (!key || !value) return std::nullopt;
    if (!out.query.try_emplace(std::move(*key), std::move(*value)).second) return std::nullopt;
  }
  return out;
}

}  // namespace isostrata
