// The secrets that bring somebody back to a session. Only the newest is known in clear; of the others it is known what proves them.
#pragma once

#include <string>
#include <vector>

namespace isostrata {

/// Of one session. Not thread-safe: lives on the io thread.
class ResumeTokens {
 public:
  static constexpr std::size_t kMost = 8;  // that are good

  /// One that is new.
  ResumeTokens() : ResumeTokens(std::vector<std::string>()) {}
  /// Those whose hashes a journal has kept, and one that is new for who finds the session by its id.
  explicit ResumeTokens(std::vector<std::string> hashes);

  /// The new one, or the one that was used last.
  const std::string& token() const { return token_; }
  /// Takes as long for every token of one length. True: it is good, and token() from now on.
  bool resume(const std::string& token);
  /// secret_hash of those that are good, the one that was used last first.
  const std::vector<std::string>& hashes() const { return hashes_; }

 private:
  std::string token_;
  std::vector<std::string> hashes_;
};

}  // namespace isostrata
