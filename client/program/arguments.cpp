#include "arguments.h"

#include <array>
#include <charconv>

#include "transfer_file.h"
#include "whole_file.h"

namespace isostrata::client {
namespace {

[[noreturn]] void refuse(const std::string& what, const std::string& text, const std::string& why) {
  throw ClientError("bad_argument", what + " '" + text + "': " + why);
}

double number(std::string_view part, const std::string& what, const std::string& whole) {
  double value = 0;
  const auto [end, error] = std::from_chars(part.data(), part.data() + part.size(), value);
  if (error != std::errc{} || end != part.data() + part.size() || part.empty())
    refuse(what, whole, "'" + std::string(part) + "' is not a number");
  return value;
}

std::vector<std::string_view> split(std::string_view text, char separator) {
  std::vector<std::string_view> parts;
  for (;;) {
    const auto at = text.find(separator);
    parts.push_back(text.substr(0, at));
    if (at == std::string_view::npos) return parts;
    text.remove_prefix(at + 1);
  }
}

v1::Rgb parse_rgb(std::string_view text, const std::string& whole) {
  try {
    return rgb(std::string(text));
  } catch (const ClientError&) {
    refuse("interval", whole, "expected color=#rrggbb or color=map:NAME");
  }
}

// The colours that the server gives to a session's first intervals.
v1::Rgb default_color(std::size_t index) {
  static constexpr std::array<std::array<float, 3>, 4> kColors{
      {{0.9f, 0.12f, 0.12f}, {0.15f, 0.75f, 0.2f}, {0.15f, 0.35f, 0.95f}, {0.97f, 0.85f, 0.1f}}};
  const auto& color = kColors[index % kColors.size()];
  v1::Rgb rgb;
  rgb.set_r(color[0]);
  rgb.set_g(color[1]);
  rgb.set_b(color[2]);
  return rgb;
}

/// One key of a surface's looks. False if it is none. The server judges the numbers.
bool set_surface(v1::Surface& surface, std::string_view key, std::string_view value, const std::string& text) {
  if (key == "surface") {
    for (const std::string_view end : split(value, '+')) {
      if (end != "lower" && end != "upper" && end != "both" && end != "domain" && end != "all")
        refuse("interval", text, "surface '" + std::string(end) + "': expected lower, upper, both, domain or all");
      if (end != "upper" && end != "domain") surface.set_lower(true);
      if (end != "lower" && end != "domain") surface.set_upper(true);
      if (end == "domain" || end == "all") surface.set_domain(true);
    }
  } else if (key == "surface-color") {
    *surface.mutable_color() = parse_rgb(value, text);
  } else if (key == "surface-opacity") {
    surface.set_opacity(number(value, "interval", text));
  } else if (key == "specular") {
    surface.set_specular(number(value, "interval", text));
  } else if (key == "shininess") {
    surface.set_shininess(number(value, "interval", text));
  } else if (key == "silhouette") {
    surface.set_silhouette(number(value, "interval", text));
  } else if (key == "texture") {
    surface.set_texture(std::string(value));
  } else if (key == "repeat") {
    surface.set_texture_repeat(number(value, "interval", text));
  } else {
    return false;
  }
  return true;
}

}  // namespace

void add_scene_options(CLI::App& command, SceneArguments& arguments) {
  command.add_option("--dataset", arguments.dataset, "Id or name of the dataset to open");
  command.add_option("--array", arguments.array, "Array that intervals are cut from");
  command
      .add_option("--interval", arguments.intervals,
                  "LOWER:UPPER and any of ,color=#rrggbb|map:NAME ,opacity=X|A..B ,priority=N, and of the surface's looks that "
                  "`isostrata render` takes; they replace the session's")
      ->type_name("INTERVAL");
  command
      .add_option("--transfer", arguments.transfer,
                  "A transfer function in place of the session's intervals: the JSON that `isostrata render --transfer` takes")
      ->type_name("FILE.json")
      ->excludes("--interval");
  command.add_option("--size", arguments.size, "WIDTHxHEIGHT in pixels")->capture_default_str();
  command.add_option("--camera", arguments.camera, "eye=x,y,z;at=x,y,z;up=x,y,z;fov=deg, or reset, +x, -x, +y, -y, +z, -z");
  command.add_option("--session", arguments.session, "Id or resume token of the session to join; none: a new one");
}

v1::Interval parse_interval(const std::string& text, std::size_t index) {
  const auto parts = split(text, ',');
  const auto ends = split(parts[0], ':');
  if (ends.size() != 2) refuse("interval", text, "expected LOWER:UPPER");
  v1::Interval interval;
  interval.set_lower(number(ends[0], "interval", text));
  interval.set_upper(number(ends[1], "interval", text));
  *interval.mutable_color() = default_color(index);
  interval.set_opacity(0.5);
  interval.set_visible(true);
  for (std::size_t i = 1; i < parts.size(); ++i) {
    const auto at = parts[i].find('=');
    const auto key = parts[i].substr(0, at);
    const auto value = at == std::string_view::npos ? std::string_view{} : parts[i].substr(at + 1);
    if (key == "color" && value.starts_with("map:"))
      interval.set_color_map(std::string(value.substr(4)));
    else if (key == "color")
      *interval.mutable_color() = parse_rgb(value, text);
    else if (key == "opacity") {
      const auto dots = value.find("..");
      interval.set_opacity(number(value.substr(0, dots), "interval", text));
      if (dots != std::string_view::npos) interval.set_opacity_upper(number(value.substr(dots + 2), "interval", text));
    } else if (set_surface(*interval.mutable_surface(), key, value, text))
      continue;
    else if (key == "priority")
      interval.set_priority(static_cast<int>(number(value, "interval", text)));
    else
      refuse("interval", text,
             "unknown part '" + std::string(parts[i]) +
                 "'; expected color=, opacity=, priority=, surface=, surface-color=, surface-opacity=, "
                 "specular=, shininess=, silhouette=, texture= or repeat=");
  }
  v1::Surface& surface = *interval.mutable_surface();
  if (surface.ByteSizeLong() == 0)
    interval.clear_surface();
  else if (!surface.lower() && !surface.upper() && !surface.domain())
    surface.set_lower(true), surface.set_upper(true);  // a look alone means both ends
  return interval;
}

v1::Camera parse_camera(const std::string& text, const v1::Camera& base) {
  v1::Camera camera = base;
  for (const auto part : split(text, ';')) {
    const auto at = part.find('=');
    const auto key = part.substr(0, at);
    const auto value = at == std::string_view::npos ? std::string_view{} : part.substr(at + 1);
    if (key == "fov") {
      camera.set_fov_deg(number(value, "camera", text));
      continue;
    }
    v1::Vec3* vector = key == "eye"  ? camera.mutable_eye()
                       : key == "at" ? camera.mutable_at()
                       : key == "up" ? camera.mutable_up()
                                     : nullptr;
    const auto xyz = split(value, ',');
    if (!vector || xyz.size() != 3) refuse("camera", text, "expected eye=x,y,z;at=x,y,z;up=x,y,z;fov=deg, or a view such as +x");
    vector->set_x(number(xyz[0], "camera", text));
    vector->set_y(number(xyz[1], "camera", text));
    vector->set_z(number(xyz[2], "camera", text));
  }
  return camera;
}

void parse_size(const std::string& text, int& width, int& height) {
  const auto parts = split(text, 'x');
  if (parts.size() != 2) refuse("size", text, "expected WIDTHxHEIGHT");
  const double w = number(parts[0], "size", text), h = number(parts[1], "size", text);
  if (!(w >= 1 && w <= 16384 && h >= 1 && h <= 16384)) refuse("size", text, "expected 1..16384 pixels on each side");
  width = static_cast<int>(w);
  height = static_cast<int>(h);
}

Client connect(Options options, const SceneArguments& arguments) {
  if (arguments.size.empty())
    options.width = 0;
  else
    parse_size(arguments.size, options.width, options.height);
  if (arguments.session.size() == 16)
    options.session = arguments.session;
  else
    options.resume_token = arguments.session;
  Client client(options);
  if (options.session.empty() && !options.resume_token.empty() && client.welcome().resume_token() != options.resume_token)
    throw ClientError("not_found", "the session to join is not there any more");
  return client;
}

void set_scene(Client& client, const SceneArguments& arguments) {
  // What is wrong with a file is said before anything is changed.
  const std::vector<v1::TransferPoint> transfer =
      arguments.transfer.empty() ? std::vector<v1::TransferPoint>{} : read_transfer(arguments.transfer);
  std::string id;
  for (const v1::DatasetEntry& entry : client.welcome().datasets())
    if (entry.id() == arguments.dataset || (id.empty() && entry.name() == arguments.dataset)) id = entry.id();
  if (arguments.dataset.empty() && client.state().dataset().empty() && client.welcome().datasets_size() > 0)
    id = client.welcome().datasets(0).id();
  if (id.empty() && client.state().dataset().empty())
    throw ClientError("not_found", arguments.dataset.empty()
                                       ? "the server offers no dataset"
                                       : "dataset '" + arguments.dataset + "' is not offered by this server; `info` lists them");
  if (!id.empty() && client.state().dataset() != id) client.open_dataset(id);
  if (!arguments.array.empty()) client.select_array(arguments.array);
  if (!arguments.intervals.empty()) {
    std::vector<v1::Interval> intervals;
    for (std::size_t i = 0; i < arguments.intervals.size(); ++i) intervals.push_back(parse_interval(arguments.intervals[i], i));
    client.set_intervals(intervals);
  }
  if (!arguments.transfer.empty()) client.set_transfer_function(transfer);
  if (arguments.camera.empty()) return;
  if (arguments.camera.find('=') == std::string::npos)
    client.set_view(arguments.camera);
  else
    client.set_camera(parse_camera(arguments.camera, client.state().camera()));
}

void write_file(const std::string& path, const std::string& bytes) {
  WholeFile file(path);
  file.write(bytes);
  file.finish();
}

}  // namespace isostrata::client
