#include "session/journal/protobuf_log.h"

#include <gtest/gtest.h>

#include <vector>

#include "isostrata/v1/isostrata.pb.h"

namespace isostrata {
namespace {

// What a client sends whose name is not UTF-8.
bool parse_bad_text() {
  v1::Invitation message;
  return message.ParseFromString("\x0a\x02\xff\xfe");  // its id
}

TEST(ProtobufLog, OfThousandsOfBadMessagesAFewLinesAreSaidToUsAndNoneToStandardError) {
  std::vector<std::string> lines;
  set_protobuf_log([&](const std::string& line) { lines.push_back(line); });
  ::testing::internal::CaptureStderr();
  for (int i = 0; i < 10000; ++i) ASSERT_FALSE(parse_bad_text());
  EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");
  ASSERT_EQ(lines.size(), static_cast<std::size_t>(kProtobufLinesAMinute));
  EXPECT_NE(lines[0].find("UTF-8"), std::string::npos) << lines[0];
  for (const std::string& line : lines) EXPECT_LT(line.size(), 500u);

  silence_protobuf();
  ::testing::internal::CaptureStderr();
  EXPECT_FALSE(parse_bad_text());
  EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");
  EXPECT_EQ(lines.size(), static_cast<std::size_t>(kProtobufLinesAMinute));
}

}  // namespace
}  // namespace isostrata
