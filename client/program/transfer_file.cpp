#include "transfer_file.h"

#include <google/protobuf/struct.pb.h>
#include <google/protobuf/util/json_util.h>

#include <fstream>
#include <utility>

namespace isostrata::client {
namespace {

constexpr std::size_t kMaxBytes = 1 << 20;

[[noreturn]] void refuse(const std::string& path, const std::string& why) {
  throw ClientError("bad_argument", path + ": " + why);
}

std::string read_text(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) throw ClientError("not_found", path + ": cannot be read");
  std::string text(kMaxBytes + 1, '\0');
  in.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(in.gcount()));
  if (text.size() > kMaxBytes) refuse(path, "a transfer function has at most 1 MiB");
  return text;
}

}  // namespace

std::vector<v1::TransferPoint> read_transfer(const std::string& path) {
  using google::protobuf::Value;
  Value document;
  if (!google::protobuf::util::JsonStringToMessage(read_text(path), &document).ok()) refuse(path, "not JSON");
  if (document.has_struct_value()) {
    const auto& fields = document.struct_value().fields();
    const auto points = fields.find("points");
    const Value list = points == fields.end() ? Value() : points->second;
    document = list;
  }
  if (!document.has_list_value()) refuse(path, "expected {\"points\": [...]} or a list of points");
  std::vector<v1::TransferPoint> points;
  for (const Value& item : document.list_value().values()) {
    const std::string where = "point " + std::to_string(points.size()) + ": ";
    v1::TransferPoint point;
    int found = 0;
    for (const auto& [key, value] : item.struct_value().fields()) {
      if (key == "value" && value.kind_case() == Value::kNumberValue)
        point.set_value(value.number_value());
      else if (key == "opacity" && value.kind_case() == Value::kNumberValue)
        point.set_opacity(value.number_value());
      else if (key == "color" && value.kind_case() == Value::kStringValue)
        *point.mutable_color() = rgb(value.string_value());
      else
        refuse(path, where + "unexpected '" + key + "'; expected the numbers value and opacity, and the text color");
      ++found;
    }
    if (found != 3) refuse(path, where + "expected {\"value\": V, \"color\": \"#rrggbb\", \"opacity\": A}");
    points.push_back(std::move(point));
  }
  return points;
}

}  // namespace isostrata::client
