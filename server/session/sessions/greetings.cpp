#include "session/sessions/greetings.h"

#include <algorithm>
#include <string_view>
#include <utility>
#include <vector>

#include "session/wire/dataset_list.h"
#include "session/wire/limits.h"
#include "session/wire/wire.h"

namespace isostrata {
namespace {

template <class Formats>
bool offers(const Formats& formats, std::string_view wanted) {
  return formats.empty() || std::ranges::find(formats, wanted) != formats.end();
}

std::optional<v1::Error> refuse_names(const v1::Hello& hello) {
  for (const auto& [text, field] : {std::pair{&hello.name(), "hello.name"}, std::pair{&hello.client_id(), "hello.client_id"},
                                    std::pair{&hello.client(), "hello.client"}})
    if (text->size() > kMaxPersonBytes)
      return wire_error("invalid_argument",
                        std::string(field) + " has " + std::to_string(text->size()) + " bytes; expected at most " + std::to_string(kMaxPersonBytes),
                        field);
  return std::nullopt;
}

void set_limits(v1::Limits& limits, const SessionsOptions& options) {
  limits.set_max_intervals(kMaxIntervals);
  limits.set_max_transfer_points(kMaxTransferPoints);
  limits.set_max_width(kMaxSide);
  limits.set_max_height(kMaxSide);
  limits.set_max_message_bytes(kMaxMessageBytes);
  limits.set_max_terms(kMaxTerms);
  limits.set_max_smear_steps(kMaxSmearSteps);
  limits.set_max_clip_planes(kMaxClipPlanes);
  limits.set_max_viewers(static_cast<std::uint32_t>(options.max_viewers));
  limits.set_max_invitations(Invitations::kMaxInvitations);
}

}  // namespace

void refuse(Viewer& viewer, Refusal refusal, std::uint64_t seq) {
  const std::string reason = refusal.error.code();
  viewer.outbox->send(error_message(std::move(refusal.error), seq));
  viewer.outbox->close(refusal.close_code, reason);
}

std::optional<Refusal> refuse_seq(std::uint64_t seq, std::uint64_t last) {
  if (seq > last) return std::nullopt;
  return Refusal{wire_error("malformed", "seq " + std::to_string(seq) + " after " + std::to_string(last) + "; expected it to grow", "seq"),
                 kCloseProtocolError};
}

std::optional<Refusal> refuse_hello(const v1::ClientMessage& message) {
  if (!message.has_hello())
    return Refusal{wire_error("malformed", "the first message is not Hello; say Hello first"), kCloseProtocolError};
  const v1::Hello& hello = message.hello();
  if (hello.protocol_major() != kProtocolMajor)
    return Refusal{wire_error("unsupported_version",
                              "protocol version " + std::to_string(hello.protocol_major()) + " is not spoken here; expected " +
                                  std::to_string(kProtocolMajor),
                              "hello.protocol_major")};
  const bool still = offers(hello.still_formats(), "png");
  if (!still || !offers(hello.moving_formats(), "jpeg"))
    return Refusal{wire_error("unsupported", "this server sends png at rest and jpeg in motion; the client offers neither or only one",
                              still ? "hello.moving_formats" : "hello.still_formats")};
  if (hello.has_viewport())
    if (auto error = check_size(hello.viewport().width(), hello.viewport().height())) {
      error->set_field("hello.viewport." + error->field());
      return Refusal{std::move(*error)};
    }
  if (!hello.moving_format().empty() && !offers(hello.moving_formats(), hello.moving_format()))
    return Refusal{wire_error("invalid_argument",
                              "hello.moving_format is '" + hello.moving_format().substr(0, 32) + "'; expected one of hello.moving_formats, or none",
                              "hello.moving_format")};
  if (auto error = refuse_names(hello)) return Refusal{std::move(*error)};
  return std::nullopt;
}

void introduce(Viewer& viewer, const v1::Hello& hello, std::span<const Codec> moving_codecs) {
  // Video only for who says to have decoded it: an empty list stands for JPEG.
  std::vector<Codec> codecs;
  for (const Codec codec : moving_codecs)
    if (!is_video(codec) || (hello.moving_formats_size() > 0 && offers(hello.moving_formats(), name_of(codec)))) codecs.push_back(codec);
  if (codecs.empty()) codecs.push_back(Codec::jpeg);
  // One that this server lacks is left to its choice.
  const auto wanted = std::ranges::find_if(codecs, [&](Codec codec) { return name_of(codec) == hello.moving_format(); });
  const bool chooses = wanted == codecs.end();
  if (!chooses) codecs.erase(codecs.begin(), wanted);
  viewer.format.set_codecs(std::move(codecs), chooses);
  viewer.takes_bands = hello.still_formats_size() > 0 && offers(hello.still_formats(), "png-bands");
  viewer.refines = hello.refines();
  viewer.name = hello.name();
  viewer.client = hello.client();
  viewer.client_id = hello.client_id();
  // A guest's is its own: one that is called like the owner's must not pass for it.
  if (!viewer.invitation.empty() && !viewer.client_id.empty()) viewer.client_id = viewer.invitation + "/" + viewer.client_id;
}

v1::ServerMessage welcome(const Viewer& viewer, const Session& session, const Catalogue& catalogue, const SessionsOptions& options,
                          const EngineFacts& drawing) {
  v1::ServerMessage answer;
  v1::Welcome& welcome = *answer.mutable_welcome();
  welcome.set_protocol_major(kProtocolMajor);
  welcome.set_protocol_minor(kProtocolMinor);
  welcome.set_server(options.server_name);
  welcome.set_session(session.id());
  // Whoever is invited comes back by the invitation, and not with more than it gives.
  if (viewer.invitation.empty()) welcome.set_resume_token(session.resume_token());
  welcome.set_role(viewer.role);
  welcome.set_participant(viewer.key);
  welcome.set_last_command(session.commands().last(viewer.client_id));
  if (const v1::Error* error = session.commands().last_error(viewer.client_id)) *welcome.mutable_last_command_error() = *error;
  welcome.set_ends_unix_ms(static_cast<double>(options.ends));
  for (const CatalogueEntry& entry : catalogue.entries()) {
    if (welcome.datasets_size() == static_cast<int>(kMostListed)) break;
    *welcome.add_datasets() = to_wire(entry);
  }
  welcome.set_datasets_all(static_cast<std::uint32_t>(catalogue.entries().size()));
  *welcome.mutable_state() = session.wire_state();
  if (session.dataset()) *welcome.mutable_dataset_info() = to_wire(*session.dataset());
  welcome.set_device(drawing.device);
  welcome.set_device_is_software(drawing.device_is_software);
  for (const auto map : color_map_names()) welcome.add_color_maps(std::string(map));
  set_limits(*welcome.mutable_limits(), options);
  for (const Codec codec : viewer.format.codecs()) welcome.add_moving_formats(std::string(name_of(codec)));
  return answer;
}

v1::ServerMessage end_notice(const std::string& reason, UnixMs ends, UnixMs now, bool comes_back) {
  v1::ServerMessage message;
  v1::Shutdown& notice = *message.mutable_shutdown();
  notice.set_reason(reason);
  notice.set_notice(true);
  notice.set_deadline_unix_ms(static_cast<double>(ends));
  notice.set_seconds(static_cast<double>(ends - now) / 1000);
  notice.set_comes_back(comes_back);
  return message;
}

v1::ServerMessage last_word(const std::string& reason, Duration deadline, UnixMs now, bool comes_back) {
  v1::ServerMessage message;
  v1::Shutdown& shutdown = *message.mutable_shutdown();
  shutdown.set_reason(reason);
  shutdown.set_seconds(std::chrono::duration<double>(deadline).count());
  shutdown.set_deadline_unix_ms(static_cast<double>(now) + 1000 * shutdown.seconds());
  shutdown.set_comes_back(comes_back);
  return message;
}

}  // namespace isostrata
