// Sessions on disk, so that a server that was killed or restarted has them again. One small log per session:
//
//   file    ID.journal, mode 0600: "isostrata-journal 1\n", then records
//   record  "ISOR", length (u32, little endian), CRC-32 of the payload (u32), payload: a journal.Entry, complete in itself
//
// A change appends a record, and the newest record that is whole is the session: a write that was torn, a byte that rotted or a
// tail that was lost costs the newest changes and nothing else. A log that has grown is written anew beside it and renamed into
// place. What is appended survives the process at once, and the machine within `sync_period`, when files are fsync'd together.
// What somebody is told to be done is appended before they are told.
//
// The journal never stands in the way: a directory that cannot be used, a full disk, files of another version or with nonsense in
// them are reported, and the server runs on without what they would have kept.
#pragma once

#include <chrono>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "session/journal/journal.pb.h"

namespace isostrata {

struct JournalOptions {
  std::filesystem::path directory;  // made if it is not there
  std::chrono::milliseconds sync_period{1000};
  std::size_t max_file_bytes = 1 << 20;  // beyond it a log is written anew; it exceeds this by at most one record
  std::size_t max_sessions = 10000;      // that are read; the newest
  /// Told of what went wrong and of when it works again, in a sentence; any thread, at most once a second.
  std::function<void(const std::string& what)> warn;
};

/// Any thread may call any function. One thread of its own writes, but for keep_now; nobody else ever waits for an fsync.
class Journal {
 public:
  /// Never throws for what is on the disk. Of several servers with one directory the first has it, the others keep nothing.
  explicit Journal(JournalOptions options);
  /// Writes what waits.
  ~Journal();
  Journal(const Journal&) = delete;
  Journal& operator=(const Journal&) = delete;

  /// Whether changes are being kept; false once the directory could not be used.
  bool usable() const;
  /// Whether the last write failed, because the disk is full, say. It is tried again.
  bool in_trouble() const;
  /// The sessions found when it was opened, the most recently changed first.
  std::vector<journal::Entry> take_found();

  /// Replaces what is kept of the session; where several wait, the newest wins.
  void keep(journal::Entry entry);
  /// The same, and it is in the kernel's hands when this returns, where write() works. On a disk that makes writers wait it is as
  /// keep for a while, which is told.
  void keep_now(journal::Entry entry);
  void forget(const std::string& session);
  /// Waits until everything said before is on the disk; false if it is not by then.
  bool flush(std::chrono::milliseconds timeout);

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace isostrata
