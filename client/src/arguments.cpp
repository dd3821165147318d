#include <charconv>
#include <cstdlib>

#include "commands.h"

namespace isostrata::client {
namespace {

[[noreturn]] void refuse(const std::string& what) { throw Error("invalid_argument", what); }

double number(const std::string& text, const std::string& whole) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size()) refuse("'" + whole + "': '" + text + "' is not a number");
  return value;
}

v1::Rgb rgb(const std::string& text, const std::string& whole) {
  unsigned value = 0;
  const char* const end = text.data() + text.size();
  if (text.size() != 7 || text[0] != '#' || std::from_chars(text.data() + 1, end, value, 16).ptr != end)
    refuse("'" + whole + "': colour '" + text + "' is not #rrggbb");
  v1::Rgb out;
  out.set_r(static_cast<float>(value >> 16 & 255) / 255.0f);
  out.set_g(static_cast<float>(value >> 8 & 255) / 255.0f);
  out.set_b(static_cast<float>(value & 255) / 255.0f);
  return out;
}

}  // namespace

void parse_size(const std::string& text, std::uint32_t& width, std::uint32_t& height) {
  const auto at = text.find('x');
  const auto part = [&](const std::string& digits) {
    std::uint32_t value = 0;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    if (error != std::errc{} || end != digits.data() + digits.size() || value < 1 || value > 16384)
      refuse("size '" + text + "': expected WIDTHxHEIGHT, each 1 to 16384");
    return value;
  };
  if (at == std::string::npos) part("");
  width = part(text.substr(0, at));
  height = part(text.substr(at + 1));
}

v1::Interval parse_interval(const std::string& text, std::size_t index) {
  static const char* const kColors[] = {"#ff0000", "#00ff00", "#0000ff", "#ffff00"};
  v1::Interval out;
  *out.mutable_color() = rgb(kColors[index % 4], text);
  out.set_opacity(0.5);
  out.set_visible(true);
  std::size_t begin = 0;
  for (bool first = true; begin <= text.size(); first = false) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    const std::string part = text.substr(begin, end - begin);
    begin = end + 1;
    if (first) {
      const auto colon = part.find(':');
      if (colon == std::string::npos) refuse("interval '" + text + "': expected LOWER:UPPER");
      out.set_lower(number(part.substr(0, colon), text));
      out.set_upper(number(part.substr(colon + 1), text));
    } else if (part.starts_with("color=map:")) {
      out.set_color_map(part.substr(10));
    } else if (part.starts_with("color=")) {
      *out.mutable_color() = rgb(part.substr(6), text);
    } else if (part.starts_with("opacity=")) {
      out.set_opacity(number(part.substr(8), text));
    } else if (part.starts_with("priority=")) {
      out.set_priority(static_cast<int>(number(part.substr(9), text)));
    } else {
      refuse("interval '" + text + "': unknown part '" + part + "'; expected color=, opacity= or priority=");
    }
  }
  return out;
}

void SceneArguments::add_to(CLI::App& command) {
  command.add_option("--dataset", dataset, "Id or name of a dataset that the server offers; default: the one that is open, or the first");
  command.add_option("--array", array, "Array that intervals are extracted on");
  command.add_option("--color-by", color_by, "Array that colour maps run over");
  command.add_option("--interval", intervals, "LOWER:UPPER[,color=#rrggbb|map:NAME][,opacity=X][,priority=N]; may be repeated")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  command.add_option("--view", view, "reset, +x, -x, +y, -y, +z or -z");
  command.add_option("--size", size, "WIDTHxHEIGHT in pixels")->capture_default_str();
  command.add_option("--resume", resume, "Resume token of a living session; default: a session of its own");
}

Connection SceneArguments::open(const std::string& url, std::uint64_t& last_seq) const {
  Options options;
  parse_size(size, options.width, options.height);
  options.resume_token = resume;
  std::vector<v1::Interval> parsed;
  for (const auto& text : intervals) parsed.push_back(parse_interval(text, parsed.size()));

  Connection connection = Connection::open(url, options);
  last_seq = 0;
  std::string id = connection.state().dataset();
  if (!dataset.empty() || id.empty()) {
    std::string offered;
    bool found = false;
    for (const auto& entry : connection.welcome().datasets()) {
      offered += (offered.empty() ? "" : ", ") + entry.name();
      if (!found && (dataset.empty() || entry.id() == dataset || entry.name() == dataset)) id = entry.id(), found = true;
    }
    if (!found) refuse(dataset.empty() ? "the server offers no dataset" : "no dataset '" + dataset + "'; the server offers: " + offered);
    if (id != connection.state().dataset()) {
      v1::ClientMessage message;
      message.mutable_open_dataset()->set_id(id);
      last_seq = connection.send(std::move(message));
      connection.wait_for_dataset(id, std::chrono::minutes(10));
    }
  }
  if (!array.empty() || !color_by.empty()) {
    v1::ClientMessage message;
    message.mutable_select_arrays()->set_array(array);
    message.mutable_select_arrays()->set_color_by(color_by);
    last_seq = connection.send(std::move(message));
  }
  if (!parsed.empty()) {
    v1::ClientMessage message;
    for (auto& interval : parsed) *message.mutable_set_intervals()->add_intervals() = interval;
    last_seq = connection.send(std::move(message));
  }
  if (!view.empty()) {
    v1::ClientMessage message;
    message.mutable_set_view()->set_view(view);
    last_seq = connection.send(std::move(message));
  }
  return connection;
}

}  // namespace isostrata::client
