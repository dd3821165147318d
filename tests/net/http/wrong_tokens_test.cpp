#include "net/http/wrong_tokens.h"

#include <gtest/gtest.h>

#include "net/running_server.h"

namespace isostrata {
namespace {

using namespace std::chrono_literals;

TEST(WrongTokens, WaitLongerEachTimeUpToALimit) {
  WrongTokens tokens;
  WrongTokens::Clock::time_point now{};
  for (int i = 0; i < WrongTokens::kFree; ++i) EXPECT_EQ(tokens.note("a", now), 0ms) << i;
  auto last = tokens.note("a", now);
  EXPECT_EQ(last, WrongTokens::kFirst);
  for (int i = 0; i < 100; ++i) {
    const auto next = tokens.note("a", now);
    EXPECT_EQ(next, std::min<std::chrono::milliseconds>(2 * last, WrongTokens::kLongest));
    last = next;
  }
  EXPECT_EQ(last, WrongTokens::kLongest);
  EXPECT_EQ(tokens.note("b", now), 0ms) << "another address";
  EXPECT_EQ(tokens.note("a", now + 3600s), 0ms) << "an hour later";
}

TEST(WrongTokens, ManyAddressesFillNoMemoryAndHideNobody) {
  WrongTokens tokens;
  WrongTokens::Clock::time_point now{};
  for (int i = 0; i < 100; ++i) tokens.note("persistent", now);
  for (std::size_t i = 0; i < 3 * WrongTokens::kMostAddresses; ++i) tokens.note(std::to_string(i), now);
  EXPECT_EQ(tokens.note("persistent", now), WrongTokens::kLongest);
}

TEST(WrongTokens, WhoHasTheRightOneIsServedAllTheSame) {
  RunningServer server;
  for (int i = 0; i < WrongTokens::kFree + 2; ++i)
    EXPECT_EQ(status_of(server.raw("GET /api/v1/sessions?token=wrong" + std::to_string(i) +
                                   " HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n")),
              401);
  EXPECT_EQ(status_of(server.ask("GET", "/api/v1/sessions")), 200);
  EXPECT_EQ(status_of(RawSocket(server.port()).open_websocket("/ws?token=wrong")), 401);
  EXPECT_EQ(status_of(RawSocket(server.port()).open_websocket(std::string("/ws?token=") + RunningServer::kToken)), 101);
}

}  // namespace
}  // namespace isostrata
