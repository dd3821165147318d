// latency: drags as a person would and reports what came back.
#include <algorithm>
#include <boost/json/array.hpp>
#include <boost/json/object.hpp>
#include <boost/json/serialize.hpp>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <map>
#include <sstream>

#include "arguments.h"
#include "drag.h"
#include "isostrata/video.h"

namespace isostrata::client {
namespace {

double percentile(const std::vector<double>& sorted, double p) {
  if (sorted.empty()) return 0;
  const double rank = std::ceil(p * static_cast<double>(sorted.size()));
  return sorted[static_cast<std::size_t>(std::clamp(rank - 1, 0.0, static_cast<double>(sorted.size() - 1)))];
}

boost::json::object summary(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return {{"p50", percentile(values, 0.5)}, {"p95", percentile(values, 0.95)}, {"max", percentile(values, 1)}};
}

template <class Of, class Value>
std::vector<double> each(const std::vector<Of>& of, Value Of::*value) {
  std::vector<double> values;
  for (const Of& one : of) values.push_back(static_cast<double>(one.*value));
  return values;
}

/// How old pictures were when they were shown, and how old what stood on the screen became until the next one came.
std::pair<double, double> staleness(const std::vector<DraggedFrame>& frames) {
  double shown = 0, standing = 0;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    shown = std::max(shown, frames[i].decoded_at_ms - frames[i].input_at_ms);
    if (i > 0) standing = std::max(standing, frames[i].decoded_at_ms - frames[i - 1].input_at_ms);
  }
  return {shown, standing};
}

/// How many frames came in each format.
boost::json::object codecs_of(const std::vector<DraggedFrame>& frames) {
  std::map<std::string, int> counts;
  for (const DraggedFrame& frame : frames) ++counts[frame.format];
  boost::json::object out;
  for (const auto& [format, count] : counts) out[format] = count;
  return out;
}

std::string codec_of(const std::vector<DraggedFrame>& frames) {
  std::string codec;
  for (const DraggedFrame& frame : frames)
    if (frame.format != "png") codec = frame.format;  // the moving frames', not that of a rest in between
  return codec.empty() && !frames.empty() ? frames.back().format : codec;
}

/// How many of the lossless picture's channels differ from the reference's.
std::int64_t differing(const Picture& picture, const std::string& reference) {
  std::ifstream file(reference, std::ios::binary);
  std::ostringstream bytes;
  bytes << file.rdbuf();
  if (!file) throw ClientError("bad_argument", reference + ": cannot be read");
  const Picture wanted = decode(bytes.str());
  if (wanted.width != picture.width || wanted.height != picture.height) return static_cast<std::int64_t>(wanted.rgb.size());
  std::int64_t count = 0;
  for (std::size_t i = 0; i < wanted.rgb.size(); ++i) count += wanted.rgb[i] != picture.rgb[i];
  return count;
}

boost::json::object report(const Client& client, const Dragged& d, const SceneArguments& scene, const std::string& reference) {
  const auto [shown, standing] = staleness(d.frames);
  double bytes = 0;
  int smallest = d.frames.empty() ? 0 : d.frames.front().height;
  for (const DraggedFrame& frame : d.frames) {
    bytes += frame.bytes;
    smallest = std::min(smallest, frame.height);
  }
  int width = 0, height = 0;
  parse_size(scene.size, width, height);
  const auto count = static_cast<double>(d.frames.size());
  boost::json::object document{{"dataset", client.state().dataset()},
                               {"device", d.device},
                               {"size", {width, height}},
                               {"codec", codec_of(d.frames)},
                               {"codecs", codecs_of(d.frames)},
                               {"seconds", d.seconds},
                               {"frames", d.frames.size()},
                               {"fps", count / d.seconds},
                               {"inputs", d.inputs},
                               {"input_to_decoded_ms", summary(each(d.latency, &InputLatency::latency_ms))},
                               {"bytes_per_frame", bytes / count},
                               {"megabits_per_second", bytes * 8e-6 / d.seconds},
                               {"lowest_height", smallest},
                               {"stale_max_ms", shown},
                               {"on_screen_max_ms", standing},
                               {"tetrahedra", d.tetrahedra},
                               {"extract_ms", summary(each(d.frames, &DraggedFrame::extract_ms))},
                               {"draw_ms", summary(each(d.frames, &DraggedFrame::draw_ms))},
                               {"encode_ms", summary(each(d.frames, &DraggedFrame::encode_ms))},
                               {"decode_ms", summary(each(d.frames, &DraggedFrame::decode_ms))},
                               {"rest_to_settled_ms", d.rest_to_settled_ms},
                               {"rest_to_lossless_ms", d.rest_to_lossless_ms},
                               {"lossless_bytes", d.lossless_bytes}};
  if (!reference.empty()) document["lossless_differs"] = differing(d.lossless, reference);
  if (!d.viewers_latency_ms.empty()) {
    document["viewers_frames"] = d.viewers_frames;
    document["viewers_latency_ms"] = summary(d.viewers_latency_ms);
  }
  return document;
}

void write_timeline(const Dragged& d, const std::string& path) {
  boost::json::array inputs, frames;
  for (const InputLatency& of : d.latency) inputs.push_back({of.sent_at_ms, of.latency_ms});
  for (const DraggedFrame& f : d.frames)
    frames.push_back({f.decoded_at_ms, f.decoded_at_ms - f.input_at_ms, f.bytes, f.width, f.height, f.format, f.draw_ms,
                      f.encode_ms, f.decode_ms, f.forecasts});
  std::ofstream file(path, std::ios::binary | std::ios::trunc);
  file << boost::json::serialize(
              boost::json::object{{"began_at_ms", d.began_at_ms}, {"inputs", std::move(inputs)}, {"frames", std::move(frames)}})
       << "\n";
  if (!file.flush()) throw ClientError("bad_argument", path + ": cannot be written");
}

void print_text(const boost::json::object& d, const Dragged& dragged) {
  const auto number = [](const boost::json::value& v) { return v.to_number<double>(); };
  std::printf("%zu frames in %.1f s: %.1f frames per second, %.0f bytes each (%s), up to %lld tetrahedra on %s\n",
              dragged.frames.size(), dragged.seconds, number(d.at("fps")), number(d.at("bytes_per_frame")),
              d.at("codec").as_string().c_str(), static_cast<long long>(dragged.tetrahedra), dragged.device.c_str());
  const auto& ms = d.at("input_to_decoded_ms");
  std::printf("input to decoded frame: p50 %.1f ms, p95 %.1f ms, max %.1f ms over %zu inputs; oldest picture shown %.0f ms\n",
              number(ms.at("p50")), number(ms.at("p95")), number(ms.at("max")), dragged.latency.size(),
              number(d.at("stale_max_ms")));
  std::printf("from rest to the lossless frame: %.0f ms, %.0f bytes\n", dragged.rest_to_lossless_ms, dragged.lossless_bytes);
}

}  // namespace

void add_latency(CLI::App& app, Options& options) {
  CLI::App* command = app.add_subcommand("latency",
                                         "Drags an interval's end, or turns the camera, at a display's rate and reports frames "
                                         "per second and latency");
  struct Arguments {
    SceneArguments scene;
    DragArguments drag;
    std::string reference, timeline, codec = "auto";
    bool json = false;
  };
  const auto a = std::make_shared<Arguments>();
  add_scene_options(*command, a->scene);
  command->add_option("--seconds", a->drag.seconds, "How long to drag")->check(CLI::Range(0.1, 3600.0))->capture_default_str();
  command->add_flag("--turn", a->drag.camera, "Turn the camera instead of dragging an interval");
  command->add_option("--rate", a->drag.inputs_per_second, "Inputs a second")
      ->check(CLI::Range(1.0, 10000.0))
      ->capture_default_str();
  command
      ->add_option("--viewers", a->drag.viewers, "Further connections that look at the same session (with --turn they are timed)")
      ->check(CLI::Range(0, 1000));
  command->add_option("--silent", a->drag.silent, "And connections that never read")->check(CLI::Range(0, 1000));
  command->add_option("--reference", a->reference, "A PNG that the lossless frame at rest is compared with, pixel by pixel")
      ->check(CLI::ExistingFile)
      ->type_name("FILE.png");
  command
      ->add_option("--timeline", a->timeline,
                   "A JSON file to write: inputs [sent ms, latency ms] and frames [decoded ms, age ms, bytes, width, height, "
                   "format, draw ms, encode ms, decode ms, forecasts] by the machine's steady clock")
      ->type_name("FILE");
  command->add_option("--codec", a->codec, "Of frames in motion: auto (the server chooses by measured times), jpeg or vp9-444")
      ->check(CLI::IsMember({"auto", "jpeg", "vp9-444"}))
      ->capture_default_str();
  command->add_flag("--json", a->json, "One JSON document");
  command->callback([&options, a] {
    options.moving_formats = video_formats();
    if (a->codec != "auto") options.moving_format = a->codec;
    Client client = connect(options, a->scene);
    set_scene(client, a->scene);
    if (client.state().intervals_size() == 0)
      throw ClientError("not_found", "the session has no interval to drag; give one with --interval");
    // Loading and the first extraction are not what is measured; and a camera to turn is known once a frame has shown it.
    const v1::Frame first = client.lossless_frame();
    if (a->drag.camera && !client.state().has_camera()) {
      v1::ClientMessage camera;
      *camera.mutable_set_camera()->mutable_camera() = first.camera();
      client.command(std::move(camera));
    }
    Options joining = options;
    parse_size(a->scene.size, joining.width, joining.height);
    const Dragged dragged = drag(client, joining, a->drag);
    if (dragged.frames.empty() || dragged.latency.empty()) throw ClientError("timeout", "no frame came during the drag");
    const boost::json::object document = report(client, dragged, a->scene, a->reference);
    if (!a->timeline.empty()) write_timeline(dragged, a->timeline);
    if (a->json)
      std::printf("%s\n", boost::json::serialize(document).c_str());
    else
      print_text(document, dragged);
  });
}

}  // namespace isostrata::client
