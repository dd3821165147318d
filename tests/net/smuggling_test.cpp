// Requests that two programs could read differently: a proxy one way, the server another. Each gets one answer and the end,
// whatever the bytes behind it say.
#include <gtest/gtest.h>
#include <openssl/evp.h>
#include <openssl/sha.h>

#include <array>

#include "net/http/security_headers.h"
#include "net/running_server.h"
#include "net/site/static_files.h"

namespace isostrata {
namespace {

const std::string& kBearer = RunningServer::kBearer;
const std::string kSecond =
    std::string("GET /api/v1/sessions HTTP/1.1\r\nHost: localhost\r\n") + kBearer + "Connection: close\r\n\r\n";

struct Case {
  const char* what;
  std::string bytes;
  std::vector<int> answers;  // one of them
};

std::string post(const std::string& headers, const std::string& body = "") {
  return "POST /api/v1/sessions HTTP/1.1\r\nHost: localhost\r\n" + kBearer + headers + "\r\n" + body;
}
std::string get(const std::string& headers) { return "GET /healthz HTTP/1.1\r\nHost: localhost\r\n" + headers + "\r\n"; }

std::vector<Case> cases() {
  std::vector<Case> all;
  const auto add = [&](const char* what, std::string bytes, std::vector<int> answers) {
    all.push_back({what, std::move(bytes), std::move(answers)});
  };
  // lengths
  add("the same length twice", post("Content-Length: 2\r\nContent-Length: 2\r\n", "{}"), {400});
  add("two lengths", post("Content-Length: 2\r\nContent-Length: 0\r\n", "{}"), {400});
  add("two lengths, one in other letters", post("Content-Length: 0\r\ncontent-length: 2\r\n", "{}"), {400});
  for (const char* length : {"2, 2", "2,2", "2 2", "+2", "-2", "0x2", "2.0", "2e0", "", "two", "2;", "'2'", "\"2\"",
                             "18446744073709551618", "99999999999999999999999", "٢", "2\v", "2\x01"})
    add("a length that is not a number", post(std::string("Content-Length: ") + length + "\r\n", "{}"), {400, 413});
  add("a space before the colon", post("Content-Length : 2\r\n", "{}"), {400});
  add("a tab before the colon", post("Content-Length\t: 2\r\n", "{}"), {400});
  // chunks
  for (const char* coding : {"chunked", "Chunked", "identity", "xchunked", "chunked, identity", "identity, chunked",
                             "gzip, chunked", "chunked ", "\tchunked", "\"chunked\"", "x", ""})
    for (const char* length : {"", "Content-Length: 5\r\n"})
      add("a transfer coding", post(std::string(length) + "Transfer-Encoding: " + coding + "\r\n", "0\r\n\r\n"), {400, 411});
  add("two transfer codings", post("Transfer-Encoding: chunked\r\nTransfer-Encoding: identity\r\n", "0\r\n\r\n"), {400, 411});
  add("a length after a coding", post("Transfer-Encoding: chunked\r\nContent-Length: 5\r\n", "0\r\n\r\n"), {400, 411});
  add("a coding behind a space", post("Transfer-Encoding : chunked\r\n", "0\r\n\r\n"), {400});
  add("a coding with a control character",
      post("Transfer-Encoding: \x0b"
           "chunked\r\n",
           "0\r\n\r\n"),
      {400, 411});
  // folded lines
  add("a folded coding", post("Transfer-Encoding:\r\n chunked\r\n", "0\r\n\r\n"), {400});
  add("a folded length", post("Content-Length:\r\n 2\r\n", "{}"), {400});
  add("a folded line", get("X: a\r\n b\r\n"), {400});
  add("a line folded by a tab", get("X: a\r\n\tb\r\n"), {400});
  add("a line folded twice", get("X: a\r\n b\r\n  c\r\n"), {400});
  add("a line folded to nothing", get("X: a\r\n \r\n"), {400});
  add("a folded first line", "GET /healthz HTTP/1.1\r\n Host: localhost\r\n\r\n", {400});
  // ends of lines
  add("line feeds alone", "GET /healthz HTTP/1.1\nHost: localhost\n\n", {400});
  add("one line feed alone", "GET /healthz HTTP/1.1\r\nHost: localhost\nX: y\r\n\r\n", {400});
  add("a carriage return in a value", get("X: a\rContent-Length: 5\r\n"), {400});
  add("a carriage return alone at the end", "GET /healthz HTTP/1.1\rHost: localhost\r\r", {400});
  add("a zero in a value", get(std::string("X: a\0b\r\n", 8)), {400});
  add("a zero in a name", get(std::string("X\0Y: a\r\n", 8)), {400});
  // names
  add("no colon", get("nonsense\r\n"), {400});
  add("no name", get(": a\r\n"), {400});
  add("a name with a space", get("X Y: a\r\n"), {400});
  add("a name with a bracket", get("X(Y): a\r\n"), {400});
  add("a name beyond ASCII", get("X\xc3\xa4: a\r\n"), {400});
  add("two tokens", "GET /api/v1/sessions HTTP/1.1\r\nHost: localhost\r\n" + kBearer + "Authorization: Bearer x\r\n\r\n", {400});
  add("two hosts", "GET /api/v1/sessions HTTP/1.1\r\nHost: localhost\r\nHost: evil.example\r\n" + kBearer + "\r\n", {400});
  add("two content types", post("Content-Type: application/json\r\nContent-Type: text/plain\r\nContent-Length: 2\r\n", "{}"),
      {400});
  // the first line
  for (const char* line : {"GET /healthz",
                           "GET /healthz HTTP/1.1 ",
                           " GET /healthz HTTP/1.1",
                           "GET  /healthz HTTP/1.1",
                           "GET\t/healthz HTTP/1.1",
                           "GET /healthz  HTTP/1.1",
                           "GET /healthz HTTP/2.0",
                           "GET /healthz HTTP/1.2",
                           "GET /healthz http/1.1",
                           "GET /healthz HTTP/1.10",
                           "GET /healthz HTTP/01.1",
                           "GET /healthz HTTP/1",
                           "GET /healthz FTP/1.1",
                           "GET /health z HTTP/1.1",
                           "GET HTTP/1.1",
                           "GET",
                           "G(T /healthz HTTP/1.1",
                           "GET http://evil.example/healthz HTTP/1.1",
                           "GET healthz HTTP/1.1",
                           "GET * HTTP/1.1",
                           "CONNECT evil.example:80 HTTP/1.1",
                           "GET /heal\x01thz HTTP/1.1",
                           "GET /a?token=x&token=y HTTP/1.1"})
    add(line, std::string(line) + "\r\nHost: localhost\r\nConnection: close\r\n\r\n", {400});
  return all;
}

class Smuggling : public ::testing::Test {
 protected:
  RunningServer server_;
};

TEST_F(Smuggling, WhatCanBeReadInTwoWaysGetsOneAnswerAndTheEnd) {
  for (const Case& of : cases()) {
    RawSocket socket(server_.port());
    socket.send(of.bytes + kSecond);
    bool closed = false;
    const std::string answer = socket.read_all(&closed);
    EXPECT_TRUE(closed) << of.what;
    EXPECT_NE(std::find(of.answers.begin(), of.answers.end(), status_of(answer)), of.answers.end()) << of.what << "\n"
                                                                                                    << of.bytes << answer;
    EXPECT_EQ(answer.find("HTTP/1.1 ", 1), std::string::npos) << of.what << ": a second answer\n" << of.bytes << answer;
  }
  EXPECT_TRUE(server_.answers());
}

// However the bytes are cut into packets.
TEST_F(Smuggling, AFoldedLineIsSeenAcrossPackets) {
  const std::string bytes =
      "POST /api/v1/sessions HTTP/1.1\r\nHost: localhost\r\n" + kBearer + "X: a\r\n b\r\nContent-Length: 2\r\n\r\n{}";
  const std::size_t fold = bytes.find("\r\n b");
  for (std::size_t at = fold - 1; at < fold + 5; ++at) {
    RawSocket socket(server_.port());
    socket.send(bytes.substr(0, at));
    std::this_thread::sleep_for(std::chrono::milliseconds(30));
    socket.send(bytes.substr(at));
    EXPECT_EQ(status_of(socket.read_all()), 400) << at;
  }
}

TEST_F(Smuggling, WhatHasOneMeaningIsServedOneAfterTheOther) {
  const std::string body = "GET /healthz HTTP/1.1\r\n\r\n ";  // looks like a request, and is a body
  const std::string first =
      post("Content-Type: application/json\r\nContent-Length: " + std::to_string(body.size()) + "\r\n", body);
  const std::string answers = server_.raw(first + get("") + kSecond);
  EXPECT_EQ(status_of(answers), 400) << answers;  // no JSON
  const auto second = answers.find("HTTP/1.1 200"), third = answers.find("HTTP/1.1 200", second + 1);
  EXPECT_NE(second, std::string::npos) << answers;
  EXPECT_NE(third, std::string::npos) << answers;
  EXPECT_EQ(answers.find("HTTP/1.1 ", third + 1), std::string::npos) << answers;
}

TEST_F(Smuggling, EveryAnswerHasTheSameSecurityHeaders) {
  const std::string token = std::string("?token=") + RunningServer::kToken;
  for (const std::string& bytes :
       {get("Connection: close\r\n"), "GET /" + token + " HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n",
        std::string("GET / HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n"), std::string("nonsense\r\n\r\n"),
        "GET / HTTP/1.1\r\nX: " + std::string(20000, 'x') + "\r\n\r\n", post("Transfer-Encoding: chunked\r\n"),
        post("Content-Length: 2000000\r\n"), post("Content-Length: 2\r\nContent-Length: 2\r\n"),
        std::string("GET /ws HTTP/1.1\r\nHost: localhost\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n\r\n")}) {
    const std::string answer = server_.raw(bytes);
    for (const char* header :
         {"X-Content-Type-Options: nosniff", "Referrer-Policy: no-referrer", "Cross-Origin-Resource-Policy: same-origin",
          "X-Frame-Options: SAMEORIGIN", "Content-Security-Policy: "})
      EXPECT_TRUE(has(answer, header)) << header << "\n" << bytes.substr(0, 200) << "\n" << answer;
    EXPECT_FALSE(has(answer, "unsafe-inline")) << answer;
  }
}

// The policy names the style of the server's own pages by its hash; whoever changes one changes both.
TEST(SecurityHeaders, AllowTheStyleOfTheServersOwnPages) {
  std::array<unsigned char, SHA256_DIGEST_LENGTH> hash{};
  SHA256(reinterpret_cast<const unsigned char*>(kPageStyle.data()), kPageStyle.size(), hash.data());
  std::array<unsigned char, 48> text{};
  EVP_EncodeBlock(text.data(), hash.data(), static_cast<int>(hash.size()));
  const HttpResponse page = message_page(404, "title", "text");
  EXPECT_TRUE(has(page.body, "<style>" + std::string(kPageStyle) + "</style>"));
  std::string policy;
  for (const auto& [name, value] : security_headers(page))
    if (name == "Content-Security-Policy") policy = value;
  EXPECT_TRUE(has(policy, "'sha256-" + std::string(reinterpret_cast<const char*>(text.data())) + "'")) << policy;
}

}  // namespace
}  // namespace isostrata
