// Who is in a session, and the links that let others in.
#include "net/http/json_body.h"
#include "net/http/problem.h"
#include "net/rest/rest_routes.h"
#include "session/wire/wire.h"

namespace isostrata {
namespace {

v1::Invitations listed(const Participants& people) {
  v1::Invitations all;
  for (const Invitation& invitation : people.invitations().all()) *all.add_invitations() = people.to_wire(invitation);
  return all;
}

void invite(const Call& call) {
  v1::CreateInvitation wanted;
  if (auto error = parse_message(call.request.body, wanted)) return call.reply(problem(*error));
  Invitations::Made made = call.session->people().invite(wanted);
  if (made.error) return call.reply(problem(*made.error));
  v1::Invitation answer = call.session->people().to_wire(*made.invitation);
  answer.set_token(std::move(made.token));
  HttpResponse response = message_response(201, answer);
  response.headers.emplace_back("Location", "invitations/" + answer.id());
  call.reply(std::move(response));
}

void set_viewer_size(const Call& call) {
  v1::SetViewerSize wanted;
  if (auto error = parse_message(call.request.body, wanted)) return call.reply(problem(*error));
  if (auto error = call.session->people().set_viewer_size(wanted, rest_now())) return call.reply(problem(*error));
  call.session->pump(rest_now());
  call.reply({204, "", "", {}});
}

void revoke(const Call& call) {
  if (!call.session->people().revoke(call.path.at("invitation")))
    return call.reply(problem(
        wire_error("not_found", "this session has no invitation of this id; it may be over or revoked already", "invitation")));
  call.reply({204, "", "", {}});
}

}  // namespace

void add_people_routes(std::vector<Route>& routes, RestContext&) {
  routes.push_back({.method = "GET",
                    .path = "/sessions/{session}/participants",
                    .id = "listParticipants",
                    .tag = "people",
                    .summary = "Who is connected to the session, and in which role",
                    .answers = {{200, "Everyone", "Participants"}},
                    .handler = [](Call call) { call.reply(message_response(200, call.session->people().to_wire())); }});
  routes.push_back({.method = "PUT",
                    .path = "/sessions/{session}/viewer-size",
                    .id = "putViewerSize",
                    .tag = "people",
                    .summary = "How large pictures of those who may only look may be",
                    .description = "As many pixels in any shape, but never more than the server allows. Participants tells it.",
                    .body = RequestBody{"SetViewerSize", "0 and 0: as large as the server allows"},
                    .answers = {{204, "It holds from the next picture on", ""}},
                    .handler = [](Call call) { set_viewer_size(call); }});
  routes.push_back({.method = "GET",
                    .path = "/sessions/{session}/invitations",
                    .id = "listInvitations",
                    .tag = "people",
                    .summary = "The invitations that are good",
                    .description = "Without their tokens, which only their maker was ever told.",
                    .answers = {{200, "The oldest first", "Invitations"}},
                    .handler = [](Call call) { call.reply(message_response(200, listed(call.session->people()))); }});
  routes.push_back(
      {.method = "POST",
       .path = "/sessions/{session}/invitations",
       .id = "createInvitation",
       .tag = "people",
       .summary = "Invites somebody into this session alone",
       .description = "The link is the page's own address with `?token=` and the token of the answer, which is told only here.",
       .body = RequestBody{"CreateInvitation", "In which role, and for how long"},
       .answers = {{201, "The invitation with its token", "Invitation"}},
       .handler = [](Call call) { invite(call); }});
  routes.push_back({.method = "DELETE",
                    .path = "/sessions/{session}/invitations/{invitation}",
                    .id = "revokeInvitation",
                    .tag = "people",
                    .summary = "Takes an invitation back",
                    .description = "Whoever came by it is cut off.",
                    .answers = {{204, "Its token opens nothing any more", ""}},
                    .handler = [](Call call) { revoke(call); }});
}

}  // namespace isostrata
