#include <gtest/gtest.h>

#include "net/running_server.h"

namespace isostrata {
namespace {

const std::string& kBearer = RunningServer::kBearer;
const std::string kEnd = "Connection: close\r\n\r\n";

class Http : public ::testing::Test {
 protected:
  static ServerOptions with_page(const testing::TemporaryFolder& page) {
    page.write("web/index.html", "<html>the page</html>");
    page.write("web/assets/app-1a2b.js", "export {}");
    page.write("secret.txt", "a secret");
    std::filesystem::create_symlink(page.path() / "secret.txt", page.path() / "web" / "link.txt");
    ServerOptions options;
    options.web_root = page.path() / "web";
    return options;
  }
  testing::TemporaryFolder page_;
  RunningServer server_{with_page(page_)};
};

TEST_F(Http, HealthNeedsNoTokenAndNoHost) {
  for (const std::string path : {"/healthz", "/api/v1/health"}) {
    const auto response = server_.raw("GET " + path + " HTTP/1.1\r\nHost: 10.0.0.7:1\r\n" + kEnd);
    EXPECT_EQ(status_of(response), 200) << response;
    EXPECT_TRUE(response.ends_with("\r\n\r\n{\"status\":\"ok\"}")) << response;
  }
}

TEST_F(Http, HealthTellsStrangersTheSameWhateverGoesOn) {
  const auto body = [](const std::string& response) { return response.substr(response.find("\r\n\r\n")); };
  const std::string stranger = "GET /healthz HTTP/1.1\r\nHost: localhost\r\n" + kEnd, before = body(server_.raw(stranger));
  client::Client client(server_.client_options());
  EXPECT_EQ(body(server_.raw(stranger)), before);
  EXPECT_EQ(body(server_.ask("GET", "/healthz", "", "Origin: http://evil.example\r\n")), before);
  EXPECT_TRUE(has(server_.health(), "\"viewers\":1")) << server_.health();
}

TEST_F(Http, EverythingElseNeedsTheToken) {
  for (const std::string path : {"/", "/assets/app-1a2b.js", "/api/v1/datasets", "/api/v1/sessions"})
    EXPECT_EQ(status_of(server_.raw("GET " + path + " HTTP/1.1\r\nHost: localhost\r\n" + kEnd)), 401) << path;
  for (const std::string bad :
       {"Authorization: Bearer 0\r\n", "Authorization: Bearer \r\n", "Authorization: Basic abc\r\n", "Cookie: isostrata_0=x\r\n"})
    EXPECT_EQ(status_of(server_.raw("GET / HTTP/1.1\r\nHost: localhost\r\n" + bad + kEnd)), 401) << bad;
  std::string nearly = RunningServer::kToken;
  nearly.back() ^= 1;
  EXPECT_EQ(status_of(server_.raw("GET /?token=" + nearly + " HTTP/1.1\r\nHost: localhost\r\n" + kEnd)), 401);
}

TEST_F(Http, TheFirstPageLoadSetsACookieThatOpensTheRest) {
  const auto page = server_.raw("GET /?token=" + std::string(RunningServer::kToken) + " HTTP/1.1\r\nHost: localhost\r\n" + kEnd);
  ASSERT_EQ(status_of(page), 200) << page;
  EXPECT_TRUE(has(page, "the page") && has(page, "HttpOnly") && has(page, "SameSite=Strict")) << page;
  const auto at = page.find("Set-Cookie: ") + 12;
  const std::string cookie = page.substr(at, page.find(';', at) - at);
  const auto script =
      server_.raw("GET /assets/app-1a2b.js HTTP/1.1\r\nHost: localhost\r\nCookie: a=b; " + cookie + "\r\n" + kEnd);
  EXPECT_EQ(status_of(script), 200);
  EXPECT_TRUE(has(script, "Content-Type: text/javascript") && has(script, "immutable") && has(script, "nosniff")) << script;
}

TEST_F(Http, OnlyItsOwnNamesAreServed) {
  const std::string port = std::to_string(server_.port());
  for (const std::string& host : {std::string("localhost"), "localhost:" + port, std::string("127.0.0.1:9999"),
                                  std::string("[::1]:80"), std::string("LOCALHOST")})
    EXPECT_EQ(status_of(server_.raw("GET / HTTP/1.1\r\nHost: " + host + "\r\n" + kBearer + kEnd)), 200) << host;
  for (const std::string host :
       {"evil.example", "localhost.evil.example", "127.0.0.1.evil.example:80", "localhost:x", "", "localhost@evil.example"})
    EXPECT_EQ(status_of(server_.raw("GET / HTTP/1.1\r\nHost: " + host + "\r\n" + kBearer + kEnd)), 403) << host;
  EXPECT_EQ(status_of(server_.raw("GET / HTTP/1.1\r\nHost: localhost\r\nHost: evil.example\r\n" + kBearer + kEnd)), 400);
}

TEST_F(Http, OtherOriginsAreRefused) {
  for (const std::string origin :
       {"http://localhost:1234", "http://evil.example", "null", "https://localhost.evil.example", "file://"})
    EXPECT_EQ(
        status_of(server_.raw("GET /api/v1/sessions HTTP/1.1\r\nHost: localhost\r\nOrigin: " + origin + "\r\n" + kBearer + kEnd)),
        403)
        << origin;
  EXPECT_EQ(status_of(server_.raw("GET /api/v1/sessions HTTP/1.1\r\nHost: localhost:77\r\nOrigin: http://localhost:77\r\n" +
                                  kBearer + kEnd)),
            200);
}

TEST_F(Http, NothingOutsideTheWebRootIsServed) {
  for (const std::string path : {"/../secret.txt", "/assets/../../secret.txt", "/%2e%2e/secret.txt", "/..%2fsecret.txt",
                                 "/assets/%2e%2e%2f%2e%2e%2fsecret.txt", "/link.txt", "/%00", "//secret.txt",
                                 "/assets\\..\\..\\secret.txt", "/./secret.txt", "/.hidden", "/assets"}) {
    const auto response = server_.ask("GET", path);
    EXPECT_TRUE(status_of(response) == 400 || status_of(response) == 404) << path << "\n" << response;
    EXPECT_FALSE(has(response, "a secret")) << path;
  }
}

TEST_F(Http, AnUnchangedFileIsNotSentAgain) {
  const auto first = server_.ask("GET", "/");
  const auto at = first.find("ETag: ") + 6;
  const std::string etag = first.substr(at, first.find('\r', at) - at);
  const auto second = server_.ask("GET", "/", "", "If-None-Match: " + etag + "\r\n");
  EXPECT_EQ(status_of(second), 304) << second;
  EXPECT_FALSE(has(second, "the page"));
  const auto policy = [](const std::string& response) {
    const auto at = response.find("Content-Security-Policy: ");
    return response.substr(at, response.find('\r', at) - at);
  };
  EXPECT_TRUE(has(policy(first), "script-src"));
  EXPECT_EQ(policy(second), policy(first)) << "a browser takes it for that of the page that it has, which then loads no script";
  EXPECT_TRUE(server_.ask("HEAD", "/").ends_with("\r\n\r\n"));
}

TEST_F(Http, BodiesInChunksAreRefused) {
  for (const std::string body : {"5\r\nhello\r\n0\r\n\r\n", "0\r\n\r\n", "5;a=b\r\nhello\r\n0\r\nX: y\r\n\r\n", "zz\r\n"}) {
    const auto response = server_.raw("POST /api/v1/sessions HTTP/1.1\r\nHost: localhost\r\nTransfer-Encoding: chunked\r\n" +
                                      kBearer + "\r\n" + body);
    EXPECT_EQ(status_of(response), 411) << response;
  }
  const auto smuggled =
      server_.raw("POST /api/v1/sessions HTTP/1.1\r\nHost: localhost\r\nContent-Length: 4\r\nTransfer-Encoding: chunked\r\n" +
                  kBearer + "\r\n0\r\n\r\nGET /healthz HTTP/1.1\r\nHost: x\r\n\r\n");
  EXPECT_FALSE(has(smuggled, " 200 ")) << smuggled;
  EXPECT_TRUE(server_.answers());
}

TEST_F(Http, WhatIsNoRequestGetsOneAnswerAndTheEnd) {
  for (const std::string& bytes :
       {std::string("nonsense\r\n\r\n"), std::string("GET / HTTP/9.9\r\n\r\n"), std::string("GET  HTTP/1.1\r\n\r\n"),
        std::string("\x16\x03\x01\x02\x00\x01\x00", 7), std::string("GET / HTTP/1.1\r\nContent-Length: -5\r\n\r\n"),
        std::string("GET / HTTP/1.1\r\nbad header\r\n\r\n")}) {
    RawSocket socket(server_.port());
    socket.send(bytes);
    bool closed = false;
    const auto response = socket.read_all(&closed);
    EXPECT_TRUE(closed) << bytes;
    EXPECT_FALSE(has(response, " 200 ")) << bytes;
  }
  EXPECT_TRUE(server_.answers());
}

TEST_F(Http, SizesAreBounded) {
  EXPECT_EQ(status_of(server_.raw("GET / HTTP/1.1\r\nHost: localhost\r\nX: " + std::string(20000, 'x') + "\r\n\r\n")), 431);
  EXPECT_EQ(status_of(server_.raw("POST /api/v1/sessions HTTP/1.1\r\nHost: localhost\r\nContent-Length: 2000000\r\n" + kBearer +
                                  "\r\n")),
            413);
  EXPECT_EQ(
      status_of(server_.raw("POST /api/v1/sessions HTTP/1.1\r\nHost: localhost\r\nContent-Length: 99999999999999999999\r\n" +
                            kBearer + "\r\n")),
      400);
}

TEST_F(Http, OneConnectionCarriesManyRequests) {
  RawSocket socket(server_.port());
  for (int i = 0; i < 3; ++i) {
    socket.send("GET /api/v1/datasets HTTP/1.1\r\nHost: localhost\r\n" + kBearer + "\r\n");
    EXPECT_EQ(status_of(socket.read_response()), 200) << i;
  }
}

TEST(HttpBase, APrefixIsServedUnderItselfOnly) {
  testing::TemporaryFolder page;
  page.write("index.html", "<html>the page</html>");
  ServerOptions options;
  options.web_root = page.path();
  options.base_url = "https://ondemand.example/node/7";
  RunningServer server(std::move(options));
  EXPECT_TRUE(has(server.ask("GET", "/node/7/"), "the page"));
  EXPECT_TRUE(has(server.ask("GET", "/node/7"), "Location: /node/7/"));
  EXPECT_EQ(status_of(server.ask("GET", "/")), 404);
  EXPECT_EQ(status_of(server.ask("GET", "/node/7/api/v1/datasets")), 200);
  EXPECT_EQ(status_of(server.raw("GET /node/7/ HTTP/1.1\r\nHost: ondemand.example\r\n" + kBearer + kEnd)), 200);
}

TEST(HttpPage, AMissingPageIsSaidPlainly) {
  testing::TemporaryFolder empty;
  ServerOptions options;
  options.web_root = empty.path();
  RunningServer server(std::move(options));
  const auto response = server.ask("GET", "/");
  EXPECT_EQ(status_of(response), 503);
  EXPECT_TRUE(has(response, "not built")) << response;
}

TEST(HttpPlaces, WhoComesWhenAllAreTakenIsToldAndTheNextOneAfterThatIsServed) {
  ServerOptions options;
  options.max_sessions = 1;
  RunningServer server(std::move(options));
  std::vector<std::unique_ptr<RawSocket>> taken;
  // Of requests that are on their way, with the token: what merely waits would make room.
  for (int i = 0; i < 258; ++i) {
    taken.push_back(std::make_unique<RawSocket>(server.port()));
    taken.back()->send("POST /api/v1/sessions HTTP/1.1\r\nHost: localhost\r\nContent-Length: 2\r\n" + kBearer + "\r\n");
  }
  EXPECT_EQ(status_of(RawSocket(server.port()).read_all()), 503);
  taken.clear();
  bool served = false;
  for (int i = 0; i < 200 && !served; ++i) served = server.answers();
  EXPECT_TRUE(served);
}

}  // namespace
}  // namespace isostrata
