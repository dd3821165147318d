#include "net/rest/operations.h"

#include <algorithm>
#include <boost/json/serialize.hpp>

#include "base/utf8.h"
#include "session/wire/wire.h"

namespace isostrata {
namespace {

using Status = OperationRecord::Status;

void remove_file(const OperationRecord& record) {
  std::error_code ignored;
  if (!record.file.empty()) std::filesystem::remove(record.file, ignored);
}

}  // namespace

const char* to_string(Status status) {
  switch (status) {
    case Status::running:
      return "running";
    case Status::done:
      return "done";
    case Status::failed:
      return "failed";
    default:
      return "cancelled";
  }
}

boost::json::object to_json(const OperationRecord& record) {
  boost::json::object document{{"id", record.id},
                               {"kind", record.kind},
                               {"status", to_string(record.status)},
                               {"stage", record.stage},
                               {"fraction", record.fraction}};
  if (!record.result.empty()) document["result"] = record.result;
  if (record.error) {
    boost::json::object error{{"code", record.error->code()}, {"detail", record.error->message()}};
    if (!record.error->field().empty()) error["field"] = record.error->field();
    document["error"] = std::move(error);
  }
  return document;
}

Operations::Operations(Sessions& sessions) : sessions_(sessions) { sessions.observe(*this); }

OperationRecord& Operations::add(const Session& session, const std::string& id, const std::string& kind) {
  make_room(session.key());
  OperationRecord& record = records_.emplace_back();
  record.id = id;
  record.kind = kind;
  record.session = session.key();
  record.session_id = session.id();
  record.stage = "waiting";
  return record;
}

OperationRecord& Operations::begin(const Session& session, const std::string& kind, RequestId request) {
  OperationRecord& record = add(session, "r" + std::to_string(request), kind);
  record.request = request;
  changed_(record);
  return record;
}

OperationRecord& Operations::begin_film(const Session& session) {
  OperationRecord& record = add(session, "f" + std::to_string(++last_film_), "film");
  changed_(record);
  return record;
}

void Operations::progress(OperationRecord& record, const std::string& stage, double fraction, TimePoint now) {
  record.stage = stage;
  record.fraction = fraction;
  if (now - record.told < std::chrono::milliseconds(100)) return;
  record.told = now;
  tell(record);
}

void Operations::make_room(SessionKey session) {
  const auto of_session = [&](const OperationRecord& r) { return r.session == session; };
  if (static_cast<std::size_t>(std::count_if(records_.begin(), records_.end(), of_session)) < kMostRecords) return;
  // Extractions go first: nobody comes back for them, and exports and films are files that somebody may still fetch.
  for (const bool extractions : {true, false})
    for (auto it = records_.begin(); it != records_.end(); ++it)
      if (of_session(*it) && it->status != Status::running && (it->kind == "extract") == extractions) {
        remove_file(*it);
        records_.erase(it);
        return;
      }
}

void Operations::tell(OperationRecord& record) {
  const bool running = record.status == Status::running;
  const std::string data = valid_json(boost::json::serialize(to_json(record)));
  std::erase_if(record.listeners, [](const auto& listener) { return listener.expired(); });
  for (const auto& listener : record.listeners)
    if (const auto living = listener.lock()) {
      living->push(running ? "progress" : to_string(record.status), data, running);
      if (!running) living->end();
    }
}

void Operations::finish(OperationRecord& record, std::optional<v1::Error> error, boost::json::object result) {
  record.stop = nullptr;
  record.status = !error ? Status::done : error->code() == "cancelled" ? Status::cancelled : Status::failed;
  if (!error) record.fraction = 1;
  record.error = std::move(error);
  record.result = std::move(result);
  record.stage.clear();
  if (record.status != Status::done) remove_file(record);
  tell(record);
  changed_(record);
}

OperationRecord* Operations::find(const std::string& session_id, const std::string& id) {
  for (OperationRecord& record : records_)
    if (record.id == id && record.session_id == session_id) return &record;
  return nullptr;
}

std::vector<const OperationRecord*> Operations::list(const std::string& session_id) const {
  std::vector<const OperationRecord*> found;
  for (const OperationRecord& record : records_)
    if (record.session_id == session_id) found.push_back(&record);
  return found;
}

std::size_t Operations::running() const {
  return static_cast<std::size_t>(
      std::count_if(records_.begin(), records_.end(), [](const auto& r) { return r.status == Status::running; }));
}

bool Operations::room_for_file(const std::string& session_id) const {
  return std::count_if(records_.begin(), records_.end(), [&](const OperationRecord& r) {
           return r.session_id == session_id && (r.kind == "export" || r.kind == "film") && (r.status == Status::running || r.status == Status::done);
         }) < static_cast<std::ptrdiff_t>(kMostFiles);
}

void Operations::cancel(OperationRecord& record) {
  if (record.status != Status::running) return;
  if (!record.stop) return sessions_.post(CancelRequest{record.session, record.engine_number, record.request});
  record.stop();
  finish(record, wire_error(RequestFailed{0, 0, 0, ErrorCode::cancelled, "a person has ended it"}));
}

void Operations::forget(const OperationRecord& record) {
  remove_file(record);
  records_.remove_if([&](const OperationRecord& r) { return &r == &record; });
}

std::shared_ptr<EventStream> Operations::listen(OperationRecord& record) {
  auto stream = std::make_shared<EventStream>();
  record.listeners.push_back(stream);
  const bool running = record.status == Status::running;
  stream->push(running ? "progress" : to_string(record.status), valid_json(boost::json::serialize(to_json(record))), running);
  if (!running) stream->end();
  return stream;
}

std::filesystem::path Operations::new_file(const std::string& extension) {
  if (!folder_) folder_.emplace(temporary_base(), "isostrata-exports-");
  return folder_->path() / ("file-" + std::to_string(++last_file_) + "." + extension);
}

void Operations::session_ended(const Session& session) {
  for (auto it = records_.begin(); it != records_.end();) {
    if (it->session != session.key()) {
      ++it;
      continue;
    }
    // Whoever still works for it is told in a moment that the session has ended; a file that is complete by then goes with the
    // folder.
    if (it->status == Status::running && it->stop) it->stop();
    if (it->status == Status::running)
      finish(*it, wire_error(RequestFailed{0, 0, 0, ErrorCode::cancelled, "the session has ended"}));
    remove_file(*it);
    it = records_.erase(it);
  }
}

OperationRecord* Operations::of_event(SessionKey session, RequestId request, std::uint64_t number) {
  for (OperationRecord& record : records_)
    if (record.session == session && (request != 0 ? record.request == request : record.engine_number == number)) return &record;
  return nullptr;
}

void Operations::engine_event(const Session* session, const EngineEvent& event) {
  if (!session) return;
  if (const auto* progress = std::get_if<OperationProgress>(&event)) {
    OperationRecord* record = of_event(progress->session, progress->works_for, progress->operation);
    if (!record && progress->works_for == 0) {
      record = &add(*session, "x" + std::to_string(progress->operation), "extract");
      record->engine_number = progress->operation;
      changed_(*record);
    }
    if (!record && progress->works_for != 0 && progress->works_for == session->reading_ranges())
      record = &begin(*session, "ranges", progress->works_for);
    if (!record || record->status != Status::running) return;
    record->stage = progress->stage;
    record->fraction = progress->fraction;
    tell(*record);
  } else if (const auto* done = std::get_if<OperationDone>(&event)) {
    OperationRecord* record = of_event(done->session, done->works_for, done->operation);
    if (!record || record->status != Status::running) return;
    if (done->works_for != 0 && record->kind != "ranges") return;  // whoever asked for it says how it ended
    if (done->cancelled)
      finish(*record, wire_error(RequestFailed{0, 0, 0, ErrorCode::cancelled, "a newer state or a person has ended it"}));
    else
      finish(*record, std::nullopt);
  }
}

}  // namespace isostrata
