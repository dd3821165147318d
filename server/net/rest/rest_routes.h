// The routes of the REST API, group by group, and what they share. Each group is a file of its own: rest_*.cpp.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "net/http/route.h"
#include "net/rest/operations.h"
#include "net/rest/session_events.h"
#include "session/sessions/sessions.h"

namespace isostrata {

/// What handlers work on. Lives on the io thread, outlives every call.
struct RestContext {
  Sessions& sessions;
  Operations& operations;
  SessionEvents& events;
};

void add_server_routes(std::vector<Route>& routes, RestContext& context);   // version, health, colour maps
void add_dataset_routes(std::vector<Route>& routes, RestContext& context);  // what can be opened
void add_thumbnail_routes(std::vector<Route>& routes, RestContext& context);  // small pictures of what can be opened
void add_session_routes(std::vector<Route>& routes, RestContext& context);  // sessions, and the dataset of one
void add_state_routes(std::vector<Route>& routes, RestContext& context);    // the state as one document; commands
void add_scene_routes(std::vector<Route>& routes, RestContext& context);    // camera, clip planes, modes, ...: parts of the state
void add_interval_routes(std::vector<Route>& routes, RestContext& context);   // intervals one by one
void add_picture_routes(std::vector<Route>& routes, RestContext& context);    // images, histogram, statistics
void add_probe_routes(std::vector<Route>& routes, RestContext& context);      // what lies at a place of the picture
void add_operation_routes(std::vector<Route>& routes, RestContext& context);  // long work; mesh files
void add_film_routes(std::vector<Route>& routes, RestContext& context);       // films

void add_people_routes(std::vector<Route>& routes, RestContext& context);     // who is in a session, and invitations

TimePoint rest_now();

/// Where the caller goes before the answer, the request to the engine is given up.
void give_up_with(const Call& call, RestContext& context, RequestId request);

/// The state with its ETag.
HttpResponse state_response(int status, const Session& session);
/// Does a scene command and answers the state, or the problem.
void command_and_answer(RestContext& context, Call call, const v1::ClientMessage& message, int status = 200);
/// As a listener of Session: answers the state, or the problem.
Session::Reply answer_state(RestContext& context, const Call& call, int status = 200);
/// {"id", "resumeToken", "revision", "dataset", "viewers"}
boost::json::object session_object(const Session& session);

/// Reads a whole number from the query; leaves the value if there is none.
std::optional<v1::Error> number_parameter(const Call& call, const char* name, std::uint32_t& value);
/// An ETag of a revision, as it is sent.
std::string revision_tag(std::uint64_t revision);

/// Answers the array's histogram, or statistics, at a step of a dataset. session: whose work it is; 0: nobody's.
void answer_histogram(RestContext& context, const Call& call, SessionKey session, const DatasetFacts& facts, int step,
                      const std::string& otherwise);
void answer_statistics(RestContext& context, const Call& call, SessionKey session, const DatasetFacts& facts, int step,
                       const std::string& otherwise);
using AnswerNumbers = decltype(&answer_histogram);

/// The session's operation that the path names by its kind, "export" or "film". Null after having replied that there is none.
OperationRecord* file_operation(RestContext& context, const Call& call, const char* kind);
/// Answers its file, or that there is none.
void answer_file(RestContext& context, const Call& call, const char* kind);
/// Running: cancels it; ended: forgets it, and its file.
void end_operation(RestContext& context, const Call& call, OperationRecord& record);
/// A name for one more file of the session. Nothing after having replied why not.
std::optional<std::filesystem::path> new_file(RestContext& context, const Call& call, const std::string& extension);
/// 202, with the operation's place.
void answer_begun(const Call& call, const OperationRecord& record);

inline const QueryParameter kArrayParameter{"array", "An array's name; absent: the first, or the one that is shown"};
inline const QueryParameter kStepParameter{"step", "A time step, from 0", true, 0, INT32_MAX, "0"};

}  // namespace isostrata
