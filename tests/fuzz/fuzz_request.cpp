// Bytes of an HTTP connection through Beast's parser into the site: targets, headers, access, routes.
#include <boost/beast/http/parser.hpp>
#include <boost/beast/http/string_body.hpp>
#include <cstdint>
#include <cstdlib>

#include "fuzz/fake_engine.h"
#include "net/site/site.h"

namespace http = boost::beast::http;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace isostrata;
  http::request_parser<http::string_body> parser;
  parser.header_limit(16384);
  parser.body_limit(1 << 20);
  parser.eager(true);
  boost::system::error_code error;
  const boost::asio::const_buffer bytes(data, size);
  for (std::size_t at = 0; at < size && !parser.is_done() && !error;) {
    const std::size_t used = parser.put(bytes + at, error);
    if (used == 0) break;
    at += used;
  }
  if (error || !parser.is_header_done()) return 0;
  HttpRequest request;
  request.method = std::string(parser.get().method_string());
  request.target = std::string(parser.get().target());
  request.body = parser.get().body();
  for (const auto& field : parser.get()) {
    std::string name(field.name_string());
    for (char& c : name) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    request.headers.emplace_back(std::move(name), std::string(field.value()));
  }
  static fuzz::FakeEngine engine;
  static Site site({.base_path = "/base/", .access = {.token = "token123"}}, engine.sessions);
  int replies = 0;
  site.handle(request, [&](HttpResponse response) {
    ++replies;
    fuzz::expect(response.status >= 200 && response.status < 600, "a status is one of HTTP");
    fuzz::expect(response.status < 500 || response.status == 503, "no request breaks the server");
    for (const auto& [name, value] : response.headers)
      fuzz::expect(value.find_first_of("\r\n") == std::string::npos, "no header ends another");
  });
  engine.run();
  fuzz::expect(replies == 1, "every request is answered once");
  Sessions::Admission admission;
  site.refuse_upgrade(request, admission);
  fuzz::end_all(engine.sessions);
  return 0;
}
