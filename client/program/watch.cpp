// watch: a line for everything that happens in a session.
#include <google/protobuf/util/json_util.h>
#include <google/protobuf/util/message_differencer.h>

#include <algorithm>
#include <cstdio>

#include "arguments.h"
#include "isostrata/video.h"

namespace isostrata::client {
namespace {

using Steady = std::chrono::steady_clock;

struct WatchArguments {
  SceneArguments scene;
  double seconds = 0;
  int frames = 0;
  bool json = false;
};

// "intervals[id=3].upper: 0.4 -> 0.5", one of each field that differs.
std::string differences(const v1::State& before, const v1::State& after) {
  namespace util = google::protobuf::util;
  util::MessageDifferencer differencer;
  const auto& type = *v1::State::descriptor();
  differencer.TreatAsMap(type.FindFieldByName("intervals"), v1::Interval::descriptor()->FindFieldByName("id"));
  differencer.IgnoreField(type.FindFieldByName("revision"));
  std::string text;
  differencer.ReportDifferencesToString(&text);
  differencer.Compare(before, after);
  std::string out;
  for (std::size_t at = 0; at < text.size();) {
    const auto end = std::min(text.find('\n', at), text.size());
    out += (out.empty() ? "" : "; ") + text.substr(at, end - at);
    at = end + 1;
  }
  return out.empty() ? "nothing else" : out;
}

void print_json(v1::ServerMessage message) {
  if (message.has_frame()) message.mutable_frame()->clear_payload();
  google::protobuf::util::JsonPrintOptions print;
  print.always_print_primitive_fields = true;
  print.preserve_proto_field_names = false;
  std::string text;
  if (!google::protobuf::util::MessageToJsonString(message, &text, print).ok())
    throw ClientError("protocol", "a message is not JSON");
  std::printf("%s\n", text.c_str());
}

void print(const v1::ServerMessage& message, const v1::State& before) {
  switch (message.body_case()) {
    case v1::ServerMessage::kState:
      std::printf("state    %llu: %s\n", static_cast<unsigned long long>(message.state().revision()),
                  differences(before, message.state()).c_str());
      break;
    case v1::ServerMessage::kFrame: {
      const v1::Frame& frame = message.frame();
      std::printf("frame    %llu: revision %llu, %s %ux%u, %zu bytes (%s), %lld tetrahedra, %.1f ms on %s\n",
                  static_cast<unsigned long long>(frame.frame_id()), static_cast<unsigned long long>(frame.revision()),
                  frame.phase() == v1::FRAME_PHASE_LOSSLESS ? "lossless" : "moving", frame.width(), frame.height(),
                  frame.payload().size(), frame.format().c_str(), static_cast<long long>(frame.facts().tetrahedra()),
                  frame.stages().total_ms(), frame.facts().device().c_str());
      break;
    }
    case v1::ServerMessage::kDatasetInfo:
      std::printf("dataset  %s: %s, %lld points, %lld cells\n", message.dataset_info().name().c_str(),
                  message.dataset_info().grid().c_str(), static_cast<long long>(message.dataset_info().points()),
                  static_cast<long long>(message.dataset_info().cells()));
      break;
    case v1::ServerMessage::kProgress:
      std::printf("progress %llu: %s %.0f %%\n", static_cast<unsigned long long>(message.progress().operation()),
                  message.progress().stage().c_str(), message.progress().fraction() * 100);
      break;
    case v1::ServerMessage::kDone:
      std::printf("done     %llu%s\n", static_cast<unsigned long long>(message.done().operation()),
                  message.done().cancelled() ? ": cancelled" : "");
      break;
    case v1::ServerMessage::kError:
      std::printf("error    %s: %s\n", message.error().code().c_str(), message.error().message().c_str());
      break;
    case v1::ServerMessage::kShutdown:
      std::printf("shutdown %s\n", message.shutdown().reason().c_str());
      break;
    default:
      break;
  }
}

void print(const ConnectionEvent& event) {
  if (event.kind == ConnectionEvent::Kind::restored)
    std::printf("back     %s%zu commands sent again\n",
                event.new_session ? "in a new session, which shows what the old one showed; " : "", event.resent);
  else
    std::printf("%s %s\n", event.kind == ConnectionEvent::Kind::lost ? "lost    " : "given up", event.reason.c_str());
}

void watch(const Options& options, const WatchArguments& arguments) {
  Options quiet = options;
  quiet.on_progress = nullptr;  // they have lines of their own here
  quiet.on_connection = [&](const ConnectionEvent& event) {
    if (!arguments.json) print(event);
    std::fflush(stdout);
  };
  quiet.moving_formats = video_formats();
  FrameDecoder decoder(video_decoder);
  SceneArguments scene = arguments.scene;
  const bool pictures = !scene.size.empty();
  Client client = connect(quiet, scene);
  set_scene(client, scene);
  v1::State shown = client.state();
  if (!arguments.json)
    std::printf("session  %s shows %s at revision %llu\n", client.welcome().session().c_str(), shown.dataset().c_str(),
                static_cast<unsigned long long>(shown.revision()));
  std::fflush(stdout);
  const auto end = Steady::now() + std::chrono::duration_cast<Steady::duration>(
                                       std::chrono::duration<double>(arguments.seconds > 0 ? arguments.seconds : 1e8));
  for (int frames = 0;;) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(end - Steady::now());
    if (left.count() < 0) return;
    const auto message = client.receive(std::min(left, std::chrono::milliseconds(1000)));
    if (!message || message->has_pong()) continue;
    if (arguments.json)
      print_json(*message);
    else
      print(*message, shown);
    std::fflush(stdout);
    if (message->has_state()) shown = message->state();
    if (message->has_welcome()) shown = client.state();
    // A stream is followed as a page would follow it, so that what is told of it is what a person gets.
    if (message->has_frame()) client.decode_frame(decoder, message->frame());
    if (message->has_frame() && pictures && ++frames == arguments.frames) return;
  }
}

}  // namespace

void add_watch(CLI::App& app, Options& options) {
  CLI::App* command =
      app.add_subcommand("watch", "Prints a line for each change of a session's state, each frame, progress and error");
  const auto arguments = std::make_shared<WatchArguments>();
  arguments->scene.size.clear();
  add_scene_options(*command, arguments->scene);
  command->get_option("--size")->description("WIDTHxHEIGHT of the frames in pixels; none: no frames are sent");
  command->add_option("--seconds", arguments->seconds, "How long; by default until Ctrl-C")->check(CLI::Range(0.001, 1e7));
  command->add_option("--frames", arguments->frames, "Ends after this many frames")
      ->check(CLI::Range(1, 1000000000))
      ->needs("--size");
  command->add_flag("--json", arguments->json, "A JSON document a line: the protocol's ServerMessage without pictures");
  command->callback([&options, arguments] {
    try {
      watch(options, *arguments);
    } catch (const ClientError& error) {
      if (error.code() != "cancelled" || !*options.stop) throw;  // Ctrl-C is how it is meant to end
    }
  });
}

}  // namespace isostrata::client
