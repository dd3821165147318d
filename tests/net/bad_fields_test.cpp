// Every field of every message out of its range, on a real socket: found by reflection, so that a field of tomorrow is among
// them.
#include <google/protobuf/descriptor.h>
#include <google/protobuf/message.h>
#include <gtest/gtest.h>

#include <limits>
#include <set>

#include "net/running_server.h"

namespace isostrata {
namespace {

namespace pb = google::protobuf;
using client::Client;

using Path = std::vector<const pb::FieldDescriptor*>;

/// All leaves below a message, lists by one element, at most `depth` messages deep.
void add_leaves(const pb::Descriptor& type, int depth, Path& path, std::vector<Path>& leaves) {
  for (int i = 0; i < type.field_count(); ++i) {
    path.push_back(type.field(i));
    if (!type.field(i)->message_type())
      leaves.push_back(path);
    else if (depth > 0)
      add_leaves(*type.field(i)->message_type(), depth - 1, path, leaves);
    path.pop_back();
  }
}

constexpr int kExtremes = 5;

template <class T>
T extreme_number(int which) {
  if constexpr (std::is_floating_point_v<T>) {
    const T values[kExtremes] = {std::numeric_limits<T>::quiet_NaN(), std::numeric_limits<T>::infinity(),
                                 -std::numeric_limits<T>::infinity(), std::numeric_limits<T>::max(),
                                 std::numeric_limits<T>::denorm_min()};
    return values[which];
  } else {
    const T values[kExtremes] = {std::numeric_limits<T>::max(), std::numeric_limits<T>::min(), static_cast<T>(-1), T{0},
                                 T{77777}};
    return values[which];
  }
}

std::string extreme_text(int which) {
  const std::string values[kExtremes] = {std::string(5000, 'x'), std::string("\0", 1), "../../etc/passwd", "",
                                         "\xf0\x9f\x98\x80"};
  return values[which];
}

void set_extreme(pb::Message& message, const Path& path, std::size_t at, int which) {
  const pb::FieldDescriptor* f = path[at];
  const pb::Reflection& r = *message.GetReflection();
  if (f->message_type())
    return set_extreme(f->is_repeated() ? *r.AddMessage(&message, f) : *r.MutableMessage(&message, f), path, at + 1, which);
  switch (f->cpp_type()) {
#define SET(CASE, NAME, VALUE)              \
  case pb::FieldDescriptor::CPPTYPE_##CASE: \
    if (f->is_repeated())                   \
      r.Add##NAME(&message, f, VALUE);      \
    else                                    \
      r.Set##NAME(&message, f, VALUE);      \
    return
    SET(INT32, Int32, extreme_number<std::int32_t>(which));
    SET(UINT32, UInt32, extreme_number<std::uint32_t>(which));
    SET(INT64, Int64, extreme_number<std::int64_t>(which));
    SET(UINT64, UInt64, extreme_number<std::uint64_t>(which));
    SET(FLOAT, Float, extreme_number<float>(which));
    SET(DOUBLE, Double, extreme_number<double>(which));
    SET(BOOL, Bool, which % 2 == 0);
    SET(ENUM, EnumValue, extreme_number<std::int32_t>(which));
    SET(STRING, String, extreme_text(which));
#undef SET
    default:
      return;
  }
}

const std::set<std::string> kCodes = {"invalid_argument", "not_found", "bad_data",    "unsupported",
                                      "too_large",        "cancelled", "unavailable", "malformed"};

TEST(BadFields, EachGetsATypedErrorOrIsTakenAndAnotherSessionGoesOn) {
  RunningServer server;
  Client bystander(server.client_options());
  bystander.open_dataset("tets-6");
  Client client(server.client_options());
  client.open_dataset("torus-12");

  std::vector<Path> leaves;
  const pb::Descriptor& messages = *v1::ClientMessage::descriptor();
  for (int i = 0; i < messages.oneof_decl(0)->field_count(); ++i) {
    Path path{messages.oneof_decl(0)->field(i)};
    add_leaves(*path[0]->message_type(), 4, path, leaves);
  }
  ASSERT_GT(leaves.size(), 100u);
  int sent = 0, errors = 0;
  for (const Path& path : leaves)
    for (int which = 0; which < kExtremes; ++which) {
      v1::ClientMessage message;
      set_extreme(message, path, 0, which);
      client.send(std::move(message));
      if (++sent % 16 != 0) continue;
      v1::ClientMessage ping;
      ping.mutable_ping()->set_client_time_ms(sent);
      client.send(std::move(ping));
      for (bool pong = false; !pong;) {
        const auto answer = client.receive(std::chrono::milliseconds(20000));
        ASSERT_TRUE(answer) << "no answer after " << path.back()->full_name();
        pong = answer->has_pong() && answer->pong().client_time_ms() == sent;
        if (!answer->has_error()) continue;
        ++errors;
        EXPECT_TRUE(kCodes.contains(answer->error().code())) << answer->error().ShortDebugString();
        EXPECT_FALSE(answer->error().message().empty());
        EXPECT_LT(answer->error().message().size(), 9000u);
      }
    }
  EXPECT_GT(errors, sent / 4);
  EXPECT_EQ(client.state().dataset(), "torus-12") << "whatever was wrong has closed the dataset";
  EXPECT_EQ(bystander.lossless_frame().width(), 64u);
  EXPECT_TRUE(server.answers());
}

TEST(BadFields, WhatIsNestedDeepOrUnknownOrRepeatedEndsNothing) {
  RunningServer server;
  Client client(server.client_options());
  client.open_dataset("torus-12");
  const auto framed = [](int field, const std::string& body) {
    std::string out;
    const auto number = [&](std::uint64_t v) {
      for (; v > 127; v >>= 7) out += static_cast<char>(v | 128);
      out += static_cast<char>(v);
    };
    number(static_cast<std::uint64_t>(field) << 3 | 2);
    number(body.size());
    return out + body;
  };
  v1::ClientMessage hello;
  hello.set_seq(1);
  hello.mutable_hello()->set_protocol_major(1);
  hello.mutable_hello()->set_resume_token(client.welcome().resume_token());

  // A field that no version knows, in a message and beside it: ignored.
  // A message twice in one: Protobuf merges them, and the last of two different ones counts.
  // Nested deeper than Protobuf reads: malformed.
  std::string deep;
  for (int i = 0; i < 5000; ++i) deep = framed(8, deep);
  v1::ClientMessage view;
  view.set_seq(2);
  view.mutable_set_view()->set_view("+x");
  struct Case {
    std::string bytes;
    bool survives;
  };
  for (const Case& c :
       {Case{view.SerializeAsString() + framed(9999, "anything"), true},
        Case{view.SerializeAsString() + view.SerializeAsString(), true},
        Case{"\x08\x02" + framed(11, framed(1, "+y") + framed(777, "?")), true}, Case{"\x08\x02" + framed(12345, deep), true},
        Case{"\x08\x02" + framed(11, "\x0b" + std::string(5000, '\x0b')), false}}) {
    RawSocket socket(server.port());
    ASSERT_EQ(status_of(socket.open_websocket(std::string("/ws?token=") + RunningServer::kToken)), 101);
    ASSERT_TRUE(socket.send_frame(hello.SerializeAsString()));
    ASSERT_TRUE(socket.send_frame(c.bytes));
    v1::ClientMessage ping;
    ping.set_seq(3);
    ping.mutable_ping()->set_client_time_ms(5);
    socket.send_frame(ping.SerializeAsString());
    bool pong = false, malformed = false;
    while (!pong) {
      const auto frame = socket.read_frame();
      if (!frame || frame->opcode == 8) break;
      if (frame->opcode == 9) continue;  // the connection's own pings
      v1::ServerMessage answer;
      ASSERT_TRUE(answer.ParseFromString(frame->payload));
      pong = answer.has_pong();
      malformed = malformed || (answer.has_error() && answer.error().code() == "malformed");
    }
    EXPECT_EQ(pong, c.survives) << c.bytes.size();
    EXPECT_EQ(malformed, !c.survives) << c.bytes.size();
  }
  EXPECT_EQ(client.lossless_frame().width(), 64u);
}

TEST(BadFields, AReplayedMessageEndsTheConnectionAndNotTheSession) {
  RunningServer server;
  Client other(server.client_options());
  other.open_dataset("torus-12");
  RawSocket socket(server.port());
  ASSERT_EQ(status_of(socket.open_websocket(std::string("/ws?token=") + RunningServer::kToken)), 101);
  v1::ClientMessage hello, view;
  hello.set_seq(1);
  hello.mutable_hello()->set_protocol_major(1);
  hello.mutable_hello()->set_resume_token(other.welcome().resume_token());
  view.set_seq(2);
  view.mutable_set_view()->set_view("-z");
  for (const auto& message : {hello, view, view}) socket.send_frame(message.SerializeAsString());
  std::string code;
  auto frame = socket.read_frame();
  for (; frame && frame->opcode != 8; frame = socket.read_frame()) {
    if ((frame->opcode & 15) == 9) continue;  // a ping
    v1::ServerMessage answer;
    ASSERT_TRUE(answer.ParseFromString(frame->payload));
    if (answer.has_error()) code = answer.error().code() + " " + answer.error().field();
  }
  EXPECT_EQ(code, "malformed seq");
  EXPECT_TRUE(frame) << "the server has not said goodbye";
  EXPECT_EQ(other.lossless_frame().width(), 64u);
}

}  // namespace
}  // namespace isostrata
