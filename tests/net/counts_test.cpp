// Bodies and messages below the limit of bytes that hold hundreds of thousands of elements: refused before anything is made of
// them.
#include <gtest/gtest.h>

#include "net/http/json_body.h"
#include "net/running_server.h"
#include "session/wire/limits.h"
#include "session/wire/message_bounds.h"

namespace isostrata {
namespace {

std::string repeated(const std::string& element, std::size_t count) {
  std::string out = "[";
  for (std::size_t i = 0; i < count; ++i) out += (i ? "," : "") + element;
  return out + "]";
}

TEST(Counts, OfElementsInABodyAreBounded) {
  RunningServer server;
  const auto made = server.ask("POST", "/api/v1/sessions", "{}");
  const std::string id = made.substr(made.find("\"id\":\"") + 6, 16);
  const std::string below = "/api/v1/sessions/" + id;
  for (const std::string& body :
       {"{\"intervals\":" + repeated("{}", 300'000) + "}", "{\"intervals\":" + repeated("{}", kMaxListed + 1) + "}",
        "{\"intervals\":[{\"transferFunction\":{\"points\":" + repeated("{}", 300'000) + "}}]}",
        "{\"intervals\":" + repeated("null", 200'000) + "}", "{\"intervals\":" + repeated(repeated("1", 400), 60) + "}",
        "{\"times\":" + repeated("0", 500'000) + "}"}) {
    ASSERT_LT(body.size(), kMaxMessageBytes);
    const auto answer = server.ask("PUT", below + "/state", body);
    EXPECT_EQ(status_of(answer), 413) << answer;
    EXPECT_TRUE(has(answer, "too_large")) << answer;
  }
  EXPECT_NE(status_of(server.ask("PUT", below + "/state", "{\"intervals\":" + repeated("{}", 300) + "}")), 413)
      << "that is for the command to judge";
  EXPECT_TRUE(server.answers());
}

TEST(Counts, OfElementsInAMessageAreBounded) {
  RunningServer server;
  v1::ClientMessage message;
  message.set_seq(2);
  for (int i = 0; i < 300'000; ++i) message.mutable_set_intervals()->add_intervals();
  const std::string bytes = message.SerializeAsString();
  ASSERT_LT(bytes.size(), kMaxMessageBytes);
  RawSocket socket(server.port());
  ASSERT_EQ(status_of(socket.open_websocket(std::string("/ws?token=") + RunningServer::kToken)), 101);
  v1::ClientMessage hello;
  hello.set_seq(1);
  hello.mutable_hello()->set_protocol_major(1);
  socket.send_frame(hello.SerializeAsString());
  socket.send_frame(bytes);
  socket.send_frame(std::string("\x03\xe8", 2), 8);
  bool closed = false;
  const std::string answer = socket.read_all(&closed);
  EXPECT_TRUE(closed);
  EXPECT_TRUE(has(answer, "more than 1024 elements")) << answer;
  EXPECT_TRUE(server.answers());
}

// The fullest state that there can be, as JSON.
TEST(Counts, LetTheFullestStatePass) {
  std::string interval =
      "{\"id\":1,\"lower\":0.25,\"upper\":0.5,\"color\":{\"r\":1,\"g\":1,\"b\":1},\"opacity\":1,\"visible\":true,\"name\":\"n\","
      "\"priority\":1,"
      "\"ownRange\":true,\"number\":1,\"surface\":{\"lower\":true,\"upper\":true,\"domain\":true},\"transferFunction\":{"
      "\"points\":" +
      repeated("{\"value\":1,\"color\":{\"r\":1,\"g\":1,\"b\":1},\"opacity\":1}", kMaxTransferPoints / kMaxIntervals) + "}}";
  boost::json::object object;
  EXPECT_FALSE(parse_object("{\"intervals\":" + repeated(interval, kMaxIntervals) + "}", object));
}

}  // namespace
}  // namespace isostrata
