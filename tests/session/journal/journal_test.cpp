#include "session/journal/journal.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include <csignal>
#include <cstdint>
#include <iterator>
#include <mutex>
#include <random>

#include "session/journal/session_log.h"
#include "support/temporary_folder.h"

namespace isostrata {
namespace {

namespace fs = std::filesystem;
using testing::TemporaryFolder;

constexpr const char* kOne = "00000000000000aa";
constexpr const char* kTwo = "00000000000000bb";

journal::Entry entry_of(const std::string& session, std::uint64_t revision, std::size_t padding = 0) {
  journal::Entry entry;
  entry.set_session(session);
  entry.add_resume_hashes(std::string(32, 'h'));
  entry.mutable_state()->set_revision(revision);
  entry.mutable_state()->set_dataset("torus-12" + std::string(padding, 'x'));
  return entry;
}

class JournalFiles : public ::testing::Test {
 protected:
  JournalOptions options() {
    return {.directory = folder_ / "state" / "sessions", .warn = [this](const std::string& what) {
              const std::lock_guard guard(mutex_);
              warnings_.push_back(what);
            }};
  }
  void keep(const std::vector<journal::Entry>& entries) {
    Journal journal(options());
    for (const auto& entry : entries) {
      journal.keep(entry);
      EXPECT_TRUE(journal.flush(std::chrono::seconds(20)));  // else the newest alone is written
    }
  }
  std::vector<journal::Entry> found() { return Journal(options()).take_found(); }
  fs::path file(const std::string& session) { return options().directory / (session + ".journal"); }
  std::string bytes(const std::string& session) {
    std::ifstream in(file(session), std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  void write(const std::string& session, const std::string& bytes) {
    std::ofstream(file(session), std::ios::binary | std::ios::trunc) << bytes;
  }
  std::size_t warnings() {
    const std::lock_guard guard(mutex_);
    return warnings_.size();
  }

  TemporaryFolder folder_;
  std::mutex mutex_;
  std::vector<std::string> warnings_;
};

TEST_F(JournalFiles, TheNewestOfEverySessionComesBack) {
  keep({entry_of(kOne, 1), entry_of(kTwo, 7), entry_of(kOne, 2)});
  const auto all = found();
  ASSERT_EQ(all.size(), 2u);
  for (const auto& entry : all) EXPECT_EQ(entry.state().revision(), entry.session() == kOne ? 2u : 7u);
  EXPECT_EQ(warnings(), 0u);
}

TEST_F(JournalFiles, ForgottenSessionsDoNotComeBack) {
  keep({entry_of(kOne, 1), entry_of(kTwo, 7)});
  {
    Journal journal(options());
    journal.forget(kOne);
  }
  const auto all = found();
  ASSERT_EQ(all.size(), 1u);
  EXPECT_EQ(all[0].session(), kTwo);
  EXPECT_FALSE(fs::exists(file(kOne)));
}

TEST_F(JournalFiles, OnlyTheirOwnerMayReadThem) {
  keep({entry_of(kOne, 1)});
  struct stat facts {};
  ASSERT_EQ(stat(file(kOne).c_str(), &facts), 0);
  EXPECT_EQ(facts.st_mode & 0777, 0600u);
  ASSERT_EQ(stat(options().directory.c_str(), &facts), 0);
  EXPECT_EQ(facts.st_mode & 0777, 0700u);
}

// What a kill or a power cut leaves: any prefix of what was written.
TEST_F(JournalFiles, ALogThatWasTornAnywhereGivesTheNewestWholeRecord) {
  keep({entry_of(kOne, 1), entry_of(kOne, 2), entry_of(kOne, 3)});
  const std::string whole = bytes(kOne);
  std::uint64_t newest = 0;
  for (std::size_t size = 0; size <= whole.size(); ++size) {
    journal::Entry entry;
    const bool any = newest_entry(whole.substr(0, size), kOne, entry);
    const std::uint64_t revision = any ? entry.state().revision() : 0;
    EXPECT_GE(revision, newest) << "more bytes, an older session, at " << size;
    newest = revision;
  }
  EXPECT_EQ(newest, 3u);
}

TEST_F(JournalFiles, AByteThatRottedCostsItsRecordAlone) {
  keep({entry_of(kOne, 1), entry_of(kOne, 2), entry_of(kOne, 3)});
  const std::string whole = bytes(kOne);
  const std::size_t header = 20;
  const std::size_t record = (whole.size() - header) / 3;
  for (std::size_t at = header; at < whole.size(); ++at) {
    std::string damaged = whole;
    damaged[at] = static_cast<char>(damaged[at] ^ 0x55);
    journal::Entry entry;
    ASSERT_TRUE(newest_entry(damaged, kOne, entry)) << at;
    EXPECT_EQ(entry.state().revision(), at < header + 2 * record ? 3u : 2u) << at;
  }
}

TEST_F(JournalFiles, NoBytesAtAllMakeItFail) {
  const unsigned seed = 20260;
  std::mt19937 random(seed);
  keep({entry_of(kOne, 1), entry_of(kOne, 2)});
  const std::string whole = bytes(kOne);
  for (int round = 0; round < 2000; ++round) {
    std::string damaged = whole;
    for (int i = 0; i < 8; ++i) damaged[random() % damaged.size()] = static_cast<char>(random());
    if (round % 3 == 0) damaged.resize(random() % damaged.size());
    journal::Entry entry;
    if (newest_entry(damaged, kOne, entry)) {
      EXPECT_EQ(entry.session(), kOne) << "seed " << seed << " round " << round;
    }
  }
  std::string lengths = "isostrata-journal 1\n";
  while (lengths.size() < 1 << 20) lengths += std::string("ISOR\xff\xff\x0f\x00\x00\x00\x00\x00", 12);
  journal::Entry entry;
  EXPECT_FALSE(newest_entry(lengths, kOne, entry));
}

TEST_F(JournalFiles, WhatCannotBeReadIsPutAsideAndTheRestComesBack) {
  keep({entry_of(kOne, 1), entry_of(kTwo, 7)});
  write(kOne, "isostrata-journal 2\nof a newer version");
  write("00000000000000cc", "");
  std::ofstream(options().directory / "not-a-session.journal") << "x";
  fs::create_symlink("/etc/passwd", file("00000000000000dd"));
  fs::create_directory(file("00000000000000ee"));
  std::ofstream(options().directory / "00000000000000ff.journal.new") << "half of a rewrite";
  const auto all = found();
  ASSERT_EQ(all.size(), 1u);
  EXPECT_EQ(all[0].session(), kTwo);
  EXPECT_GE(warnings(), 2u);
  EXPECT_TRUE(fs::exists(file(kOne).string() + ".unreadable"));
  EXPECT_FALSE(fs::exists(options().directory / "00000000000000ff.journal.new"));
}

TEST_F(JournalFiles, ALogThatHasGrownIsWrittenAnew) {
  auto small = options();
  small.max_file_bytes = 4000;
  {
    Journal journal(small);
    for (std::uint64_t revision = 1; revision <= 50; ++revision) {
      journal.keep(entry_of(kOne, revision, 500));
      ASSERT_TRUE(journal.flush(std::chrono::seconds(20)));
      EXPECT_LE(fs::file_size(file(kOne)), 4000u + 700u);
    }
  }
  const auto all = found();
  ASSERT_EQ(all.size(), 1u);
  EXPECT_EQ(all[0].state().revision(), 50u);
}

TEST_F(JournalFiles, AFullDiskIsSaidOnceAndWhatWaitsIsWrittenWhenThereIsRoom) {
  std::signal(SIGXFSZ, SIG_IGN);
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  auto quick = options();
  quick.sync_period = std::chrono::milliseconds(20);
  {
    Journal journal(quick);
    journal.keep(entry_of(kOne, 1));
    ASSERT_TRUE(journal.flush(std::chrono::seconds(20)));
    rlimit full = before;
    full.rlim_cur = fs::file_size(file(kOne)) + 10;
    setrlimit(RLIMIT_FSIZE, &full);
    for (std::uint64_t revision = 2; revision <= 9; ++revision) {
      journal.keep(entry_of(kOne, revision));
      EXPECT_FALSE(journal.flush(std::chrono::seconds(20)));
    }
    EXPECT_EQ(warnings(), 1u);
    setrlimit(RLIMIT_FSIZE, &before);
    EXPECT_TRUE(journal.flush(std::chrono::seconds(20)));
  }
  setrlimit(RLIMIT_FSIZE, &before);
  const auto all = found();
  ASSERT_EQ(all.size(), 1u);
  EXPECT_EQ(all[0].state().revision(), 9u);
}

TEST_F(JournalFiles, ASecondServerWithTheSameDirectoryKeepsNothing) {
  Journal first(options());
  Journal second(options());
  EXPECT_TRUE(first.usable());
  EXPECT_FALSE(second.usable());
  EXPECT_EQ(warnings(), 1u);
  second.keep(entry_of(kTwo, 1));
  EXPECT_FALSE(second.flush(std::chrono::seconds(20)));
  EXPECT_FALSE(fs::exists(file(kTwo)));
}

TEST_F(JournalFiles, ADirectoryThatCannotBeMadeIsAWarning) {
  std::ofstream(folder_ / "state") << "a file where a directory should be";
  Journal journal(options());
  EXPECT_FALSE(journal.usable());
  EXPECT_EQ(warnings(), 1u);
}

TEST_F(JournalFiles, NamesThatAreNoSessionsNeverReachAPath) {
  Journal journal(options());
  journal.keep(entry_of("../../escaped", 1));
  journal.forget("../lock");
  EXPECT_TRUE(journal.flush(std::chrono::seconds(20)));
  EXPECT_FALSE(fs::exists(folder_ / "escaped.journal"));
  EXPECT_TRUE(fs::exists(options().directory / "lock"));
}

}  // namespace
}  // namespace isostrata
