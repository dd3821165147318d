#include "session/people/resume_tokens.h"

#include <gtest/gtest.h>

#include "session/wire/random_token.h"

namespace isostrata {
namespace {

TEST(ResumeTokensOfASession, HoldNoTokenInClearButTheNewest) {
  ResumeTokens tokens;
  ASSERT_EQ(tokens.hashes().size(), 1u);
  EXPECT_EQ(tokens.hashes()[0], secret_hash(tokens.token()));
  EXPECT_NE(tokens.token(), ResumeTokens().token());
  EXPECT_TRUE(tokens.resume(std::string(tokens.token())));
  EXPECT_FALSE(tokens.resume(""));
  EXPECT_FALSE(tokens.resume(tokens.hashes()[0])) << "the hash does not open what it proves";
}

TEST(ResumeTokensOfASession, OutliveTheServerAndTheOneThatIsUsedComesFirst) {
  const std::string first = random_token(192), second = random_token(192);
  ResumeTokens tokens({secret_hash(first), secret_hash(second)});
  const std::string fresh = tokens.token();
  ASSERT_EQ(tokens.hashes().size(), 3u);
  EXPECT_TRUE(tokens.resume(second));
  EXPECT_EQ(tokens.token(), second);
  EXPECT_EQ(tokens.hashes(), (std::vector{secret_hash(second), secret_hash(first), secret_hash(fresh)}));
  EXPECT_TRUE(tokens.resume(first));
  EXPECT_TRUE(tokens.resume(fresh)) << "for who finds the session by its id";
  EXPECT_FALSE(tokens.resume(random_token(192)));
  EXPECT_EQ(tokens.token(), fresh);
}

TEST(ResumeTokensOfASession, AreFewHoweverOftenTheServerIsRestarted) {
  std::vector<std::string> used;
  std::vector<std::string> hashes;
  for (int life = 0; life < 20; ++life) {
    ResumeTokens tokens(hashes);
    used.push_back(tokens.token());
    EXPECT_TRUE(tokens.resume(used.back()));
    hashes = tokens.hashes();
    ASSERT_LE(hashes.size(), ResumeTokens::kMost);
    EXPECT_EQ(hashes.front(), secret_hash(used.back()));
  }
  ResumeTokens last(hashes);
  EXPECT_TRUE(last.resume(used[19]));
  EXPECT_TRUE(last.resume(used[20 - ResumeTokens::kMost + 1]));
  EXPECT_FALSE(last.resume(used[20 - ResumeTokens::kMost])) << "the one that was used the longest ago made room";
}

}  // namespace
}  // namespace isostrata
