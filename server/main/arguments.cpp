#include "main/arguments.h"

#include <unistd.h>

#include <boost/json/serialize.hpp>
#include <charconv>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <vector>

#include "base/nearest_name.h"
#include "base/utf8.h"
#include "data/dataset/analytic.h"
#include "data/files/file_series.h"
#include "data/parts/region.h"
#include "main/ranks.h"

namespace isostrata {
namespace {

[[noreturn]] void refuse(std::string_view text, const std::string& why) {
  throw Error(ErrorCode::invalid_argument, "interval '" + std::string(text) + "': " + why);
}

template <class T>
T number(std::string_view part, std::string_view whole, const char* what) {
  T value{};
  const auto [end, error] = std::from_chars(part.data(), part.data() + part.size(), value);
  if (error != std::errc{} || end != part.data() + part.size())
    refuse(whole, std::string(what) + " '" + std::string(part) + "' is not a number");
  return value;
}

/// Throws not_found if there is no such file but one beside it, or a built-in field, whose name is nearly the same.
void say_what_was_meant(const std::string& file) {
  namespace fs = std::filesystem;
  constexpr int kMost = 10000;  // names of a folder that are looked at
  std::error_code error;
  if (file.empty() || is_analytic(file) || is_series_pattern(file) || fs::symlink_status(file, error).type() != fs::file_type::not_found) return;
  error.clear();
  const fs::path folder = fs::path(file).parent_path();
  std::vector<std::string> names;
  if (folder.empty())
    for (const std::string_view name : analytic_names()) names.emplace_back(name);
  int looked_at = 0;
  for (fs::directory_iterator entry(folder.empty() ? "." : folder, error), end; !error && entry != end && looked_at < kMost; entry.increment(error), ++looked_at)
    names.push_back((folder / entry->path().filename()).string());
  if (const std::string meant = did_you_mean(file, names); !meant.empty()) throw Error(ErrorCode::not_found, file + ": no such file or analytic data." + meant);
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

double unit(std::string_view part, std::string_view whole, const char* what) {
  const double value = number<double>(part, whole, what);
  if (!(value >= 0 && value <= 1)) refuse(whole, std::string(what) + " must be in [0, 1]");
  return value;
}

/// One key of a surface's looks. False if it is none.
bool parse_surface(SurfaceStyle& surface, std::string_view key, std::string_view value, std::string_view text) {
  if (key == "surface") {
    surface.lower = surface.upper = surface.domain = false;
    for (const std::string_view end : split(value, '+')) {
      if (end != "lower" && end != "upper" && end != "both" && end != "domain" && end != "all")
        refuse(text, "surface '" + std::string(end) + "': expected lower, upper, both, domain or all, or some joined by +");
      surface.lower = surface.lower || end == "lower" || end == "both" || end == "all";
      surface.upper = surface.upper || end == "upper" || end == "both" || end == "all";
      surface.domain = surface.domain || end == "domain" || end == "all";
    }
  } else if (key == "surface-color") {
    surface.color = parse_rgb(value);
    surface.own_color = true;
  } else if (key == "surface-opacity") {
    surface.opacity = unit(value, text, "surface-opacity");
  } else if (key == "specular") {
    surface.specular = unit(value, text, "specular");
  } else if (key == "shininess") {
    surface.shininess = number<double>(value, text, "shininess");
    if (!(surface.shininess >= 1 && surface.shininess <= 1000)) refuse(text, "shininess must be in [1, 1000]");
  } else if (key == "silhouette") {
    surface.silhouette = unit(value, text, "silhouette");
  } else if (key == "texture") {
    surface.texture = value == kStripes ? std::string(value) : color_map(value).name;  // throws if there is none
  } else if (key == "repeat") {
    surface.texture_repeat = number<double>(value, text, "repeat");
    if (!(surface.texture_repeat > 0 && surface.texture_repeat <= 10000)) refuse(text, "repeat must be in (0, 10000]");
  } else {
    return false;
  }
  return true;
}

Task* signalled_task = nullptr;

}  // namespace

IntervalArgument parse_interval(std::string_view text, std::size_t index) {
  const auto parts = split(text, ',');
  const auto ends = split(parts[0], ':');
  if (ends.size() != 2) refuse(text, "expected LOWER:UPPER");
  IntervalArgument out;
  out.interval = {number<double>(ends[0], text, "lower"), number<double>(ends[1], text, "upper")};
  if (!(out.interval.lower < out.interval.upper)) refuse(text, "lower must be less than upper");
  out.style.color = default_interval_color(index);
  bool says_surface = false;
  for (std::size_t i = 1; i < parts.size(); ++i) {
    const auto at = parts[i].find('=');
    const auto key = parts[i].substr(0, at);
    const auto value = at == std::string_view::npos ? std::string_view{} : parts[i].substr(at + 1);
    if (key == "color") {
      if (value.starts_with("map:"))
        out.style.color_map = color_map(value.substr(4)).name;  // throws if there is none
      else
        out.style.color = parse_rgb(value);
      out.has_color = true;
    } else if (key == "opacity") {
      const auto dots = value.find("..");
      out.style.opacity = unit(value.substr(0, dots), text, "opacity");
      if (dots != std::string_view::npos) out.style.opacity_upper = unit(value.substr(dots + 2), text, "opacity");
      out.has_opacity = true;
    } else if (key == "priority") {
      out.style.priority = number<int>(value, text, "priority");
      out.has_priority = true;
    } else if (key == "name") {
      out.name = value;
    } else if (parse_surface(out.style.surface, key, value, text)) {
      says_surface = true;
    } else {
      refuse(text, "unknown part '" + std::string(parts[i]) +
                       "'; expected color=, opacity=, priority=, surface=, surface-color=, surface-opacity=, specular=, "
                       "shininess=, silhouette=, texture=, repeat= or name=");
    }
  }
  SurfaceStyle& surface = out.style.surface;
  if (says_surface && !surface.lower && !surface.upper && !surface.domain) surface.lower = surface.upper = true;
  return out;
}

Task& command_task() {
  static const bool terminal = isatty(STDERR_FILENO) != 0;
  static Task task([](double fraction, std::string_view stage) {
    if (terminal)
      std::fprintf(stderr, "\r%-12.*s %3d %%%s", static_cast<int>(stage.size()), stage.data(), static_cast<int>(fraction * 100),
                   fraction >= 1 ? "\n" : "");
  });
  if (!signalled_task) {
    signalled_task = &task;
    const auto cancel = [](int) { signalled_task->cancel(); };
    std::signal(SIGINT, cancel);
    // A launcher that ends its ranks has ended those for whose replies a cancelled one would wait.
    if (!ranks_in_use()) std::signal(SIGTERM, cancel);
  }
  return task;
}

namespace {

/// Of this command; a process runs one.
Region& region_argument() {
  static Region region;
  return region;
}

/// The same file by a path without ".", but for one that is nothing else, and for what would then be the name of analytic data.
std::string without_dots(const std::string& text) {
  namespace fs = std::filesystem;
  fs::path plain;
  for (const fs::path& part : fs::path(text))
    if (part != ".") plain /= part;
  if (plain.empty() || is_analytic(text)) return text;
  return is_analytic(plain.string()) ? (fs::current_path() / plain).string() : plain.string();
}

}  // namespace

void add_region_options(CLI::App& command) {
  const auto usage = [](auto set) {
    return [set](const std::string& text) {
      try {
        set(region_argument(), text);
      } catch (const Error& error) {
        throw CLI::ValidationError(error.what());
      }
    };
  };
  command.add_option_function<std::string>(
      "--region", usage(set_box),
      "Only the points FIRST:LAST,FIRST:LAST,FIRST:LAST of a structured grid along x, y, z, from 0, both included; an end that is left out is the grid's");
  command.add_option_function<std::string>(
      "--stride", usage(set_stride),
      "Only every N-th point, or every NX,NY,NZ-th: a quick look at large data");
}

const Region& region_of_arguments() { return region_argument(); }

void add_file_option(CLI::App& command, std::string& file, const std::string& help) {
  command.add_option("FILE", file, help)->required()->transform([](const std::string& text) { return without_dots(text); });
}

std::shared_ptr<const Dataset> open_argument(const std::string& file, int step) {
  OpenOptions options;
  options.step = step;
  if (SceneRanks* const ranks = ranks_in_use()) return ranks->open({file, file}, step, command_task());
  say_what_was_meant(file);
  return open_part(file, options, region_argument(), command_task());
}

void warn_if_outside(const Interval& interval, const PointArray& array) {
  if (!(array.lower <= array.upper) || (interval.lower <= array.upper && interval.upper >= array.lower)) return;
  std::fprintf(stderr, "isostrata: nothing lies in %g:%g: the values of '%s' are from %g to %g\n", interval.lower, interval.upper, array.name.c_str(), array.lower,
               array.upper);
}

void print_json(const boost::json::value& document) {
  const std::string text = valid_json(boost::json::serialize(document));
  std::printf("%s\n", text.c_str());
}

}  // namespace isostrata
