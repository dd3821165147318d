#include "worker/message_channel.h"

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <filesystem>
#include <thread>

namespace isostrata {
namespace {

std::size_t open_descriptors() {
  return static_cast<std::size_t>(
      std::distance(std::filesystem::directory_iterator("/proc/self/fd"), std::filesystem::directory_iterator()));
}

MessageBytes message(std::size_t body, std::size_t picture) {
  MessageBytes bytes;
  for (std::size_t i = 0; i < body; ++i) bytes.body += static_cast<char>(i * 7);
  auto pixels = std::make_shared<Bytes>(picture);
  for (std::size_t i = 0; i < picture; ++i) (*pixels)[i] = static_cast<std::uint8_t>(i * 31);
  if (picture > 0) bytes.picture = pixels;
  return bytes;
}

TEST(MessageChannel, MessagesOfEverySizeArriveInOrderAndLeaveNoDescriptor) {
  const std::size_t before = open_descriptors();
  {
    auto [a, b] = MessageChannel::make_pair();
    MessageChannel here(std::move(a)), there(std::move(b));
    const std::vector<std::pair<std::size_t, std::size_t>> sizes = {
        {0, 0}, {5, 0}, {5, 1}, {3, MessageChannel::kMaxInline}, {3, MessageChannel::kMaxInline + 1}, {900000, 3000000}, {1, 0}};
    std::thread sender([&] {
      for (const auto& [body, picture] : sizes) here.send(message(body, picture));
      here.shut_down();
    });
    for (const auto& [body, picture] : sizes) {
      const auto got = there.receive();
      ASSERT_TRUE(got);
      const MessageBytes sent = message(body, picture);
      EXPECT_EQ(got->body, sent.body);
      ASSERT_EQ(got->picture == nullptr, picture == 0);
      if (picture > 0) {
        EXPECT_EQ(*got->picture, *sent.picture);
      }
    }
    EXPECT_FALSE(there.receive()) << "the other side is gone";
    sender.join();
    EXPECT_THROW(there.send(message(5, 0)), Error);
  }
  EXPECT_EQ(open_descriptors(), before);
}

TEST(MessageChannel, NonsenseOnTheLineIsRefused) {
  for (const std::string& nonsense : {std::string(64, 'x'), std::string(64, '\0'),
                                      std::string("\x49\x73\x61\x4d\0\0\0\0\xff\xff\xff\xff\xff\xff\xff\xff"
                                                  "\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0",
                                                  32)}) {
    auto [a, b] = MessageChannel::make_pair();
    MessageChannel channel(std::move(b));
    ASSERT_EQ(write(a.get(), nonsense.data(), nonsense.size()), static_cast<ssize_t>(nonsense.size()));
    EXPECT_THROW(channel.receive(), Error);
  }
}

TEST(MessageChannel, AMessageThatEndsInTheMiddleIsNone) {
  auto [a, b] = MessageChannel::make_pair();
  MessageChannel channel(std::move(b));
  ASSERT_EQ(write(a.get(), "Isa", 3), 3);
  a.close();
  EXPECT_FALSE(channel.receive());
}

}  // namespace
}  // namespace isostrata
