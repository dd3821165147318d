#include "import/zarr/zarr_array.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <string_view>
#include <type_traits>

#include "import/imported/imported.h"
#include "import/zarr/zarr_json.h"
#include "import/zarr/zarr_metadata.h"
#include "import/zarr/zarr_values.h"

namespace isostrata {
namespace {

namespace json = boost::json;

constexpr std::int64_t kMostInShard = 4'000'000;

void check_together(const ZarrArray& array, std::size_t width) {
  if (array.chunk.size() != array.shape.size())
    bad(array, std::to_string(array.shape.size()) + " axes with chunks of " + std::to_string(array.chunk.size()) + "; expected as many");
  std::int64_t points = 1, bytes = static_cast<std::int64_t>(width);
  for (std::size_t a = 0; a < array.shape.size(); ++a) {
    points = checked_product({points, array.shape[a]}, array.file);
    bytes = checked_product({bytes, array.chunk[a]}, array.file);
  }
  if (array.shards) {
    std::int64_t entries = 1;
    for (const std::int64_t chunks : array.shards->chunks) entries = checked_product({entries, chunks}, array.file);
    if (entries > kMostInShard) unsupported(array, "shards of " + std::to_string(entries) + " chunks; expected at most " + std::to_string(kMostInShard));
  }
  if (std::count_if(array.codecs.begin(), array.codecs.end(), [](const ZarrCodec& codec) { return codec.packs(); }) > 1)
    unsupported(array, "its chunks are packed twice; expected one of blosc, zstd, gzip, lz4 or bz2");
}

/// xarray's names of the axes.
void take_names(ZarrArray& array, const json::object& attributes) {
  const json::array* names = array_in(attributes, "_ARRAY_DIMENSIONS");
  if (names && names->size() == array.shape.size())
    for (const json::value& name : *names) array.names.emplace_back(name.is_string() ? std::string(name.get_string()) : std::string());
}

/// A number of the attribute, or one of 8 bytes in base64, as xarray writes the fill value of real numbers in version 3.
std::optional<double> zarr_number(const json::object& attributes, const char* name) {
  const json::value* value = member(attributes, name);
  if (!value) return std::nullopt;
  if (value->is_number()) return value->to_number<double>();
  if (!value->is_string()) return std::nullopt;
  constexpr std::string_view kLetters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  const std::string_view text(value->get_string());
  if (text == "NaN") return std::nan("");
  if (text.size() != 12 || text.back() != '=') return std::nullopt;
  std::uint64_t bits = 0, eleven = 0;
  for (const char letter : text.substr(0, 11)) {
    const auto at = kLetters.find(letter);
    if (at == std::string_view::npos) return std::nullopt;
    if (++eleven < 11) bits = bits << 6 | at;
    else bits = bits << 4 | at >> 2;
  }
  return std::bit_cast<double>(__builtin_bswap64(bits));
}

double stored_fill(const ZarrArray& array) {
  return std::visit(
      [&](auto of) {
        std::remove_const_t<typename decltype(of)::value_type> fill{};
        std::memcpy(&fill, array.fill.data(), sizeof fill);
        return static_cast<double>(fill);
      },
      scalar_span(array.stored, {}));
}

void pack(ZarrArray& array, const ZarrPacking& packing) {
  array.packing = packing;
  if (array.stored != ScalarType::float32 && array.stored != ScalarType::float64) array.type = size_of(array.stored) <= 2 ? ScalarType::float32 : ScalarType::float64;
  std::vector<std::byte> fill(array.fill.begin(), array.fill.begin() + static_cast<std::ptrdiff_t>(size_of(array.stored))), room;
  ZarrArray plain = array;
  plain.swap = plain.delta = false;
  const std::span<const std::byte> value = zarr_values(plain, fill, room);
  std::copy(value.begin(), value.end(), array.fill.begin());
}

/// The attributes of netCDF's conventions, as xarray writes them. In version 2 the fill value is what stands for no value.
void take_packing(ZarrArray& array) {
  const std::optional<double> scale = zarr_number(array.attributes, "scale_factor"), offset = zarr_number(array.attributes, "add_offset");
  const bool real = array.half || array.stored == ScalarType::float32 || array.stored == ScalarType::float64;
  if (real || array.packing || (!scale && !offset)) return;
  ZarrPacking packing{scale.value_or(1), offset.value_or(0), false, zarr_number(array.attributes, "_FillValue")};
  if (!packing.none && array.fill_is_none) packing.none = stored_fill(array);
  pack(array, packing);
}

}  // namespace

std::size_t ZarrArray::chunk_bytes() const {
  std::size_t bytes = stored_width();
  for (const std::int64_t size : chunk) bytes *= static_cast<std::size_t>(size);
  return bytes;
}

std::string ZarrArray::chunk_file(const std::vector<std::int64_t>& index) const {
  std::string file = folder + key_prefix;
  for (std::size_t a = 0; a < index.size(); ++a) {
    if (a > 0) file += separator;
    file += std::to_string(shards ? index[a] / shards->chunks[a] : index[a]);
  }
  return file;
}

void leave_out_fill(ZarrArray& array) {
  if (array.half || array.packing) return;
  std::optional<double> none = zarr_number(array.attributes, "_FillValue");
  if (!none) none = zarr_number(array.attributes, "missing_value");
  if (!none && array.fill_is_none) none = stored_fill(array);
  if (none && array.stored == ScalarType::float32) none = static_cast<double>(static_cast<float>(*none));
  if (none && !std::isnan(*none)) pack(array, {1, 0, false, none});
}

std::optional<ZarrArray> read_zarr_array(ZarrStore& store, const std::string& folder) {
  ZarrArray array;
  array.folder = folder.empty() ? folder : folder + "/";
  if (const auto of = store.read_json(array.folder + ".zarray")) {
    array.file = store.name_of(array.folder + ".zarray");
    take_version_2(array, *of);
    array.attributes = store.read_json(array.folder + ".zattrs").value_or(json::object());
    take_names(array, array.attributes);
    array.fill_is_none = member(*of, "fill_value");
    take_packing(array);
  } else if (const auto node = store.read_json(array.folder + "zarr.json"); node && text_in(*node, "node_type") == "array") {
    array.file = store.name_of(array.folder + "zarr.json");
    take_version_3(array, *node);
    if (const json::object* attributes = object_in(*node, "attributes")) array.attributes = *attributes;
    take_packing(array);
  } else {
    return std::nullopt;
  }
  check_together(array, std::max(array.stored_width(), size_of(array.type)));
  return array;
}

}  // namespace isostrata
