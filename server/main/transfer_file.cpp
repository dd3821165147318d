#include "main/transfer_file.h"

#include <boost/json.hpp>
#include <fstream>
#include <sstream>

#include "base/error.h"

namespace isostrata {
namespace {

namespace json = boost::json;

constexpr std::size_t kMaxBytes = 1 << 20;
constexpr double kTableOpacity = 0.3;

[[noreturn]] void refuse(const std::filesystem::path& path, const std::string& why) {
  throw Error(ErrorCode::bad_data, path.string() + ": " + why);
}

std::string read_text(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) throw Error(ErrorCode::not_found, path.string() + ": cannot be read");
  std::string text(kMaxBytes + 1, '\0');
  in.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(in.gcount()));
  if (text.size() > kMaxBytes) throw Error(ErrorCode::too_large, path.string() + ": a transfer function has at most 1 MiB");
  return text;
}

double number(const json::object& point, const char* key, const std::string& where, const std::filesystem::path& path) {
  const json::value* value = point.if_contains(key);
  if (!value || !value->is_number()) refuse(path, where + ": expected a number '" + key + "'");
  return value->to_number<double>();
}

std::vector<TransferPoint> points_of_json(const std::filesystem::path& path, const std::string& text) {
  boost::system::error_code error;
  const json::value document = json::parse(text, error);
  if (error) refuse(path, "not JSON: " + error.message());
  const json::value* list = document.is_object() ? document.as_object().if_contains("points") : &document;
  if (!list || !list->is_array()) refuse(path, "expected {\"points\": [...]} or a list of points");
  std::vector<TransferPoint> points;
  for (const json::value& item : list->as_array()) {
    const std::string where = "point " + std::to_string(points.size());
    if (!item.is_object()) refuse(path, where + ": expected {\"value\": V, \"color\": \"#rrggbb\", \"opacity\": A}");
    const json::object& point = item.as_object();
    const json::value* color = point.if_contains("color");
    if (!color || !color->is_string()) refuse(path, where + ": expected a text 'color'");
    for (const auto& member : point)
      if (member.key() != "value" && member.key() != "color" && member.key() != "opacity")
        refuse(path, where + ": unknown '" + std::string(member.key()) + "'; expected value, color and opacity");
    points.push_back({number(point, "value", where, path), parse_rgb(color->as_string()), number(point, "opacity", where, path)});
  }
  return points;
}

std::vector<TransferPoint> points_of_table(const std::filesystem::path& path, std::string text, double lower, double upper) {
  std::vector<TransferPoint> points;
  std::istringstream lines(text);
  int number = 0;
  for (std::string line; std::getline(lines, line);) {
    ++number;
    std::replace(line.begin(), line.end(), ',', ' ');
    std::istringstream words(line);
    std::vector<double> values;
    for (double v; words >> v;) values.push_back(v);
    if (words.clear(), words >> std::ws, !words.eof() || (!values.empty() && values.size() != 3 && values.size() != 4))
      refuse(path, "line " + std::to_string(number) + ": expected R G B or R G B OPACITY, each in [0, 1]");
    if (values.empty()) continue;
    points.push_back({0,
                      {static_cast<float>(values[0]), static_cast<float>(values[1]), static_cast<float>(values[2])},
                      values.size() == 4 ? values[3] : kTableOpacity});
  }
  if (points.size() < 2) refuse(path, std::to_string(points.size()) + " colours; expected two or more");
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double t = static_cast<double>(i) / static_cast<double>(points.size() - 1);
    points[i].value = i + 1 == points.size() ? upper : lower + (upper - lower) * t;
  }
  return thin_out(points);
}

}  // namespace

std::vector<TransferPoint> read_transfer(const std::filesystem::path& path, double lower, double upper) {
  const std::string text = read_text(path);
  return path.extension() == ".json" ? points_of_json(path, text) : points_of_table(path, text, lower, upper);
}

}  // namespace isostrata
