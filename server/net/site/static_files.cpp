#include "net/site/static_files.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cstdio>
#include <fstream>
#include <sstream>

#include "base/program_file.h"
#include "net/http/security_headers.h"

namespace isostrata {
namespace {

namespace fs = std::filesystem;
constexpr std::uintmax_t kMaxFileBytes = 64u << 20;

const char* type_of(const fs::path& path) {
  static constexpr std::array<std::pair<const char*, const char*>, 18> kTypes{{{".html", "text/html; charset=utf-8"},
                                                                               {".js", "text/javascript; charset=utf-8"},
                                                                               {".mjs", "text/javascript; charset=utf-8"},
                                                                               {".css", "text/css; charset=utf-8"},
                                                                               {".json", "application/json"},
                                                                               {".webmanifest", "application/manifest+json"},
                                                                               {".map", "application/json"},
                                                                               {".svg", "image/svg+xml"},
                                                                               {".png", "image/png"},
                                                                               {".jpg", "image/jpeg"},
                                                                               {".webp", "image/webp"},
                                                                               {".ico", "image/x-icon"},
                                                                               {".woff2", "font/woff2"},
                                                                               {".woff", "font/woff"},
                                                                               {".wasm", "application/wasm"},
                                                                               {".txt", "text/plain; charset=utf-8"},
                                                                               {".ivf", "application/octet-stream"},
                                                                               {".proto", "text/plain; charset=utf-8"}}};
  const std::string extension = path.extension().string();
  for (const auto& [known, type] : kTypes)
    if (extension == known) return type;
  return "application/octet-stream";
}

std::string etag_of(const fs::path& path, std::uintmax_t size) {
  std::error_code error;
  const auto time = fs::last_write_time(path, error).time_since_epoch().count();
  std::array<char, 48> text{};
  std::snprintf(text.data(), text.size(), "\"%llx-%llx\"", static_cast<unsigned long long>(time),
                static_cast<unsigned long long>(size));
  return text.data();
}

/// What the client takes, by RFC 9110: each coding once, with a weight; "*" stands for those that are not named. 0: not at all.
double weight_of(std::string_view coding, std::string_view accepted) {
  double named = -1, others = 0;
  while (!accepted.empty()) {
    const auto comma = accepted.find(',');
    std::string entry(accepted.substr(0, comma));
    accepted.remove_prefix(comma == std::string_view::npos ? accepted.size() : comma + 1);
    std::erase_if(entry, [](char c) { return c == ' ' || c == '\t'; });
    std::transform(entry.begin(), entry.end(), entry.begin(), [](unsigned char c) { return std::tolower(c); });
    const auto semicolon = entry.find(';');
    double weight = 1;
    if (semicolon != std::string::npos && entry.compare(semicolon + 1, 2, "q=") == 0) {
      const char* const begin = entry.c_str() + semicolon + 3;
      const auto [end, error] = std::from_chars(begin, entry.c_str() + entry.size(), weight);
      if (error != std::errc{} || !(weight >= 0 && weight <= 1)) weight = 0;
    }
    const std::string_view name = std::string_view(entry).substr(0, semicolon);
    if (name == coding) named = weight;
    if (name == "*") others = weight;
  }
  return named >= 0 ? named : others;
}

/// If-None-Match: a list of tags, weak or not, or "*".
bool matches(std::string_view wanted, const std::string& etag) {
  for (std::size_t at = wanted.find(etag); at != std::string_view::npos; at = wanted.find(etag, at + 1)) {
    const auto end = at + etag.size();
    if (end == wanted.size() || wanted[end] == ',' || wanted[end] == ' ') return true;
  }
  return wanted == "*";
}

bool inside(const fs::path& path, const fs::path& directory) {
  return std::mismatch(directory.begin(), directory.end(), path.begin(), path.end()).first == directory.end();
}

}  // namespace

HttpResponse message_page(int status, const std::string& title, const std::string& text) {
  return {status,
          "text/html; charset=utf-8",
          "<!doctype html><html lang=\"en\"><meta charset=\"utf-8\"><title>" + title +
              "</title><style>" + std::string(kPageStyle) + "</style><h1>" +
              title + "</h1><p>" + text + "</p></html>\n",
          {{"Cache-Control", "no-store"}}};
}

StaticFiles::StaticFiles(fs::path root)
    : root_([&] {
        std::error_code error;
        fs::path real = root.empty() ? fs::path{} : fs::canonical(root, error);
        return error ? fs::path{} : real;
      }()) {}

bool StaticFiles::built() const {
  std::error_code error;
  return !root_.empty() && fs::is_regular_file(root_ / "index.html", error);
}

HttpResponse StaticFiles::get(const HttpRequest& request, const std::vector<std::string>& segments) const {
  if (!built())
    return message_page(
        503, "The page is not built",
        "The server runs, but its web page is missing. Build it with <code>npm ci &amp;&amp; npm run build</code> in "
        "<code>web/</code>, "
        "or name its directory with <code>--web-root</code>. The API under <code>api/v1</code> works without it.");
  const HttpResponse missing = message_page(404, "Not found", "There is no such file here.");
  fs::path path = root_;
  for (const std::string& segment : segments) {
    if (segment.starts_with('.')) return missing;
    path /= segment;
  }
  if (segments.empty()) path /= "index.html";
  std::error_code error;
  path = fs::canonical(path, error);
  if (error || !inside(path, root_) || !fs::is_regular_file(path, error)) return missing;
  const char* const type = type_of(path);

  HttpResponse response;
  // The build leaves smaller copies beside what can be packed; the client's favourite, and of equals the smaller one, is sent.
  const std::string_view accepted = request.header("accept-encoding");
  double best = 0;
  std::string_view coding;
  for (const auto& [name, extension] : {std::pair{"br", ".br"}, std::pair{"gzip", ".gz"}}) {
    const fs::path packed = path.string() + extension;
    if (!fs::is_regular_file(fs::symlink_status(packed, error))) continue;
    if (response.headers.empty()) response.headers.emplace_back("Vary", "Accept-Encoding");
    if (const double weight = weight_of(name, accepted); weight > best) best = weight, coding = name;
  }
  if (!coding.empty()) {
    response.headers.emplace_back("Content-Encoding", coding);
    path += coding == "br" ? ".br" : ".gz";
  }
  const std::uintmax_t size = fs::file_size(path, error);
  if (error || size > kMaxFileBytes) return missing;
  const std::string etag = etag_of(path, size);
  response.headers.emplace_back("ETag", etag);
  const bool hashed_name = segments.size() > 1 && segments.front() == "assets";
  response.headers.emplace_back("Cache-Control", hashed_name ? "private, max-age=31536000, immutable" : "no-cache");
  response.content_type = type;  // of a 304, too: browsers put its headers over those of the page that they have
  if (matches(request.header("if-none-match"), etag)) {
    response.status = 304;
    return response;
  }
  std::ifstream file(path, std::ios::binary);
  std::ostringstream content;
  content << file.rdbuf();
  if (!file) return missing;
  response.body = std::move(content).str();
  return response;
}

fs::path find_web_root(const fs::path& wanted) {
  if (!wanted.empty()) return wanted;
  std::error_code error;
  const fs::path directory = program_file().parent_path();
  if (directory.empty()) return {};
  // <prefix>/bin/isostrata and <source>/build/<preset>/bin/isostrata
  for (const char* candidate : {"../share/isostrata/web", "../../../web/dist"}) {
    const fs::path root = directory / candidate;
    if (fs::is_regular_file(root / "index.html", error)) return fs::canonical(root, error);
  }
  // Not built yet: where it will be, so that building it needs no restart.
  const fs::path source = directory / "../../../web/dist";
  return fs::is_directory(source, error) ? fs::canonical(source, error) : fs::path{};
}

}  // namespace isostrata
