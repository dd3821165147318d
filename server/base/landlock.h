// Landlock (Linux 5.13): a process gives its own rights to files away, for good, and for all that it starts. landlock(7).
#pragma once

#include <cstdint>
#include <filesystem>

namespace isostrata {

/// The version of the kernel's interface; 0: there is none, or it is switched off.
int landlock_version();

/// What may still be done below the places that are added; all else that this kernel's Landlock knows is refused. Not thread-safe.
class PathRules {
 public:
  static constexpr std::uint64_t kReadFile = 1ull << 2, kReadFolder = 1ull << 3, kRead = kReadFile | kReadFolder;
  static constexpr std::uint64_t kWriteFile = (1ull << 1) | (1ull << 14);         // and cut it
  static constexpr std::uint64_t kMakeFiles = (1ull << 8) | (1ull << 5);          // and remove them
  static constexpr std::uint64_t kMakeFolders = (1ull << 7) | (1ull << 4) | (1ull << 13);  // remove them, and move what is in them between them
  static constexpr std::uint64_t kWrite = kRead | kWriteFile | kMakeFiles | kMakeFolders;
  static constexpr std::uint64_t kDevice = kRead | kWriteFile | (1ull << 15);  // and talk to it by ioctl
  static constexpr std::uint64_t kExecute = 1ull << 0;

  /// TCP (since Linux 6.7), abstract sockets and, where `signals` is true, signals to processes outside (since 6.12) are refused as well.
  explicit PathRules(bool signals = true);
  ~PathRules();
  PathRules(const PathRules&) = delete;
  PathRules& operator=(const PathRules&) = delete;

  /// Whether the kernel has it.
  bool usable() const { return ruleset_ >= 0; }
  /// `rights` below an open file or folder (O_PATH will do), of which a file takes those that files have. Nothing if `opened` is -1.
  void allow(int opened, std::uint64_t rights) const;
  /// The same by name, a link followed; nothing if there is no such thing.
  void allow(const std::filesystem::path& path, std::uint64_t rights) const;
  /// From now on, for this thread and those that it starts. False if it cannot. After PR_SET_NO_NEW_PRIVS.
  bool enforce() const;

 private:
  int version_ = 0, ruleset_ = -1;
};

}  // namespace isostrata
