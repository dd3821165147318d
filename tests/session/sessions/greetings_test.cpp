#include "session/sessions/greetings.h"

#include <gtest/gtest.h>

#include "session/fake_engine.h"
#include "session/wire/limits.h"

namespace isostrata {
namespace {

v1::ClientMessage hello() {
  v1::ClientMessage message;
  message.mutable_hello()->set_protocol_major(kProtocolMajor);
  return message;
}

std::string refused(const v1::ClientMessage& message) {
  const auto refusal = refuse_hello(message);
  return refusal ? refusal->error.code() + " " + refusal->error.field() : "";
}

TEST(GreetingsOfAConnection, BeginWithAHelloOfThisProtocol) {
  EXPECT_EQ(refused(hello()), "");
  v1::ClientMessage ping, newer = hello();
  ping.mutable_ping();
  EXPECT_EQ(refused(ping), "malformed ");
  EXPECT_EQ(refuse_hello(ping)->close_code, kCloseProtocolError);
  newer.mutable_hello()->set_protocol_major(kProtocolMajor + 1);
  EXPECT_EQ(refused(newer), "unsupported_version hello.protocol_major");
  EXPECT_EQ(refuse_hello(newer)->close_code, kClosePolicy);
}

TEST(GreetingsOfAConnection, NameTheFieldThatIsRefused) {
  v1::ClientMessage message = hello();
  message.mutable_hello()->add_still_formats("webp");
  EXPECT_EQ(refused(message), "unsupported hello.still_formats");
  message = hello();
  message.mutable_hello()->add_moving_formats("vp9-444");
  EXPECT_EQ(refused(message), "unsupported hello.moving_formats");
  message.mutable_hello()->add_moving_formats("jpeg");
  EXPECT_EQ(refused(message), "");
  message.mutable_hello()->set_moving_format("another");
  EXPECT_EQ(refused(message), "invalid_argument hello.moving_format");
  message = hello();
  message.mutable_hello()->mutable_viewport()->set_width(0);
  EXPECT_EQ(refused(message), "invalid_argument hello.viewport.width");
  const std::string longest(kMaxPersonBytes, 'x');
  message = hello();
  message.mutable_hello()->set_name(longest);
  message.mutable_hello()->set_client_id(longest);
  message.mutable_hello()->set_client(longest);
  EXPECT_EQ(refused(message), "");
  message.mutable_hello()->set_client(longest + "x");
  EXPECT_EQ(refused(message), "invalid_argument hello.client");
  message.mutable_hello()->set_client_id(longest + "x");
  EXPECT_EQ(refused(message), "invalid_argument hello.client_id");
}

TEST(GreetingsOfAConnection, MessagesAreNumberedUpwards) {
  EXPECT_FALSE(refuse_seq(2, 1));
  EXPECT_FALSE(refuse_seq(100, 1));
  for (const std::uint64_t seq : {0, 1, 2}) EXPECT_EQ(refuse_seq(seq, 2)->close_code, kCloseProtocolError);
}

std::vector<Codec> codecs_for(const v1::Hello& hello, bool* chooses = nullptr) {
  const std::vector<Codec> server{Codec::vp9_444, Codec::jpeg};
  Viewer viewer;
  introduce(viewer, hello, server);
  if (chooses) *chooses = viewer.format.chooses();
  return viewer.format.codecs();
}

TEST(GreetingsOfAConnection, VideoIsForWhoSaysToHaveDecodedIt) {
  v1::Hello hello;
  EXPECT_EQ(codecs_for(hello), std::vector{Codec::jpeg});
  hello.add_moving_formats("jpeg");
  EXPECT_EQ(codecs_for(hello), std::vector{Codec::jpeg});
  hello.add_moving_formats(std::string(name_of(Codec::vp9_444)));
  bool chooses = false;
  EXPECT_EQ(codecs_for(hello, &chooses), (std::vector{Codec::vp9_444, Codec::jpeg}));
  EXPECT_TRUE(chooses);
  hello.set_moving_format("jpeg");
  EXPECT_EQ(codecs_for(hello, &chooses), std::vector{Codec::jpeg}) << "what comes before it is not stepped up to";
  EXPECT_FALSE(chooses);
  hello.set_moving_format("a codec that this server lacks");
  codecs_for(hello, &chooses);
  EXPECT_TRUE(chooses);
}

TEST(GreetingsOfAConnection, AGuestsClientCannotPassForTheOwners) {
  v1::Hello hello;
  hello.set_client_id("page");
  hello.add_still_formats("png-bands");
  Viewer owner, guest, nameless;
  guest.invitation = nameless.invitation = "abc";
  introduce(owner, hello, {});
  introduce(guest, hello, {});
  EXPECT_EQ(owner.client_id, "page");
  EXPECT_EQ(guest.client_id, "abc/page");
  EXPECT_TRUE(owner.takes_bands);
  introduce(nameless, {}, {});
  EXPECT_EQ(nameless.client_id, "");
  EXPECT_FALSE(nameless.takes_bands);
  EXPECT_EQ(owner.format.codec(), Codec::jpeg) << "also of a server without any";
}

TEST(GreetingsOfAConnection, TheLastWordSaysWhenAndWhetherSessionsComeBack) {
  const v1::Shutdown notice = end_notice("maintenance", 5000, 2000, true).shutdown();
  EXPECT_TRUE(notice.notice());
  EXPECT_EQ(notice.seconds(), 3);
  EXPECT_EQ(notice.deadline_unix_ms(), 5000);
  EXPECT_TRUE(notice.comes_back());
  const v1::Shutdown last = last_word("done", std::chrono::seconds(3), 2000, false).shutdown();
  EXPECT_FALSE(last.notice());
  EXPECT_EQ(last.seconds(), 3);
  EXPECT_EQ(last.deadline_unix_ms(), 5000);
  EXPECT_FALSE(last.comes_back());
}

TEST(GreetingsOfAConnection, ARefusalIsAnAnswerAndTheEnd) {
  FakeOutbox outbox;
  Viewer viewer;
  viewer.outbox = &outbox;
  v1::Error error;
  error.set_code("forbidden");
  refuse(viewer, {error, kCloseTryAgainLater}, 17);
  EXPECT_EQ(outbox.error().in_reply_to(), 17u);
  EXPECT_EQ(outbox.closed, kCloseTryAgainLater);
}

}  // namespace
}  // namespace isostrata
