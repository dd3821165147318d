#include "session/people/client_commands.h"

#include <gtest/gtest.h>

namespace isostrata {
namespace {

v1::Error error_of(const std::string& code) {
  v1::Error error;
  error.set_code(code);
  return error;
}

TEST(ClientCommandsOfASession, EachIsDoneOnceHoweverOftenItIsSent) {
  ClientCommands commands;
  EXPECT_EQ(commands.last("a"), 0u);
  EXPECT_FALSE(commands.done_before({"a", 5}, false));
  EXPECT_TRUE(commands.done_before({"a", 5}, false));
  EXPECT_TRUE(commands.done_before({"a", 4}, false)) << "numbers grow";
  EXPECT_FALSE(commands.done_before({"b", 5}, false)) << "another's number";
  EXPECT_FALSE(commands.done_before({"a", 6}, false));
  EXPECT_EQ(commands.last("a"), 6u);
  EXPECT_EQ(commands.last("b"), 5u);
  EXPECT_EQ(commands.all().size(), 2u);
}

TEST(ClientCommandsOfASession, WithoutANumberOrAClientAreDoneEachTime) {
  ClientCommands commands;
  for (int i = 0; i < 2; ++i) {
    EXPECT_FALSE(commands.done_before({"a", 0}, false));
    EXPECT_FALSE(commands.done_before({"", 7}, false));
  }
  EXPECT_TRUE(commands.all().empty());
  EXPECT_EQ(commands.last(""), 0u);
}

TEST(ClientCommandsOfASession, AVerdictIsOfTheNewestCommandAlone) {
  ClientCommands commands;
  commands.done_before({"a", 1}, false);
  commands.done_before({"b", 1}, false);
  EXPECT_EQ(commands.last_error("a"), nullptr);
  commands.note_refused({"a", 1}, error_of("not_found"));
  ASSERT_NE(commands.last_error("a"), nullptr);
  EXPECT_EQ(commands.last_error("a")->code(), "not_found");
  EXPECT_EQ(commands.last_error("b"), nullptr);
  commands.done_before({"a", 2}, false);
  EXPECT_EQ(commands.last_error("a"), nullptr) << "that of an older one";
  commands.note_refused({"a", 1}, error_of("late"));
  EXPECT_EQ(commands.last_error("a"), nullptr) << "that came late";
  commands.note_refused({"", 0}, error_of("nobody"));
  EXPECT_EQ(commands.last_error(""), nullptr);
}

TEST(ClientCommandsOfASession, WhoWasHeardTheLongestAgoIsForgottenAmongItsLike) {
  ClientCommands commands;
  commands.done_before({"owner", 9}, false);
  for (std::size_t i = 0; i < 3 * ClientCommands::kMostClients; ++i) commands.done_before({"guest " + std::to_string(i), 1}, true);
  EXPECT_EQ(commands.last("owner"), 9u);
  EXPECT_EQ(commands.all().size(), 1 + ClientCommands::kMostClients);
  EXPECT_EQ(commands.last("guest 0"), 0u);
  // Who is heard again is not the oldest any more.
  const std::size_t oldest = 2 * ClientCommands::kMostClients;
  commands.done_before({"guest " + std::to_string(oldest), 2}, true);
  commands.done_before({"one more", 1}, true);
  EXPECT_EQ(commands.last("guest " + std::to_string(oldest)), 2u);
  EXPECT_EQ(commands.last("guest " + std::to_string(oldest + 1)), 0u);
}

}  // namespace
}  // namespace isostrata
