// record: a camera's way around a session, as numbered pictures or as a film. Every picture is a still of the session, so none is
// dropped and none is blurred by haste.
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <fstream>
#include <sstream>

#include "arguments.h"
#include "camera_path.h"
#include "film.h"
#include "webm_file.h"

namespace isostrata::client {
namespace {

struct RecordArguments {
  SceneArguments scene;
  std::string out, path;
  double orbit_deg = 360, elevation_deg = 0;
  int frames = 0;
  double fps = 0, seconds = 0;
  int quality = kFilmQuality;
};

constexpr std::int64_t kMaxFrames = 1000000;

std::string contents(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  if (!file) throw ClientError("not_found", path + ": cannot be read");
  return text.str();
}

// Once around without the first picture twice; if it is not closed, both ends.
v1::Camera orbit_at(const v1::Camera& start, const RecordArguments& arguments, int frame, int frames) {
  const bool closed = std::fmod(std::abs(arguments.orbit_deg), 360) == 0;
  const double part = frames < 2 ? 0 : static_cast<double>(frame) / (closed ? frames : frames - 1);
  // About the up direction of the beginning, whatever the elevation: a plate that turns.
  return turned(turned(start, arguments.orbit_deg * part, 0), 0, arguments.elevation_deg);
}

void record(const Options& options, const RecordArguments& arguments) {
  FilmOptions film_options;
  parse_size(arguments.scene.size, film_options.width, film_options.height);
  film_options.quality = arguments.quality;
  std::optional<std::string> path_text;
  if (!arguments.path.empty()) path_text = contents(arguments.path);

  Options still = options;
  still.hidden = true;  // stills are asked for; a stream would be in their way
  Client client = connect(still, arguments.scene);
  set_scene(client, arguments.scene);
  const v1::Camera start = client.state().camera();
  std::optional<CameraPath> path;
  if (path_text) path = CameraPath::from_json(*path_text, arguments.path, start);

  film_options.fps = arguments.fps > 0 ? arguments.fps : path && path->fps() ? *path->fps() : 30;
  if (!(film_options.fps >= 0.1 && film_options.fps <= 1000))
    throw ClientError("bad_argument", "fps " + std::to_string(film_options.fps) + ": expected 0.1 to 1000");
  // A path lasts as long as its keyframes say, or is run through faster or slower.
  const double seconds = arguments.seconds > 0 ? arguments.seconds : path ? path->duration_s() : 4;
  const double wanted = arguments.frames > 0 ? arguments.frames : std::round(seconds * film_options.fps) + (path ? 1 : 0);
  if (!(wanted >= 1 && wanted <= static_cast<double>(kMaxFrames)))
    throw ClientError("bad_argument",
                      "a film of " + std::to_string(wanted) + " frames; expected 1 to " + std::to_string(kMaxFrames));
  const int frames = static_cast<int>(wanted);

  const auto film = open_film(arguments.out, film_options);
  const bool terminal = isatty(STDERR_FILENO) != 0;
  std::optional<double> shown_time;
  for (int frame = 0; frame < frames; ++frame) {
    if (path) {
      const double at = frames < 2 ? 0 : path->duration_s() * frame / (frames - 1);
      client.set_camera(path->camera_at(at));
      if (const auto time = path->data_time_at(at); time && time != shown_time) client.set_time(*(shown_time = time));
    } else {
      client.set_camera(orbit_at(start, arguments, frame, frames));
    }
    film->add(client.still(film_options.width, film_options.height, "png"));
    if (terminal) std::fprintf(stderr, "\rframe %d of %d\x1b[K", frame + 1, frames);
  }
  film->finish();
  client.set_camera(start);  // as it was found
  std::fprintf(stderr, "%s%s: %d frames of %dx%d at %g frames per second\n", terminal ? "\r\x1b[K" : "", arguments.out.c_str(),
               frames, film_options.width, film_options.height, film_options.fps);
}

}  // namespace

void add_record(CLI::App& app, Options& options) {
  CLI::App* command = app.add_subcommand("record", "Saves a camera's way around a session as pictures or as a film. Ctrl-C leaves the pictures that are complete, and nothing of a film");
  const auto arguments = std::make_shared<RecordArguments>();
  add_scene_options(*command, arguments->scene);
  command
      ->add_option("--out", arguments->out,
                   "frame-%04d.png: numbered lossless pictures; .y4m: uncompressed film; .webm: VP9 film with full chroma")
      ->required()
      ->type_name("FILE");
  auto* path = command
                   ->add_option("--path", arguments->path,
                                "Keyframes: {\"fps\":30,\"keyframes\":[{\"time\":0,\"camera\":{\"eye\":[x,y,z],\"at\":[x,y,z],"
                                "\"up\":[x,y,z],\"fov\":deg},\"data_time\":t},...]}; what one leaves out is as in the one before")
                   ->type_name("FILE.json");
  command->add_option("--orbit", arguments->orbit_deg, "Degrees around what is looked at, if there is no path")
      ->check(CLI::Range(-36000.0, 36000.0))
      ->capture_default_str()
      ->excludes(path);
  command->add_option("--elevation", arguments->elevation_deg, "Degrees above the beginning's camera, of an orbit")
      ->check(CLI::Range(-89.0, 89.0))
      ->capture_default_str()
      ->excludes(path);
  auto* frames =
      command->add_option("--frames", arguments->frames, "Number of pictures")->check(CLI::Range(std::int64_t{1}, kMaxFrames));
  command->add_option("--seconds", arguments->seconds, "Length of the film; by default the path's, or 4")
      ->check(CLI::Range(0.001, 86400.0))
      ->excludes(frames);
  command->add_option("--fps", arguments->fps, "Pictures a second; by default the path's, or 30")->check(CLI::Range(0.1, 1000.0));
  command->add_option("--quality", arguments->quality, "Of .webm: 0 lossless to 63 smallest")
      ->check(CLI::Range(0, 63))
      ->capture_default_str();
  command->callback([&options, arguments] { record(options, *arguments); });
}

}  // namespace isostrata::client
