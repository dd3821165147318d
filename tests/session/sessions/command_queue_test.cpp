#include "session/sessions/command_queue.h"

#include <gtest/gtest.h>

namespace isostrata {
namespace {

constexpr TimePoint kNow{std::chrono::hours(1)};

TEST(CommandQueueOfASession, DoesInOrderWhatWaitsUntilItMustWaitAgain) {
  CommandQueue queue;
  std::string done;
  bool opening = false;
  for (const char c : std::string("abc")) queue.add([&, c](TimePoint now) {
    EXPECT_EQ(now, kNow);
    done += c;
    if (c == 'b') opening = true;
    if (c == 'a') queue.add([&](TimePoint) { done += 'd'; });
  });
  const auto stop = [&] { return opening; };
  queue.run(kNow, stop);
  EXPECT_EQ(done, "ab") << "b opened another dataset";
  queue.run(kNow, stop);
  EXPECT_EQ(done, "ab");
  opening = false;
  queue.run(kNow, stop);
  EXPECT_EQ(done, "abcd");
  EXPECT_TRUE(queue.empty());
}

TEST(CommandQueueOfASession, MayBeRunFromWithin) {
  CommandQueue queue;
  std::string done;
  const auto never = [] { return false; };
  queue.add([&](TimePoint now) {
    done += 'a';
    queue.run(now, never);
  });
  queue.add([&](TimePoint) { done += 'b'; });
  queue.run(kNow, never);
  EXPECT_EQ(done, "ab");
}

TEST(CommandQueueOfASession, IsFullAtItsLimitAndNotBefore) {
  CommandQueue queue;
  for (std::size_t i = 0; i < CommandQueue::kMost; ++i) {
    EXPECT_FALSE(queue.full());
    queue.add([](TimePoint) {});
  }
  EXPECT_TRUE(queue.full());
}

TEST(CommandQueueOfASession, ACommandIsSettledWhenNoneOfItsClientWaitsBeforeIt) {
  CommandQueue queue;
  EXPECT_EQ(queue.settled("a", 9), 9u);
  queue.add([](TimePoint) {}, {"a", 7});
  queue.add([](TimePoint) {}, {"a", 9});
  queue.add([](TimePoint) {}, {"b", 2});
  queue.add([](TimePoint) {});
  EXPECT_EQ(queue.settled("a", 9), 6u);
  EXPECT_EQ(queue.settled("a", 5), 5u);
  EXPECT_EQ(queue.settled("b", 2), 1u);
  EXPECT_EQ(queue.settled("c", 4), 4u);
  EXPECT_EQ(queue.settled("", 4), 4u) << "what has no number keeps nobody back";
  EXPECT_EQ(CommandQueue::before({"a", 3}, "a", 9), 2u);
}

}  // namespace
}  // namespace isostrata
