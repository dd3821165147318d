// Films of what a session shows.
#include "net/http/json_body.h"
#include "net/http/problem.h"
#include "net/rest/rest_routes.h"
#include "session/wire/wire.h"

namespace isostrata {

namespace {

void begin_film(RestContext& context, const Call& call) {
  v1::NewFilm wanted;
  const Session& session = *call.session;
  if (auto error = parse_message(call.request.body, wanted)) return call.reply(problem(*error));
  if (!session.dataset()) return call.reply(problem(wire_error("not_found", "no dataset is open in this session")));
  // Each has a turn of its own beside other sessions.
  for (const OperationRecord* of : context.operations.list(session.id()))
    if (of->kind == "film" && of->status == OperationRecord::Status::running)
      return call.reply(problem(wire_error("unavailable", "a film of this session is being made (" + of->id + "); wait for it, or DELETE it")));
  FilmPlan plan;
  if (auto error = plan_film(wanted, session.drawn(), *session.dataset(), plan)) return call.reply(problem(*error));
  const std::optional<std::filesystem::path> file = new_file(context, call, "webm");
  if (!file) return;
  OperationRecord& record = context.operations.begin_film(session);
  record.file = *file;
  record.media_type = "video/webm";
  const std::uint64_t revision = session.scene().revision;
  record.file_name = "film-" + std::to_string(revision) + ".webm";
  const auto find = [&context, session = session.id(), id = record.id] { return context.operations.find(session, id); };
  const std::string words = std::to_string(plan.pictures) + " pictures";
  Film::Ports ports;
  ports.progress = [&context, find, words](double fraction) {
    if (OperationRecord* of = find()) context.operations.progress(*of, words, fraction, rest_now());
  };
  ports.end = [&context, find, revision, pictures = plan.pictures, seconds = plan.seconds](std::optional<v1::Error> error, std::uint64_t bytes) {
    OperationRecord* of = find();
    if (!of) return;
    if (error) return context.operations.finish(*of, std::move(error));
    context.operations.finish(*of, std::nullopt,
                              {{"href", "sessions/" + of->session_id + "/films/" + of->id},
                               {"mediaType", of->media_type},
                               {"bytes", bytes},
                               {"revision", revision},
                               {"pictures", pictures},
                               {"seconds", seconds}});
  };
  record.stop = [film = context.sessions.begin_film(std::move(plan), *file, std::move(ports))] { film->cancel(); };
  answer_begun(call, record);
}

}  // namespace

void add_film_routes(std::vector<Route>& routes, RestContext& context) {
  routes.push_back({.method = "POST",
                    .path = "/sessions/{session}/films",
                    .id = "createFilm",
                    .tag = "films",
                    .summary = "Makes a film of what the session shows",
                    .description = "Of the state as it is now, which goes on freely meanwhile: a turn of the camera, the steps of a series, or both. Each picture is "
                                   "exact. One at a time; at most four files, exports and films, are kept for a session.",
                    .body = RequestBody{"NewFilm", "What moves, for how long, and how large it is"},
                    .answers = {{202, "It is being made; Location names the operation", "Operation"}},
                    .handler = [&context](Call call) { begin_film(context, call); }});
  routes.push_back({.method = "GET",
                    .path = "/sessions/{session}/films/{film}",
                    .id = "getFilm",
                    .tag = "films",
                    .summary = "A film that is done",
                    .answers = {{200, "The file: VP9 in WebM", "", "video/webm"}},
                    .handler = [&context](Call call) { answer_file(context, call, "film"); }});
  routes.push_back({.method = "DELETE",
                    .path = "/sessions/{session}/films/{film}",
                    .id = "deleteFilm",
                    .tag = "films",
                    .summary = "Removes a film, or ends its making",
                    .answers = {{202, "It has ended", "Operation"}, {204, "The file is removed", ""}},
                    .handler = [&context](Call call) {
                      if (OperationRecord* record = file_operation(context, call, "film")) end_operation(context, call, *record);
                    }});
}

}  // namespace isostrata
