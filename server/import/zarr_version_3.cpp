#include <numeric>

#include "import/zarr_json.h"
#include "import/zarr_metadata.h"

namespace isostrata {
namespace {

namespace json = boost::json;

/// The order of a chunk's axes after one more codec "transpose".
void transpose(ZarrArray& array, const json::object& settings) {
  const json::array* list = array_in(settings, "order");
  std::vector<std::size_t> order;
  std::vector<bool> seen(array.order.size());
  for (const json::value& axis : list ? *list : json::array{}) {
    const bool known = axis.is_int64() && axis.get_int64() >= 0 && axis.get_int64() < static_cast<std::int64_t>(seen.size());
    if (!known || seen[static_cast<std::size_t>(axis.get_int64())]) break;
    seen[static_cast<std::size_t>(axis.get_int64())] = true;
    order.push_back(array.order[static_cast<std::size_t>(axis.get_int64())]);
  }
  if (order.size() != seen.size() || list->size() != seen.size()) bad(array, "the codec 'transpose' has no list of all axes, such as [2, 1, 0]");
  array.order = std::move(order);
}

void take_codecs(ZarrArray& array, const json::object& of) {
  const json::array* codecs = array_in(of, "codecs");
  if (!codecs || codecs->empty()) bad(array, "expected 'codecs', a list that has 'bytes'");
  const json::object none;
  bool as_bytes = false;
  for (const json::value& codec : *codecs) {
    const json::object& one = codec.is_object() ? codec.get_object() : none;
    const std::string id = codec.is_string() ? std::string(codec.get_string()) : text_in(one, "name");
    const json::object* given = object_in(one, "configuration");
    const json::object& settings = given ? *given : none;
    if (id == "transpose" && !as_bytes) {
      transpose(array, settings);
    } else if (id == "bytes" && !as_bytes) {
      const std::string endian = text_in(settings, "endian");
      if (endian != "little" && endian != "big" && (!endian.empty() || size_of(array.type) > 1)) bad(array, "the codec 'bytes' says no order of bytes; expected 'endian' little or big");
      array.swap = endian == "big" && size_of(array.type) > 1;
      as_bytes = true;
    } else {
      array.codecs.push_back(zarr_codec(id, array.file));
      if (!as_bytes) bad(array, "the codec '" + id + "' comes before 'bytes'; expected it after");
    }
  }
  if (!as_bytes) bad(array, "'codecs' has no 'bytes'");
}

}  // namespace

void take_version_3(ZarrArray& array, const json::object& of) {
  array.shape = zarr_sizes(array, of, "shape");
  const json::value* type = member(of, "data_type");
  if (!type) bad(array, "expected 'data_type', such as \"uint16\"");
  take_zarr_type(array, type->is_string() ? std::string_view(type->get_string()) : std::string_view(shown(*type)));
  take_zarr_fill(array, member(of, "fill_value"));
  array.order.resize(array.shape.size());
  std::iota(array.order.begin(), array.order.end(), std::size_t{0});
  take_codecs(array, of);
  const json::object none;
  const auto part = [&](const char* name) -> const json::object& {
    const json::object* found = object_in(of, name);
    if (!found) bad(array, std::string("expected '") + name + "', an object with a name");
    return *found;
  };
  const auto settings = [&](const json::object& from) -> const json::object& {
    const json::object* found = object_in(from, "configuration");
    return found ? *found : none;
  };
  const json::object &grid = part("chunk_grid"), &key = part("chunk_key_encoding");
  if (text_in(grid, "name") != "regular") unsupported(array, "a chunk_grid '" + text_in(grid, "name").substr(0, 40) + "'; expected 'regular'");
  array.chunk = zarr_sizes(array, settings(grid), "chunk_shape");
  const std::string encoding = text_in(key, "name"), separator = text_in(settings(key), "separator");
  if (encoding != "default" && encoding != "v2") unsupported(array, "a chunk_key_encoding '" + encoding.substr(0, 40) + "'; expected 'default' or 'v2'");
  if (!separator.empty() && separator != "." && separator != "/") bad(array, "'separator' is '" + separator.substr(0, 20) + "'; expected . or /");
  array.separator = !separator.empty() ? separator[0] : encoding == "default" ? '/' : '.';
  if (encoding == "default") array.key_prefix = std::string("c") + array.separator;
  if (const json::array* more = array_in(of, "storage_transformers"); more && !more->empty()) unsupported(array, "storage_transformers " + shown(more->front()) + "; expected none");
  const json::array* names = array_in(of, "dimension_names");
  if (names && names->size() == array.shape.size())
    for (const json::value& name : *names) array.names.emplace_back(name.is_string() ? std::string(name.get_string()) : std::string());
}

}  // namespace isostrata
