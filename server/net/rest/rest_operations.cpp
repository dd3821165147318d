// Long work: its list, its progress as events, its end; mesh files.
#include <boost/json/array.hpp>

#include "net/http/json_body.h"
#include "net/http/problem.h"
#include "net/rest/rest_routes.h"
#include "session/wire/wire.h"

namespace isostrata {

namespace json = boost::json;

namespace {

using Status = OperationRecord::Status;

/// Null after having replied that there is none.
OperationRecord* operation_of(RestContext& context, const Call& call, const char* name) {
  const std::string& id = call.path.at(name);
  OperationRecord* record = context.operations.find(call.session->id(), id);
  if (!record)
    call.reply(problem(wire_error(
        "not_found", "operation '" + id.substr(0, 32) + "' is not in this session; those that ended long ago are forgotten",
        name)));
  return record;
}

}  // namespace

OperationRecord* file_operation(RestContext& context, const Call& call, const char* kind) {
  OperationRecord* record = operation_of(context, call, kind);
  if (record && record->kind != kind) {
    call.reply(problem(wire_error("not_found", "operation '" + record->id + "' is of another kind: " + record->kind, kind)));
    return nullptr;
  }
  return record;
}

void end_operation(RestContext& context, const Call& call, OperationRecord& record) {
  if (record.status != Status::running) {
    context.operations.forget(record);
    return call.reply({204, "", "", {}});
  }
  context.operations.cancel(record);
  call.reply(json_response(202, to_json(record)));
}

std::optional<std::filesystem::path> new_file(RestContext& context, const Call& call, const std::string& extension) {
  try {
    if (context.operations.room_for_file(call.session->id())) return context.operations.new_file(extension);
    call.reply(problem(wire_error("unavailable", "this session has " + std::to_string(Operations::kMostFiles) +
                                                     " exports and films already; DELETE one that is not needed any more")));
  } catch (const Error& error) {
    call.reply(problem(wire_error(to_string(error.code()), error.what())));
  }
  return std::nullopt;
}

void answer_begun(const Call& call, const OperationRecord& record) {
  HttpResponse response = json_response(202, to_json(record));
  response.headers.emplace_back("Location", "sessions/" + record.session_id + "/operations/" + record.id);
  call.reply(std::move(response));
}

void answer_file(RestContext& context, const Call& call, const char* kind) {
  OperationRecord* record = file_operation(context, call, kind);
  if (!record) return;
  if (record->status != Status::done)
    return call.reply(problem(409, record->status == Status::running ? "unavailable" : "not_found",
                              "this " + record->kind + " is " + to_string(record->status) + ": there is no file"));
  HttpResponse response{200, record->media_type, "", {{"Cache-Control", "no-store"}}};
  response.headers.emplace_back("Content-Disposition", "attachment; filename=\"" + record->file_name + "\"");
  response.file = record->file;
  call.reply(std::move(response));
}

namespace {

std::optional<v1::Error> check_export(const v1::NewExport& wanted, const Session& session, WriteOptions& options) {
  if (wanted.format() != "vtu" && wanted.format() != "vtkhdf" && wanted.format() != "ply" && wanted.format() != "stl")
    return wire_error("invalid_argument", "format '" + wanted.format().substr(0, 32) + "' is not known; expected vtu, vtkhdf, ply or stl",
                      "format");
  if (wanted.has_compression()) {
    if (wanted.compression() > 9)
      return wire_error("invalid_argument", "compression is " + std::to_string(wanted.compression()) + "; expected 0..9",
                        "compression");
    options.compression = static_cast<int>(wanted.compression());
  }
  if (wanted.facets_size() > 3)
    return wire_error("invalid_argument", std::to_string(wanted.facets_size()) + " kinds of facets; there are three", "facets");
  for (int i = 0; i < wanted.facets_size(); ++i) {
    const std::string& name = wanted.facets(i);
    FacetChoice choice;
    if (name == "lower")
      choice.label = FacetLabel::lower;
    else if (name == "upper")
      choice.label = FacetLabel::upper;
    else if (name != "domain")
      return wire_error("invalid_argument", "facets '" + name.substr(0, 32) + "': expected lower, upper or domain",
                        "facets[" + std::to_string(i) + "]");
    options.facets.push_back(choice);
  }
  if (!session.dataset()) return wire_error("not_found", "no dataset is open in this session");
  if (session.scene().intervals.empty()) return wire_error("not_found", "the session has no interval: there is no mesh to write");
  return std::nullopt;
}

void begin_export(RestContext& context, const Call& call) {
  v1::NewExport wanted;
  WriteOptions options;
  Session& session = *call.session;
  if (auto error = parse_message(call.request.body, wanted)) return call.reply(problem(*error));
  if (auto error = check_export(wanted, session, options)) return call.reply(problem(*error));
  const std::optional<std::filesystem::path> file = new_file(context, call, wanted.format());
  if (!file) return;
  const auto id = std::make_shared<std::string>();
  const std::uint64_t revision = session.scene().revision;
  const RequestId request =
      context.sessions.ask(ExportRequest{session.key(), 0, session.scene(), file->string(), options},
                           [&context, id, revision, session = session.id()](const EngineEvent& event, TimePoint) {
                             OperationRecord* record = context.operations.find(session, *id);
                             if (!record) return;
                             if (const auto* failed = std::get_if<RequestFailed>(&event)) {
                               // The file's place on the server is nobody else's business.
                               v1::Error error = wire_error(*failed);
                               std::string text = error.message();
                               const std::string path = record->file.string();
                               for (auto at = text.find(path); at != std::string::npos; at = text.find(path))
                                 text.replace(at, path.size(), "the export");
                               error.set_message(text);
                               return context.operations.finish(*record, std::move(error));
                             }
                             const ExportedMesh& mesh = std::get<ExportReady>(event).mesh;
                             context.operations.finish(*record, std::nullopt,
                                                       json::object{{"href", "sessions/" + session + "/exports/" + *id},
                                                                    {"mediaType", record->media_type},
                                                                    {"bytes", mesh.bytes},
                                                                    {"revision", revision},
                                                                    {"tetrahedra", mesh.tetrahedra},
                                                                    {"points", mesh.points},
                                                                    {"facets", mesh.facets}});
                           });
  OperationRecord& record = context.operations.begin(session, "export", request);
  *id = record.id;
  record.file = *file;
  record.media_type = wanted.format() == "vtu"      ? "application/vnd.vtk.vtu+xml"
                      : wanted.format() == "vtkhdf" ? "application/x-hdf5"
                      : wanted.format() == "stl" ? "model/stl"
                                                 : "model/ply";
  record.file_name = "layers-" + std::to_string(revision) + "." + wanted.format();
  answer_begun(call, record);
}

}  // namespace

void add_operation_routes(std::vector<Route>& routes, RestContext& context) {
  const std::string all = "/sessions/{session}/operations", one = all + "/{operation}";
  routes.push_back({.method = "GET",
                    .path = all,
                    .id = "listOperations",
                    .tag = "operations",
                    .summary = "What runs and what ran in the session",
                    .description =
                        "Datasets that are being opened (with Prefer: respond-async), extractions that take longer than a tenth "
                        "of a second, exports, films. At most 32 are kept.",
                    .answers = {{200, "In the order they began", "Operations"}},
                    .handler = [&context](Call call) {
                      json::array list;
                      for (const OperationRecord* record : context.operations.list(call.session->id()))
                        list.push_back(to_json(*record));
                      call.reply(json_response(200, json::object{{"operations", std::move(list)}}));
                    }});
  routes.push_back({.method = "GET",
                    .path = one,
                    .id = "getOperation",
                    .tag = "operations",
                    .summary = "How far an operation is",
                    .answers = {{200, "Its progress or its end", "Operation"}},
                    .handler = [&context](Call call) {
                      if (const OperationRecord* record = operation_of(context, call, "operation"))
                        call.reply(json_response(200, to_json(*record)));
                    }});
  routes.push_back({.method = "GET",
                    .path = one + "/events",
                    .id = "watchOperation",
                    .tag = "operations",
                    .summary = "An operation's progress as server-sent events",
                    .description = "`progress` now and after each change, at most ten a second, then one of `done`, `failed` and "
                                   "`cancelled`, and the end. The data of each is an Operation.",
                    .answers = {{200, "Events until it has ended", "", "text/event-stream"}},
                    .handler = [&context](Call call) {
                      OperationRecord* record = operation_of(context, call, "operation");
                      if (!record) return;
                      HttpResponse response{200, "text/event-stream", "", {{"Cache-Control", "no-store"}}};
                      response.events = context.operations.listen(*record);
                      call.reply(std::move(response));
                    }});
  routes.push_back({.method = "DELETE",
                    .path = one,
                    .id = "deleteOperation",
                    .tag = "operations",
                    .summary = "Cancels an operation, or forgets one that has ended",
                    .answers = {{202, "It is asked to end; it is cancelled when it has", "Operation"},
                                {204, "It had ended and is forgotten, with its file", ""}},
                    .handler = [&context](Call call) {
                      if (OperationRecord* record = operation_of(context, call, "operation"))
                        end_operation(context, call, *record);
                    }});
  routes.push_back(
      {.method = "POST",
       .path = "/sessions/{session}/exports",
       .id = "createExport",
       .tag = "exports",
       .summary = "Writes the session's layers to a mesh file",
       .description = "All intervals of the state as it is now, hidden ones too. At most four files, exports and films, are kept for a session.",
       .body = RequestBody{"NewExport", "Which format"},
       .answers = {{202, "It is being written; Location names the operation", "Operation"}},
       .handler = [&context](Call call) { begin_export(context, call); }});
  routes.push_back({.method = "GET",
                    .path = "/sessions/{session}/exports/{export}",
                    .id = "getExport",
                    .tag = "exports",
                    .summary = "The mesh file of an export that is done",
                    .answers = {{200, "The file", "", "application/vnd.vtk.vtu+xml", {"application/x-hdf5", "model/ply", "model/stl"}}},
                    .handler = [&context](Call call) { answer_file(context, call, "export"); }});
  routes.push_back({.method = "DELETE",
                    .path = "/sessions/{session}/exports/{export}",
                    .id = "deleteExport",
                    .tag = "exports",
                    .summary = "Removes an export's file, or cancels the export",
                    .answers = {{202, "It is asked to end", "Operation"}, {204, "The file is removed", ""}},
                    .handler = [&context](Call call) {
                      if (OperationRecord* record = file_operation(context, call, "export")) end_operation(context, call, *record);
                    }});
}

}  // namespace isostrata
