#include "import/zarr_array.h"

#include <algorithm>

#include "import/imported.h"
#include "import/zarr_json.h"
#include "import/zarr_metadata.h"

namespace isostrata {
namespace {

namespace json = boost::json;

void check_together(const ZarrArray& array, std::size_t width) {
  if (array.chunk.size() != array.shape.size())
    bad(array, std::to_string(array.shape.size()) + " axes with chunks of " + std::to_string(array.chunk.size()) + "; expected as many");
  std::int64_t points = 1, bytes = static_cast<std::int64_t>(width);
  for (std::size_t a = 0; a < array.shape.size(); ++a) {
    points = checked_product({points, array.shape[a]}, array.file);
    bytes = checked_product({bytes, array.chunk[a]}, array.file);
  }
  if (std::count_if(array.codecs.begin(), array.codecs.end(), [](ZarrCodec codec) { return codec != ZarrCodec::crc32c; }) > 1)
    unsupported(array, "its chunks are packed twice; expected one of blosc, zstd, gzip, lz4 or bz2");
}

/// xarray's names of the axes.
void take_names(ZarrArray& array, ZarrStore& store) {
  const std::optional<json::object> attributes = store.read_json(array.folder + ".zattrs");
  const json::array* names = attributes ? array_in(*attributes, "_ARRAY_DIMENSIONS") : nullptr;
  if (names && names->size() == array.shape.size())
    for (const json::value& name : *names) array.names.emplace_back(name.is_string() ? std::string(name.get_string()) : std::string());
}

}  // namespace

std::size_t ZarrArray::chunk_bytes() const {
  std::size_t bytes = size_of(type);
  for (const std::int64_t size : chunk) bytes *= static_cast<std::size_t>(size);
  return bytes;
}

std::string ZarrArray::chunk_file(const std::vector<std::int64_t>& index) const {
  std::string file = folder + key_prefix;
  for (std::size_t a = 0; a < index.size(); ++a) {
    if (a > 0) file += separator;
    file += std::to_string(index[a]);
  }
  return file;
}

std::optional<ZarrArray> read_zarr_array(ZarrStore& store, const std::string& folder) {
  ZarrArray array;
  array.folder = folder.empty() ? folder : folder + "/";
  if (const auto of = store.read_json(array.folder + ".zarray")) {
    array.file = store.name_of(array.folder + ".zarray");
    take_version_2(array, *of);
    take_names(array, store);
  } else if (const auto node = store.read_json(array.folder + "zarr.json"); node && text_in(*node, "node_type") == "array") {
    array.file = store.name_of(array.folder + "zarr.json");
    take_version_3(array, *node);
  } else {
    return std::nullopt;
  }
  check_together(array, size_of(array.type));
  return array;
}

}  // namespace isostrata
