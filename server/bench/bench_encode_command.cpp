// Frames of a camera that turns, through every codec: bytes and time, at the same likeness to the picture.
#include <algorithm>
#include <boost/json.hpp>
#include <cmath>
#include <cstdio>
#include <memory>

#include "base/error.h"
#include "base/parallel.h"
#include "base/simd_level.h"
#include "base/stopwatch.h"
#include "bench/commands.h"
#include "data/dataset/array_or_first.h"
#include "encoding/decoder.h"
#include "encoding/encoder.h"
#include "encoding/picture_distance.h"
#include "engine/picture/draw_input.h"
#include "engine/picture/extract_scene.h"
#include "main/picture_arguments.h"
#include "rendering/picture/turn_camera.h"

namespace isostrata {
namespace {

constexpr int kMinKbps = 100, kMaxKbps = 200000;

struct EncodeArguments {
  std::vector<std::string> data{"cylinder", "torus:96"};
  std::vector<std::string> intervals, codecs;
  std::vector<std::string> sizes{"1280x720"};
  std::string array;
  double degrees = 1.5;  // a frame
  int frames = 60, quality = 90, kbps = 0;
  int threads = 0;
  bool json = false;
};

struct EncodeRun {
  Codec codec = Codec::jpeg;
  std::string implementation;
  int setting = 0;                         // JPEG's quality, video's kb/s
  double ssim = 1, psnr = 100, bytes = 0;  // means
  double key_bytes = 0;
  double min_ms = 0, median_ms = 0, max_ms = 0, decode_ms = 0;
};

std::vector<Image> draw_frames(const EncodeArguments& arguments, const std::string& data, const std::string& size) {
  const std::shared_ptr<const Dataset> dataset = open_argument(data);
  const PointArray& array = array_or_first(*dataset, arguments.array);
  Scene scene;
  scene.array = array.name;
  std::vector<std::string> intervals = arguments.intervals;
  if (intervals.empty()) {  // three layers: opaque and half transparent, one colour and many
    const auto at = [&](double part) { return std::to_string(array.lower + part * (array.upper - array.lower)); };
    intervals = {at(0.1) + ":" + at(0.18) + ",color=#ff3020,opacity=0.95",
                 at(0.4) + ":" + at(0.5) + ",color=map:viridis,opacity=0.5",
                 at(0.75) + ":" + at(0.8) + ",color=#2060ff,opacity=0.9"};
  }
  scene.intervals = parse_intervals(intervals, *dataset, array);
  const auto extracted = extract_scene(dataset, scene, nullptr, command_task());
  const auto [width, height] = parse_size(size);
  DrawInput input = draw_input(*extracted, scene, width, height);
  const Camera start = input.camera;
  const auto renderer = make_renderer({"native", "native"});
  std::vector<Image> frames;
  for (int i = 0; i < arguments.frames; ++i) {
    command_task().check();
    input.camera = turned(start, arguments.degrees * i);
    frames.push_back(std::get<Image>(renderer->draw(input).image));
  }
  return frames;
}

EncodeRun measure(Codec codec, const std::vector<Image>& frames, int setting) {
  const auto encoder = make_encoder(codec);
  const auto decoder = codec == Codec::png ? nullptr : make_decoder(codec);
  EncodeRun run{codec, encoder->implementation(), setting};
  std::vector<double> times;
  double ssim = 0, psnr = 0, bytes = 0, decode_ms = 0;
  for (const Image& frame : frames) {
    command_task().check();
    EncodeOrder order;
    (is_video(codec) ? order.bitrate_kbps : order.quality) = setting;
    Stopwatch watch;
    const EncodedFrame encoded = encoder->encode(frame, order);
    times.push_back(watch.lap_ms());
    bytes += static_cast<double>(encoded.bytes.size());
    if (times.size() == 1) run.key_bytes = static_cast<double>(encoded.bytes.size());
    if (!decoder) continue;
    watch.lap_ms();
    const Image decoded = decoder->decode(encoded.bytes);
    decode_ms += watch.lap_ms();
    const PictureDistance apart = picture_distance(frame, decoded);
    ssim += apart.ssim, psnr += apart.psnr;
  }
  const auto n = static_cast<double>(frames.size());
  if (decoder) run.ssim = ssim / n, run.psnr = psnr / n, run.decode_ms = decode_ms / n;
  run.bytes = bytes / n;
  std::sort(times.begin(), times.end());
  run.min_ms = times.front(), run.median_ms = times[times.size() / 2], run.max_ms = times.back();
  return run;
}

/// The least bit rate with at least that SSIM, to within 3 %; the largest rate where none has it.
EncodeRun measure_at(Codec codec, const std::vector<Image>& frames, double ssim) {
  double low = kMinKbps, high = kMaxKbps;
  EncodeRun best = measure(codec, frames, kMaxKbps);
  if (best.ssim < ssim) return best;
  while (high / low > 1.03) {
    const double middle = std::sqrt(low * high);
    EncodeRun run = measure(codec, frames, static_cast<int>(middle));
    if (run.ssim >= ssim)
      high = middle, best = std::move(run);
    else
      low = middle;
  }
  return best;
}

boost::json::object to_json(const EncodeRun& run, const std::string& data, const Image& frame, const EncodeRun& jpeg,
                            std::size_t frames) {
  return {{"data", data},
          {"size", boost::json::array{frame.width, frame.height}},
          {"frames", frames},
          {"codec", name_of(run.codec)},
          {"implementation", run.implementation},
          {"setting", run.setting},
          {"ssim", run.ssim},
          {"psnr", run.psnr},
          {"bytes_per_frame", run.bytes},
          {"key_frame_bytes", run.key_bytes},
          {"bytes_of_jpeg", run.bytes / jpeg.bytes},
          {"encode_ms", boost::json::object{{"min", run.min_ms}, {"median", run.median_ms}, {"max", run.max_ms}}},
          {"decode_ms", run.decode_ms}};
}

void print_text(const EncodeRun& run, const std::string& data, const Image& frame, const EncodeRun& jpeg) {
  const std::string size = std::to_string(frame.width) + "x" + std::to_string(frame.height);
  const std::string setting = run.codec == Codec::png ? "" : std::to_string(run.setting) + (is_video(run.codec) ? " kb/s" : "");
  std::printf("%-14s %-10s %-9s %12s %8.4f %7.2f %10.0f %10.0f %8.2f %7.1f %7.1f %7.1f %7.1f  %s\n", data.c_str(), size.c_str(),
              std::string(name_of(run.codec)).c_str(), setting.c_str(), run.ssim, run.psnr, run.bytes, run.key_bytes,
              run.bytes / jpeg.bytes, run.min_ms, run.median_ms, run.max_ms, run.decode_ms, run.implementation.c_str());
  std::fflush(stdout);
}

void run(const EncodeArguments& arguments) {
  for (const std::string& size : arguments.sizes) parse_size(size);
  if (arguments.threads > 0) set_thread_count(arguments.threads);
  std::vector<Codec> codecs = moving_codecs();
  codecs.push_back(Codec::png);
  if (!arguments.codecs.empty())
    std::erase_if(codecs, [&](Codec codec) {
      return std::find(arguments.codecs.begin(), arguments.codecs.end(), name_of(codec)) == arguments.codecs.end();
    });
  boost::json::array runs;
  if (!arguments.json)
    std::printf("%-14s %-10s %-9s %12s %8s %7s %10s %10s %8s %7s %7s %7s %7s  %s\n", "data", "size", "codec", "setting", "SSIM",
                "PSNR", "bytes", "first", "of JPEG", "min ms", "median", "max", "decode", "by");
  for (const std::string& data : arguments.data)
    for (const std::string& size : arguments.sizes) {
      const std::vector<Image> frames = draw_frames(arguments, data, size);
      const EncodeRun jpeg = measure(Codec::jpeg, frames, arguments.quality);
      for (const Codec codec : codecs) {
        const EncodeRun one = codec == Codec::jpeg  ? jpeg
                             : codec == Codec::png ? measure(codec, frames, 100)
                             : arguments.kbps > 0  ? measure(codec, frames, arguments.kbps)
                                                   : measure_at(codec, frames, jpeg.ssim);
        if (arguments.json)
          runs.push_back(to_json(one, data, frames.front(), jpeg, frames.size()));
        else
          print_text(one, data, frames.front(), jpeg);
      }
    }
  if (arguments.json) print_json(boost::json::object{{"runs", std::move(runs)}, {"threads", thread_count()}, {"simd", simd_level()}});
}

}  // namespace

void add_bench_encode_command(CLI::App& bench) {
  CLI::App* command =
      bench.add_subcommand("encode", "Times every codec on frames of a turning camera, video at the SSIM that JPEG has");
  auto arguments = std::make_shared<EncodeArguments>();
  command->add_option("--data", arguments->data, "Files or names of analytic data; may be repeated")
      ->allow_extra_args(false)
      ->capture_default_str();
  command->add_option("--array", arguments->array, "The point array to extract on (default: the first)");
  command->add_option("--interval", arguments->intervals, "As in render; may be repeated (default: three layers)")
      ->allow_extra_args(false);
  command->add_option("--size", arguments->sizes, "WIDTHxHEIGHT in pixels; may be repeated")
      ->allow_extra_args(false)
      ->capture_default_str();
  command
      ->add_option("--codec", arguments->codecs, "vp9-444, jpeg or png; may be repeated (default: all that work here)")
      ->check(CLI::IsMember({"vp9-444", "jpeg", "png"}))
      ->allow_extra_args(false);
  command->add_option("--frames", arguments->frames, "Frames to encode")->check(CLI::Range(2, 10000))->capture_default_str();
  command->add_option("--degrees", arguments->degrees, "Degrees that the camera turns from one frame to the next")
      ->capture_default_str();
  command->add_option("--quality", arguments->quality, "JPEG's; video gets the bit rate that reaches its SSIM")
      ->check(CLI::Range(1, 100))
      ->capture_default_str();
  command->add_option("--kbps", arguments->kbps, "Video's bit rate instead of JPEG's SSIM (0)")->check(CLI::Range(0, kMaxKbps));
  command->add_option("--threads", arguments->threads, "Threads to use (default: all cores)")->check(CLI::Range(0, 4096));
  command->add_flag("--json", arguments->json, "Print one JSON document");
  command->callback([arguments] { run(*arguments); });
}

}  // namespace isostrata
