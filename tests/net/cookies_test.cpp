// The page's cookie: what it is called, what it holds, how long it is good.
#include <gtest/gtest.h>

#include <mutex>
#include <vector>

#include "net/http/access.h"
#include "net/running_server.h"

namespace isostrata {
namespace {

constexpr const char* kToken = RunningServer::kToken;

/// NAME=VALUE of a Set-Cookie.
std::string pair_of(const std::string& set_cookie) { return set_cookie.substr(0, set_cookie.find(';')); }

bool accepted(const Access& access, const std::string& cookie) {
  HttpRequest request;
  request.headers = {{"cookie", cookie}};
  return access.token_accepted(request, RequestTarget{});
}

TEST(Cookies, HoldNoTokenAndAreEachTheirOwn) {
  const Access access({.token = kToken, .port = 8080});
  const std::string first = access.set_cookie(), second = access.set_cookie();
  EXPECT_NE(first, second);
  for (const std::string& cookie : {first, second}) {
    EXPECT_EQ(cookie.find(kToken), std::string::npos);
    EXPECT_TRUE(has(cookie, "isostrata_8080=") && has(cookie, "; HttpOnly") && has(cookie, "; SameSite=Strict") &&
                has(cookie, "; Path=/"))
        << cookie;
    EXPECT_TRUE(accepted(access, "other=1; " + pair_of(cookie)));
  }
}

TEST(Cookies, AreGoodAsLongAsTheTokenIs) {
  const std::string cookie = pair_of(Access({.token = kToken, .port = 8080}).set_cookie());
  EXPECT_TRUE(accepted(Access({.token = kToken, .port = 8080}), cookie)) << "a server that was started anew";
  EXPECT_FALSE(accepted(Access({.token = std::string(kToken) + "0", .port = 8080}), cookie)) << "another token";
}

TEST(Cookies, ThatAreMadeUpOrChangedAreNone) {
  const Access access({.token = kToken, .port = 8080});
  const std::string cookie = pair_of(access.set_cookie());
  const std::string name = cookie.substr(0, cookie.find('=') + 1), value = cookie.substr(name.size());
  const std::string id = value.substr(0, value.find('.')), proof = value.substr(id.size() + 1);
  std::string changed = value;
  changed[0] = changed[0] == '0' ? '1' : '0';
  for (const std::string& bad :
       {std::string(kToken), std::string(), std::string("."), id, "." + proof, id + "." + proof.substr(1), id + "." + proof + "0",
        changed, id + proof, std::string("x.") + proof, id + "." + std::string(64, '0')})
    EXPECT_FALSE(accepted(access, name + bad)) << bad;
  EXPECT_FALSE(accepted(access, "isostrata_guest_8080=" + value)) << "a guest's";
  EXPECT_FALSE(accepted(access, "isostrata_8081=" + value)) << "of another port";
}

TEST(Cookies, GoToThisHostAloneByHttpsAlone) {
  EXPECT_TRUE(Access({.token = kToken, .secure = true, .port = 1}).set_cookie().starts_with("__Host-isostrata_1="));
  EXPECT_TRUE(
      has(Access({.token = kToken, .secure = true, .port = 1}).set_cookie(), "; Path=/; HttpOnly; SameSite=Strict; Secure"));
  EXPECT_TRUE(has(Access({.token = kToken, .secure = true, .port = 1}).set_guest_cookie("a secret"), "; Secure"));
  const std::string below = Access({.token = kToken, .secure = true, .base_path = "/prefix/", .port = 1}).set_cookie();
  EXPECT_TRUE(below.starts_with("__Secure-isostrata_1=") && has(below, "; Path=/prefix/")) << below;
  EXPECT_FALSE(has(Access({.token = kToken, .port = 1}).set_cookie(), "Secure"));
}

// Over the wire: what the page's first address sets opens the rest, and the token does not go over again.
TEST(Cookies, OfAPageOpenItsFilesItsApiAndItsWebSocket) {
  testing::TemporaryFolder page;
  page.write("index.html", "<html>the page</html>");
  ServerOptions options;
  options.web_root = page.path();
  RunningServer server(std::move(options));
  const auto first =
      server.raw("GET /?token=" + std::string(kToken) + " HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n");
  const auto at = first.find("Set-Cookie: ") + 12;
  EXPECT_FALSE(has(first, kToken)) << first;
  const std::string header = "Cookie: " + pair_of(first.substr(at, first.find('\r', at) - at)) + "\r\n";
  for (const char* path : {"/", "/api/v1/sessions", "/metrics"})
    EXPECT_EQ(status_of(server.raw(std::string("GET ") + path + " HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n" + header +
                                   "\r\n")),
              200)
        << path;
  EXPECT_EQ(status_of(RawSocket(server.port()).open_websocket("/ws", header)), 101);
  EXPECT_EQ(status_of(RawSocket(server.port())
                          .open_websocket("/ws", "Cookie: isostrata_" + std::to_string(server.port()) + "=" + kToken + "\r\n")),
            401);
}

// Who did what, for whoever reads the log afterwards; never a token.
TEST(AuditLog, NamesWhoAskedForWhatAndWhence) {
  std::mutex mutex;
  std::vector<LogLine> lines;
  std::string session, invitation, guest_token;
  {
    ServerOptions options;
    options.log = [&](const LogLine& line) {
      const std::lock_guard guard(mutex);
      lines.push_back(line);
    };
    RunningServer server(std::move(options));
    client::Options own = server.client_options();
    own.name = "a client\nwith two lines";
    client::Client owner(own);
    owner.open_dataset("torus-12");
    session = owner.welcome().session();
    const auto answer =
        server.ask("POST", "/api/v1/sessions/" + session + "/invitations", R"({"role":"ROLE_CONTROLLER","seconds":600})");
    guest_token = answer.substr(answer.find("\"token\":\"") + 9, 48);
    client::Options theirs = server.client_options();
    theirs.url = theirs.url.substr(0, theirs.url.find('?')) + "?token=" + guest_token;
    client::Client guest(theirs);
    guest.set_view("+x");
    guest.lossless_frame();
  }
  const auto field = [](const LogLine& line, const std::string& name) {
    for (const auto& [key, value] : line.fields)
      if (key == name) return value;
    return std::string();
  };
  int joined = 0, turned = 0, opened = 0, invited = 0;
  for (const LogLine& line : lines) {
    std::string all = line.message;
    for (const auto& [key, value] : line.fields) all += value;
    EXPECT_FALSE(has(all, kToken) || has(all, guest_token)) << all;
    EXPECT_FALSE(has(all, "\n")) << all;
    if (line.event == "request" && field(line, "method") == "POST" && has(field(line, "path"), "invitations"))
      invited += field(line, "address") == "127.0.0.1";
    if (line.event != "act") continue;
    EXPECT_EQ(line.session, session);
    EXPECT_EQ(field(line, "address"), "127.0.0.1");
    joined += field(line, "act") == "join";
    opened += field(line, "act") == "open_dataset" && field(line, "who") == "owner" && field(line, "detail") == "torus-12";
    turned += field(line, "act") == "set_view" && field(line, "who") == "guest" && !field(line, "invitation").empty() &&
              field(line, "role") == "controller";
  }
  EXPECT_EQ(joined, 2);
  EXPECT_EQ(opened, 1);
  EXPECT_EQ(turned, 1);
  EXPECT_EQ(invited, 1);
}

}  // namespace
}  // namespace isostrata
