// WebSocket frames by RFC 6455: what is right is obeyed, what is wrong closes the connection with the code that it names.
#include <gtest/gtest.h>

#include "net/running_server.h"

namespace isostrata {
namespace {

constexpr int kProtocolError = 1002, kBadText = 1007, kTooBig = 1009;
constexpr std::size_t kMost = 1 << 20;

std::string ws_target() { return std::string("/ws?token=") + RunningServer::kToken; }

std::string hello() {
  v1::ClientMessage message;
  message.set_seq(1);
  message.mutable_hello()->set_protocol_major(1);
  return message.SerializeAsString();
}

enum class Length { shortest, two_bytes, eight_bytes };

/// One frame. first: FIN, RSV and opcode.
std::string frame(int first, const std::string& payload, Length length = Length::shortest, bool masked = true) {
  std::string out(1, static_cast<char>(first));
  const int mask = masked ? 0x80 : 0;
  const std::size_t size = payload.size();
  if (length == Length::eight_bytes || size >= 65536) {
    out += static_cast<char>(mask | 127);
    for (int shift = 56; shift >= 0; shift -= 8) out += static_cast<char>(static_cast<std::uint64_t>(size) >> shift);
  } else if (length == Length::two_bytes || size >= 126) {
    out += static_cast<char>(mask | 126);
    out += static_cast<char>(size >> 8);
    out += static_cast<char>(size);
  } else {
    out += static_cast<char>(mask | static_cast<int>(size));
  }
  if (!masked) return out + payload;
  const std::string key = "\x12\x34\xab\xcd";
  std::string hidden = payload;
  for (std::size_t i = 0; i < size; ++i) hidden[i] = static_cast<char>(hidden[i] ^ key[i % 4]);
  return out + key + hidden;
}

std::string close_payload(int code, const std::string& reason = "") {
  return std::string{static_cast<char>(code >> 8), static_cast<char>(code)} + reason;
}

class Conformance : public ::testing::Test {
 protected:
  /// Of the close frame that ends it; 0: none came before the end; -1: it goes on.
  int close_code(const std::string& bytes, const std::string& before = "") {
    ++cases_;
    RawSocket socket(server_.port());
    EXPECT_EQ(status_of(socket.open_websocket(ws_target())), 101);
    socket.send(before + bytes);
    return code_of(socket);
  }
  /// Of bytes that are good frames and no messages of ours: what comes before the end does not matter.
  int end_code(const std::string& bytes) {
    RawSocket socket(server_.port());
    EXPECT_EQ(status_of(socket.open_websocket(ws_target())), 101);
    socket.send(bytes);
    while (const auto got = socket.read_frame())
      if (got->opcode == 8 && got->payload.size() >= 2)
        return static_cast<std::uint8_t>(got->payload[0]) << 8 | static_cast<std::uint8_t>(got->payload[1]);
    return 0;
  }
  int code_of(RawSocket& socket) {
    // Whoever still lives answers a ping that nobody else sends.
    const std::string mark = "still there?";
    socket.send(frame(0x89, mark));
    while (const auto got = socket.read_frame()) {
      if (got->opcode == 10 && got->payload == mark) return -1;
      if (got->opcode != 8) continue;
      return got->payload.size() < 2
                 ? 1005
                 : static_cast<std::uint8_t>(got->payload[0]) << 8 | static_cast<std::uint8_t>(got->payload[1]);
    }
    return 0;
  }
  RunningServer server_;
  int cases_ = 0;
};

TEST_F(Conformance, ReservedOpcodesAndBitsAreErrors) {
  for (int opcode = 0; opcode < 16; ++opcode)
    for (int bits = 0; bits < 8; ++bits)
      for (const int fin : {0x80, 0}) {
        const bool reserved = (opcode >= 3 && opcode <= 7) || opcode >= 11;
        if (!reserved && bits == 0) continue;
        EXPECT_EQ(close_code(frame(fin | bits << 4 | opcode, "x")), kProtocolError) << opcode << " " << bits << " " << fin;
      }
  EXPECT_GE(cases_, 240);
}

TEST_F(Conformance, FramesOfClientsAreMasked) {
  for (const int opcode : {1, 2, 8, 9, 10})
    EXPECT_EQ(close_code(frame(0x80 | opcode, opcode == 8 ? close_payload(1000) : "x", Length::shortest, false)), kProtocolError)
        << opcode;
}

TEST_F(Conformance, LengthsAreWrittenInTheShortestWay) {
  for (const std::size_t size : {0, 1, 125})
    for (const Length length : {Length::two_bytes, Length::eight_bytes})
      EXPECT_EQ(close_code(frame(0x82, std::string(size, 'x'), length)), kProtocolError) << size;
  for (const std::size_t size : {126, 65535})
    EXPECT_EQ(close_code(frame(0x82, std::string(size, 'x'), Length::eight_bytes)), kProtocolError) << size;
  EXPECT_NE(close_code(std::string("\x82\xff\x80\0\0\0\0\0\0\1\1\2\3\4", 14)), -1) << "a length whose first bit is set";
  EXPECT_NE(close_code(std::string("\x82\xff\x7f\xff\xff\xff\xff\xff\xff\xff\1\2\3\4", 14)), -1) << "the longest length";
}

TEST_F(Conformance, ControlFramesAreShortAndWhole) {
  for (const int opcode : {8, 9, 10}) {
    EXPECT_EQ(close_code(frame(0x80 | opcode, std::string(126, '\x03'))), kProtocolError) << opcode;
    EXPECT_EQ(close_code(frame(opcode, opcode == 8 ? close_payload(1000) : "x")), kProtocolError) << opcode;
  }
}

TEST_F(Conformance, APingIsAnsweredWithItsOwnBytes) {
  RawSocket socket(server_.port());
  ASSERT_EQ(status_of(socket.open_websocket(ws_target())), 101);
  for (std::size_t size = 0; size <= 125; size += 25) {
    const std::string payload(size, static_cast<char>('a' + size % 26));
    socket.send(frame(0x89, payload));
    std::optional<RawSocket::Frame> got;
    do got = socket.read_frame();
    while (got && got->opcode != 10);
    ASSERT_TRUE(got) << size;
    EXPECT_EQ(got->payload, payload);
  }
  socket.send(frame(0x8a, "nobody asked"));  // an answer to nothing is allowed
  EXPECT_EQ(code_of(socket), -1);
}

TEST_F(Conformance, FragmentsComeInOrder) {
  const std::string whole = hello();
  EXPECT_EQ(close_code(frame(0x80, "x")), kProtocolError) << "goes on with nothing";
  EXPECT_EQ(close_code(frame(0x00, "x")), kProtocolError) << "goes on with nothing, and on";
  for (const int opcode : {0x81, 0x82, 0x01, 0x02})
    EXPECT_EQ(close_code(frame(opcode, whole), frame(0x02, "")), kProtocolError) << "another message in between";
  EXPECT_EQ(close_code(frame(0x80, whole), frame(0x82, whole)), kProtocolError) << "goes on after the end";
  for (std::size_t cut = 0; cut <= whole.size(); ++cut) {
    const std::string before = frame(0x02, whole.substr(0, cut)) + frame(0x89, "in between");
    EXPECT_EQ(close_code(frame(0x80, whole.substr(cut)), before), -1) << "cut at " << cut;
  }
  std::string bytewise = frame(0x02, "");
  for (const char c : whole) bytewise += frame(0x00, std::string(1, c));
  EXPECT_EQ(close_code(frame(0x80, ""), bytewise), -1);
}

TEST_F(Conformance, MessagesEndAtTheirLimitAlsoInParts) {
  EXPECT_EQ(close_code(frame(0x82, std::string(kMost + 1, 'x'))), kTooBig);
  EXPECT_EQ(close_code(frame(0x80, std::string(kMost / 2 + 1, 'x')), frame(0x02, std::string(kMost / 2, 'x'))), kTooBig);
  std::string parts = frame(0x02, std::string(kMost / 16, 'x'));
  for (int i = 1; i < 16; ++i) parts += frame(0x00, std::string(kMost / 16, 'x'));
  EXPECT_EQ(close_code(frame(0x80, "x"), parts), kTooBig);
  EXPECT_EQ(close_code(frame(0x00, "x"), parts), kTooBig) << "before the message's end";
  EXPECT_EQ(end_code(frame(0x82, std::string(kMost, '\xff'))), kProtocolError) << "as large as allowed, and no message";
}

TEST_F(Conformance, CloseFramesSayWhyOrNothing) {
  EXPECT_EQ(close_code(frame(0x88, "")), 1000);
  EXPECT_EQ(close_code(frame(0x88, "\x03")), kProtocolError);
  for (const int code : {1000, 1001, 1002, 1003, 1007, 1008, 1009, 1010, 1011, 3000, 3999, 4000, 4999})
    EXPECT_EQ(close_code(frame(0x88, close_payload(code))), code);
  for (const int code : {0, 1, 999, 1004, 1005, 1006, 1015, 1016, 1100, 2000, 2999})
    EXPECT_EQ(close_code(frame(0x88, close_payload(code))), kProtocolError) << code;
  // Beast lets these pass; they end the connection all the same.
  for (const int code : {5000, 65535}) EXPECT_GE(close_code(frame(0x88, close_payload(code))), 1000) << code;
  EXPECT_EQ(close_code(frame(0x88, close_payload(1000, "goodbye, \xc3\xa9"))), 1000);
  for (const char* reason : {"\xff", "\xc3", "\xed\xa0\x80", "\xf4\x90\x80\x80", "\xc0\xaf"})
    EXPECT_EQ(close_code(frame(0x88, close_payload(1000, reason))), kProtocolError) << reason;
}

TEST_F(Conformance, TextIsUtf8) {
  for (const char* text : {"\xff", "a\xc3", "\xed\xa0\x80", "\xf4\x90\x80\x80", "\xc0\xaf", "\x80", "\xf8\x88\x80\x80\x80"})
    EXPECT_EQ(close_code(frame(0x81, text)), kBadText) << text;
  EXPECT_EQ(close_code(frame(0x80, "\x28"), frame(0x01, "\xc3")), kBadText) << "cut within a character";
  EXPECT_EQ(end_code(frame(0x81, "good text")), kProtocolError) << "good text, but messages are binary";
}

TEST_F(Conformance, UpgradesAreWhatTheRfcAsksFor) {
  const std::string key = "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n", version = "Sec-WebSocket-Version: 13\r\n",
                    protocol = "Sec-WebSocket-Protocol: isostrata.v1\r\n",
                    upgrade = "Upgrade: websocket\r\nConnection: Upgrade\r\n";
  const auto asked = [&](const std::string& headers, const std::string& first = "GET", const std::string& http = "HTTP/1.1") {
    RawSocket socket(server_.port());
    socket.send(first + " " + ws_target() + " " + http + "\r\nHost: localhost\r\n" + headers + "\r\n");
    std::string answer;
    for (std::string piece; answer.find("\r\n\r\n") == std::string::npos && !(piece = socket.read_piece()).empty();)
      answer += piece;
    return answer;
  };
  EXPECT_EQ(status_of(asked(upgrade + key + version + protocol)), 101);
  EXPECT_EQ(status_of(asked(upgrade + key + version + "Sec-WebSocket-Protocol: other\r\n" + protocol)), 101)
      << "one after the other";
  EXPECT_EQ(status_of(asked(upgrade + key + version + "Sec-WebSocket-Protocol: other,\tisostrata.v1 , third\r\n")), 101);
  EXPECT_EQ(status_of(asked("Upgrade: WebSocket\r\nConnection: keep-alive, Upgrade\r\n" + key + version + protocol)), 101);
  EXPECT_EQ(status_of(asked(upgrade + version + protocol)), 400) << "no key";
  EXPECT_EQ(status_of(asked(upgrade + key + key + version + protocol)), 400) << "two keys";
  for (const char* bad :
       {"", "x", "dGhlIHNhbXBsZSBub25jZQ=", "dGhlIHNhbXBsZSBub25jZQ===", "dGhlIHNhbXBsZSBub25jZR==", "dGhlIHNhbXBsZSBub25jZQAA",
        "dGhlIHNhbXBsZSBub25j!Q==", "dGhlIHNhbXBsZSBub25jZQ==, dGhlIHNhbXBsZSBub25jZQ=="})
    EXPECT_EQ(status_of(asked(upgrade + "Sec-WebSocket-Key: " + bad + "\r\n" + version + protocol)), 400) << bad;
  EXPECT_EQ(status_of(asked(upgrade + key + protocol)), 400) << "no version";
  EXPECT_EQ(status_of(asked(upgrade + key + version + version + protocol)), 400) << "two versions";
  for (const char* other : {"8", "0", "14", "13, 8", "x"}) {
    const std::string answer = asked(upgrade + key + "Sec-WebSocket-Version: " + other + "\r\n" + protocol);
    EXPECT_EQ(status_of(answer), 426) << other;
    EXPECT_TRUE(has(answer, "Sec-WebSocket-Version: 13")) << answer;
  }
  EXPECT_EQ(status_of(asked(upgrade + key + version)), 400) << "no protocol";
  EXPECT_EQ(status_of(asked(upgrade + key + version + "Sec-WebSocket-Protocol: isostrata.v1x\r\n")), 400);
  EXPECT_EQ(status_of(asked(upgrade + "Upgrade: h2c\r\n" + key + version + protocol)), 400) << "two upgrades";
  EXPECT_EQ(status_of(asked(upgrade + key + version + protocol + "Content-Length: 5\r\n")), 400) << "a body";
  EXPECT_NE(status_of(asked(upgrade + key + version + protocol, "POST")), 101);
  EXPECT_NE(status_of(asked(upgrade + key + version + protocol, "GET", "HTTP/1.0")), 101);
  EXPECT_NE(status_of(asked("Connection: Upgrade\r\n" + key + version + protocol)), 101);
  EXPECT_NE(status_of(asked("Upgrade: websocket\r\n" + key + version + protocol)), 101);
}

// A client may send its first frame with the upgrade, without waiting for the answer.
TEST_F(Conformance, AFrameInTheSegmentOfTheUpgradeIsKept) {
  for (const std::size_t cut : {std::size_t{0}, std::size_t{1}, std::size_t{5}, frame(0x82, hello()).size()}) {
    const std::string first = frame(0x82, hello());
    RawSocket socket(server_.port());
    const std::string head = socket.open_websocket_with(ws_target(), first.substr(0, cut));
    ASSERT_EQ(status_of(head), 101) << cut;
    socket.send(first.substr(cut));
    std::optional<RawSocket::Frame> got;
    do got = socket.read_frame();
    while (got && got->opcode != 2);
    ASSERT_TRUE(got) << cut;
    v1::ServerMessage message;
    ASSERT_TRUE(message.ParseFromString(got->payload));
    EXPECT_TRUE(message.has_welcome()) << cut;
  }
}

}  // namespace
}  // namespace isostrata
