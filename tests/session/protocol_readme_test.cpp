// The conversation that protocol/README.md shows is one that this server would understand, byte by byte.
#include <gtest/gtest.h>

#include <fstream>
#include <regex>
#include <sstream>

#include "isostrata/v1/isostrata.pb.h"
#include "support/places.h"

namespace isostrata {
namespace {

TEST(ProtocolReadme, TheWholeMessagesOfTheClientAreThoseThatItNames) {
  std::ifstream in(places::source() + "/protocol/README.md");
  const std::regex row("^\\| → \\| `([0-9a-f ]+)` \\| seq ([0-9]+), `([A-Za-z]+)`.*");
  int rows = 0;
  for (std::string line; std::getline(in, line);) {
    std::smatch found;
    if (!std::regex_match(line, found, row)) continue;
    ++rows;
    std::istringstream digits(found[1].str());
    std::string bytes;
    for (unsigned byte = 0; digits >> std::hex >> byte;) bytes += static_cast<char>(byte);
    v1::ClientMessage message;
    ASSERT_TRUE(message.ParseFromString(bytes)) << line;
    EXPECT_EQ(message.SerializeAsString(), bytes) << line;
    EXPECT_EQ(message.seq(), std::stoull(found[2].str())) << line;
    const auto* body = message.GetDescriptor()->FindFieldByNumber(message.body_case());
    ASSERT_NE(body, nullptr) << line;
    EXPECT_EQ(std::string(body->message_type()->name()), found[3].str()) << line;
  }
  EXPECT_EQ(rows, 5);
}

}  // namespace
}  // namespace isostrata
