#include "session/people/resume_tokens.h"

#include <algorithm>
#include <utility>

#include "session/wire/random_token.h"

namespace isostrata {

ResumeTokens::ResumeTokens(std::vector<std::string> hashes) : token_(random_token(192)), hashes_(std::move(hashes)) {
  if (hashes_.size() >= kMost) hashes_.resize(kMost - 1);
  hashes_.push_back(secret_hash(token_));
}

bool ResumeTokens::resume(const std::string& token) {
  const std::string hash = secret_hash(token);
  std::size_t found = hashes_.size();
  for (std::size_t i = 0; i < hashes_.size(); ++i)
    if (equal_in_constant_time(hashes_[i], hash)) found = i;
  if (found == hashes_.size()) return false;
  const auto at = hashes_.begin() + static_cast<std::ptrdiff_t>(found);
  std::rotate(hashes_.begin(), at, at + 1);
  token_ = token;
  return true;
}

}  // namespace isostrata
