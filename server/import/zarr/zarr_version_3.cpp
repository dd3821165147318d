#include <numeric>

#include "import/zarr/zarr_json.h"
#include "import/zarr/zarr_metadata.h"

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

/// A codec, or another part that may be extended: an object with a name and settings, or its name alone.
struct Named {
  std::string name;
  const json::object* settings;
};

Named named(const json::value& value) {
  static const json::object kNone;
  if (value.is_string()) return {std::string(value.get_string()), &kNone};
  const json::object& of = value.is_object() ? value.get_object() : kNone;
  const json::object* settings = object_in(of, "configuration");
  return {text_in(of, "name"), settings ? settings : &kNone};
}

/// Whether "bytes" has turned numbers of this width over.
bool swapped(const ZarrArray& array, const json::object& settings, std::size_t width) {
  const std::string endian = text_in(settings, "endian");
  if (endian != "little" && endian != "big" && (!endian.empty() || width > 1)) bad(array, "the codec 'bytes' says no order of bytes; expected 'endian' little or big");
  return endian == "big" && width > 1;
}

void take_index(ZarrArray& array, ZarrShards& shards, const json::object& settings) {
  const std::string place = text_in(settings, "index_location");
  if (!place.empty() && place != "start" && place != "end") bad(array, "'index_location' is '" + place.substr(0, 20) + "'; expected start or end");
  shards.index_first = place == "start";
  const json::array* codecs = array_in(settings, "index_codecs");
  bool as_bytes = false;
  for (const json::value& codec : codecs ? *codecs : json::array{}) {
    const Named one = named(codec);
    if (one.name == "bytes" && !as_bytes) {
      shards.swap = swapped(array, *one.settings, sizeof(std::uint64_t));
      as_bytes = true;
    } else if (one.name == "crc32c" && as_bytes && !shards.sum) {
      shards.sum = true;
    } else {
      unsupported(array, "the index of its shards is packed by '" + one.name.substr(0, 60) + "'; expected bytes, then crc32c or none");
    }
  }
  if (!as_bytes) bad(array, "'index_codecs' has no 'bytes'");
}

void take_codecs(ZarrArray& array, const json::object& of) {
  const json::array* codecs = array_in(of, "codecs");
  if (!codecs || codecs->empty()) bad(array, "expected 'codecs', a list that has 'bytes'");
  bool as_bytes = false;
  for (const json::value& codec : *codecs) {
    const Named one = named(codec);
    if (one.name == "sharding_indexed") {
      if (array.shards || codecs->size() > 1) unsupported(array, array.shards ? "shards within shards; expected one level of them" : "a codec before or after 'sharding_indexed'; expected it alone, with codecs in it");
      array.shards.emplace();
      array.chunk = zarr_sizes(array, *one.settings, "chunk_shape");
      take_index(array, *array.shards, *one.settings);
      return take_codecs(array, *one.settings);
    }
    if (one.name == "transpose" && !as_bytes && !array.delta) {
      transpose(array, *one.settings);
    } else if (!as_bytes && one.name.starts_with("numcodecs.") && take_zarr_filter(array, std::string_view(one.name).substr(10), *one.settings)) {
      continue;
    } else if (one.name == "bytes" && !as_bytes) {
      array.swap = swapped(array, *one.settings, array.stored_width());
      as_bytes = true;
    } else {
      array.codecs.push_back(zarr_codec(one.name, *one.settings, array.file));
      if (!as_bytes) bad(array, "the codec '" + one.name + "' comes before 'bytes'; expected it after");
    }
  }
  if (!as_bytes) bad(array, "'codecs' has no 'bytes'");
}

/// The sizes of the chunks, or how many of them a shard has.
void take_chunks(ZarrArray& array, const json::object& settings) {
  std::vector<std::int64_t> sizes = zarr_sizes(array, settings, "chunk_shape");
  if (!array.shards) {
    array.chunk = std::move(sizes);
    return;
  }
  if (sizes.size() != array.chunk.size()) bad(array, "shards of " + std::to_string(sizes.size()) + " axes with chunks of " + std::to_string(array.chunk.size()) + "; expected as many");
  for (std::size_t a = 0; a < sizes.size(); ++a) {
    if (sizes[a] % array.chunk[a] != 0) bad(array, "shards of " + std::to_string(sizes[a]) + " points along axis " + std::to_string(a) + " do not divide into chunks of " + std::to_string(array.chunk[a]));
    array.shards->chunks.push_back(sizes[a] / array.chunk[a]);
  }
}

}  // namespace

void take_version_3(ZarrArray& array, const json::object& of) {
  array.shape = zarr_sizes(array, of, "shape");
  const json::value* type = member(of, "data_type");
  if (!type) bad(array, "expected 'data_type', such as \"uint16\"");
  const std::string type_name = named(*type).name;
  take_zarr_type(array, type_name.empty() ? shown(*type) : type_name);
  take_zarr_fill(array, member(of, "fill_value"));
  array.order.resize(array.shape.size());
  std::iota(array.order.begin(), array.order.end(), std::size_t{0});
  take_codecs(array, of);
  const auto part = [&](const char* name) {
    const json::value* found = member(of, name);
    if (!found || named(*found).name.empty()) bad(array, std::string("expected '") + name + "', an object with a name");
    return named(*found);
  };
  const Named grid = part("chunk_grid"), key = part("chunk_key_encoding");
  if (grid.name != "regular") unsupported(array, "a chunk_grid '" + grid.name.substr(0, 40) + "'; expected 'regular'");
  take_chunks(array, *grid.settings);
  const std::string &encoding = key.name, separator = text_in(*key.settings, "separator");
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
