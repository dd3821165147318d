#include "main/arguments.h"

#include <unistd.h>

#include <boost/json/serialize.hpp>
#include <charconv>
#include <csignal>
#include <cstdio>
#include <vector>

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

std::vector<std::string_view> split(std::string_view text, char separator) {
  std::vector<std::string_view> parts;
  for (;;) {
    const auto at = text.find(separator);
    parts.push_back(text.substr(0, at));
    if (at == std::string_view::npos) return parts;
    text.remove_prefix(at + 1);
  }
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
  for (std::size_t i = 1; i < parts.size(); ++i) {
    const auto at = parts[i].find('=');
    const auto key = parts[i].substr(0, at);
    const auto value = at == std::string_view::npos ? std::string_view{} : parts[i].substr(at + 1);
    if (key == "color") {
      if (value.starts_with("map:"))
        out.style.color_map = color_map(value.substr(4)).name;  // throws where there is none
      else
        out.style.color = parse_rgb(value);
      out.has_color = true;
    } else if (key == "opacity") {
      out.style.opacity = number<double>(value, text, "opacity");
      if (!(out.style.opacity >= 0 && out.style.opacity <= 1)) refuse(text, "opacity must be in [0, 1]");
      out.has_opacity = true;
    } else if (key == "priority") {
      out.style.priority = number<int>(value, text, "priority");
      out.has_priority = true;
    } else {
      refuse(text, "unknown part '" + std::string(parts[i]) + "'; expected color=, opacity= or priority=");
    }
  }
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
    std::signal(SIGTERM, cancel);
  }
  return task;
}

std::shared_ptr<const Dataset> open_argument(const std::string& file, int step) {
  OpenOptions options;
  options.step = step;
  return open_dataset(file, options, command_task());
}

void print_json(const boost::json::value& document) {
  const std::string text = boost::json::serialize(document);
  std::printf("%s\n", text.c_str());
}

}  // namespace isostrata
