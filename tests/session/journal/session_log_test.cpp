#include "session/journal/session_log.h"

#include <gtest/gtest.h>

#include "support/temporary_folder.h"

namespace isostrata {
namespace {

namespace fs = std::filesystem;

constexpr const char* kSession = "00000000000000aa";

class LogOfASession : public ::testing::Test {
 protected:
  static std::string record(std::uint64_t revision) {
    journal::Entry entry;
    entry.set_session(kSession);
    entry.mutable_state()->set_revision(revision);
    return log_record(entry);
  }
  /// The revision that somebody who reads it finds; 0: none.
  std::uint64_t found() {
    journal::Entry entry;
    return newest_entry(log_.read(1 << 20), kSession, entry) ? entry.state().revision() : 0;
  }
  void put(std::uint64_t revision) {
    std::error_code error;
    ASSERT_TRUE(log_.write_beside(".x", record(revision), false));
    log_.rename_beside(".x", error);
    ASSERT_FALSE(error);
  }

  testing::TemporaryFolder folder_;
  SessionLog log_{folder_.path(), kSession};
};

TEST_F(LogOfASession, BeginsBesideAndIsThereAsAWhole) {
  EXPECT_EQ(log_.append(record(1), 1 << 20), SessionLog::Appended::no_room) << "there is none";
  EXPECT_EQ(log_.size(), 0u);
  ASSERT_TRUE(log_.write_beside(".x", record(1), true));
  EXPECT_FALSE(fs::exists(log_.path()));
  std::error_code error;
  log_.rename_beside(".x", error);
  EXPECT_FALSE(error);
  EXPECT_EQ(found(), 1u);
  EXPECT_EQ(log_.append(record(2), 1 << 20), SessionLog::Appended::done);
  EXPECT_EQ(found(), 2u);
  EXPECT_EQ(fs::status(log_.path()).permissions(), fs::perms::owner_read | fs::perms::owner_write);
}

TEST_F(LogOfASession, HasRoomUpToItsLimitAndIsAsItWasBeyondIt) {
  put(1);
  const std::size_t size = log_.size(), most = size + record(2).size();
  EXPECT_EQ(log_.append(record(2), most - 1), SessionLog::Appended::no_room);
  EXPECT_EQ(log_.size(), size);
  EXPECT_EQ(log_.append(record(2), most), SessionLog::Appended::done);
  EXPECT_EQ(log_.size(), most);
}

TEST_F(LogOfASession, IsNeverALinkToSomethingElse) {
  put(1);
  const fs::path elsewhere = folder_ / "elsewhere";
  fs::rename(log_.path(), elsewhere);
  fs::create_symlink(elsewhere, log_.path());
  EXPECT_EQ(log_.append(record(2), 1 << 20), SessionLog::Appended::no_room);
  EXPECT_EQ(log_.read(1 << 20), "");
}

TEST_F(LogOfASession, WhatIsLeftBesideCanBeRemoved) {
  ASSERT_TRUE(log_.write_beside(".x", record(1), false));
  log_.remove_beside(".x");
  log_.remove_beside(".x");
  std::error_code error;
  log_.rename_beside(".x", error);
  EXPECT_TRUE(error);
}

TEST(SessionIds, AreHexadecimalAndReachNoOtherPath) {
  EXPECT_TRUE(is_session_id(kSession));
  for (const char* no : {"", "00", "../../../../etc/passwd", "00000000000000AA", "00000000/0000000"}) EXPECT_FALSE(is_session_id(no)) << no;
  EXPECT_FALSE(is_session_id(std::string(65, 'a')));
}

}  // namespace
}  // namespace isostrata
