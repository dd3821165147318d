// Long work as scripts see it: what runs and ran in each session, its progress as events, its result, a way to cancel it.
#pragma once

#include <boost/json/object.hpp>
#include <filesystem>
#include <functional>
#include <list>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/temporary_directory.h"
#include "net/http/event_stream.h"
#include "session/sessions/sessions.h"

namespace isostrata {

/// One piece of long work.
struct OperationRecord {
  enum class Status { running, done, failed, cancelled };

  std::string id;    // "r17": by the request it works for; "x5": the engine's number of an extraction; "f2": a film
  std::string kind;  // "open", "export", "film", "extract", "ranges": of a series' arrays, read step by step in the background
  SessionKey session = 0;
  std::string session_id;
  RequestId request = 0;            // 0: an extraction, or a film
  std::uint64_t engine_number = 0;  // of an extraction
  Status status = Status::running;
  std::string stage;
  double fraction = 0;
  std::optional<v1::Error> error;     // of what failed
  boost::json::object result;         // of what is done
  std::function<void()> stop;         // of a film: makes an end of it
  std::filesystem::path file;         // that an export or a film wrote; removed with the record
  std::string media_type, file_name;  // of the file, for whoever downloads it
  std::vector<std::weak_ptr<EventStream>> listeners;
  TimePoint told{};  // its listeners, of a film's progress
};

/// Not thread-safe: lives on the io thread. Extractions and ranges are noted by themselves, other work
/// by begin().
class Operations final : public SessionsObserver {
 public:
  static constexpr std::size_t kMostRecords = 32;  // of a session; the oldest that has ended goes first
  static constexpr std::size_t kMostFiles = 4;     // of a session, exports and films, running or kept

  /// Registers itself as an observer of the sessions, which must outlive it.
  explicit Operations(Sessions& sessions);
  Operations(const Operations&) = delete;
  Operations& operator=(const Operations&) = delete;

  OperationRecord& begin(const Session& session, const std::string& kind, RequestId request);
  OperationRecord& begin_film(const Session& session);
  /// Of a film. Its listeners hear of it ten times a second at most.
  void progress(OperationRecord& record, const std::string& stage, double fraction, TimePoint now);
  /// Told when an operation has begun, and when it has ended. One listener.
  void on_change(std::function<void(const OperationRecord&)> listener) { changed_ = std::move(listener); }
  /// Sets status, error and result and tells the listeners; call it once.
  void finish(OperationRecord& record, std::optional<v1::Error> error, boost::json::object result = {});

  /// Null if the session has none of that id.
  OperationRecord* find(const std::string& session_id, const std::string& id);
  std::vector<const OperationRecord*> list(const std::string& session_id) const;
  std::size_t running() const;
  /// Whether a session may have one more file.
  bool room_for_file(const std::string& session_id) const;

  /// Asks the engine to end it; its status changes when it has ended. A film ends at once.
  void cancel(OperationRecord& record);
  /// Forgets one that has ended, and removes its file.
  void forget(const OperationRecord& record);
  /// Hears "progress" with the record now and after each change, then once "done", "failed" or "cancelled", and ends.
  std::shared_ptr<EventStream> listen(OperationRecord& record);

  /// A name for a new file of this server. Throws unavailable if no folder can be made. The folder is removed at the end.
  std::filesystem::path new_file(const std::string& extension);

  void session_ended(const Session& session) override;
  void engine_event(const Session* session, const EngineEvent& event) override;

 private:
  void tell(OperationRecord& record);
  void make_room(SessionKey session);
  OperationRecord* of_event(SessionKey session, RequestId request, std::uint64_t number);

  OperationRecord& add(const Session& session, const std::string& id, const std::string& kind);

  Sessions& sessions_;
  std::function<void(const OperationRecord&)> changed_ = [](const OperationRecord&) {};
  std::list<OperationRecord> records_;  // in the order they began
  std::optional<TemporaryDirectory> folder_;
  std::uint64_t last_file_ = 0, last_film_ = 0;
};

const char* to_string(OperationRecord::Status status);
boost::json::object to_json(const OperationRecord& record);

}  // namespace isostrata
