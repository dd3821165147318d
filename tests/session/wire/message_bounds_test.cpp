#include "session/wire/message_bounds.h"

#include <gtest/gtest.h>

#include "isostrata/v1/isostrata.pb.h"
#include "session/wire/limits.h"

namespace isostrata {
namespace {

std::optional<std::string> checked(const v1::ClientMessage& message) {
  return holds_too_much(*message.GetDescriptor(), message.SerializeAsString());
}

// As much of everything as a session may have.
TEST(MessageBounds, LetTheFullestStatePass) {
  v1::State state;
  for (int i = 0; i < kMaxIntervals; ++i) {
    v1::Interval& interval = *state.add_intervals();
    interval.set_id(static_cast<std::uint32_t>(i + 1));
    interval.set_lower(i);
    interval.set_upper(i + 1);
    interval.set_name(std::string(kMaxNameBytes / 2, 'n'));
    interval.mutable_color()->set_r(0.5);
    interval.mutable_color()->set_g(0.25);
    interval.mutable_color()->set_b(0.125);
    interval.mutable_surface()->set_lower(true);
    for (int p = 0; p < kMaxTransferPoints / kMaxIntervals; ++p) interval.mutable_transfer_function()->add_points()->set_value(p);
  }
  for (int i = 0; i < kMaxTerms; ++i) state.add_terms()->set_lower(1);
  for (int i = 0; i < kMaxClipPlanes; ++i) state.add_clip_planes()->mutable_normal()->set_x(1);
  EXPECT_EQ(holds_too_much(*state.GetDescriptor(), state.SerializeAsString()), std::nullopt);
}

TEST(MessageBounds, RefuseLongListsAndManyFields) {
  v1::ClientMessage message;
  for (std::size_t i = 0; i <= kMaxListed; ++i) message.mutable_set_intervals()->add_intervals();
  EXPECT_EQ(checked(message), "more than 1024 elements in 'intervals'");
  message.mutable_set_intervals()->mutable_intervals()->RemoveLast();
  EXPECT_EQ(checked(message), std::nullopt);
  for (auto& interval : *message.mutable_set_intervals()->mutable_intervals())
    for (int p = 0; p < 20; ++p) interval.mutable_transfer_function()->add_points();
  EXPECT_EQ(checked(message), "more than 20000 fields");
  EXPECT_NE(holds_too_much(*message.GetDescriptor(), std::string(200000, '\x08')), std::nullopt)
      << "the same field again and again";
}

TEST(MessageBounds, LeaveNonsenseToTheParser) {
  const auto& type = *v1::ClientMessage::descriptor();
  for (const std::string& bytes :
       {std::string(), std::string("\xff\xff\xff\xff\xff\xff"), std::string("\x0a\xff\xff\xff\xff\x0f", 6),
        std::string("\x0a\x05x", 3), std::string(1, '\0'), std::string("\x0b\x0b\x0b", 3)})
    EXPECT_EQ(holds_too_much(type, bytes), std::nullopt);
}

}  // namespace
}  // namespace isostrata
