// What the metadata of one Zarr array says: .zarray of version 2, zarr.json of version 3.
//
// "Zarr storage specification version 2" and "Zarr core specification version 3.1", zarr-specs.readthedocs.io.
#pragma once

#include <array>
#include <boost/json/value.hpp>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "data/values/array.h"
#include "import/zarr/zarr_codecs.h"
#include "import/zarr/zarr_store.h"

namespace isostrata {

/// Chunks that lie in files of several: the codec "sharding_indexed".
struct ZarrShards {
  std::vector<std::int64_t> chunks;  // [axes] of a shard, along each axis
  bool index_first = false;          // it stands at the file's start, not at its end
  bool swap = false;                 // its numbers have the other byte order
  bool sum = false;                  // its crc32c follows it
};

/// Whole numbers that stand for others: value = offset + scale * stored, as netCDF's conventions pack them, or offset + stored / scale, as the filter
/// "fixedscaleoffset" does.
struct ZarrPacking {
  double scale = 1, offset = 0;
  bool divides = false;
  std::optional<double> none{};  // the stored number that is not a value
};

struct ZarrArray {
  std::string file;                       // of its metadata, as errors call it
  std::string folder;                     // below the store's; empty, or with a slash at its end
  std::vector<std::int64_t> shape;        // [axes], each at least 1
  std::vector<std::int64_t> chunk;        // [axes] the same of each chunk; those at the end of an axis are whole, too
  std::optional<ZarrShards> shards;       // else each chunk is a file
  std::vector<std::size_t> order;         // [axes] the axes of a chunk in memory, the one that runs slowest first
  std::vector<std::string> names;         // [axes], or empty if it has none
  boost::json::object attributes;         // of its own
  ScalarType type = ScalarType::float32;  // of the values; bool is uint8
  ScalarType stored = type;               // of the chunks' numbers, unless they are halves
  bool half = false;                      // the chunks have numbers of 16-bit floating point
  bool delta = false;                     // each number of a chunk is stored as its difference to the one before
  std::optional<ZarrPacking> packing;
  bool swap = false;                      // the chunks have the other byte order
  std::array<std::byte, 8> fill{};        // one value, in the machine's byte order
  bool fill_is_none = false;              // it says that it has a fill value, which to netCDF's conventions is not a value
  std::vector<ZarrCodec> codecs;          // in the order in which they packed; one of them packs at most
  std::string key_prefix;                 // of a chunk's file: "" or "c/"
  char separator = '.';                   // between two of its numbers

  std::size_t stored_width() const { return half ? 2 : size_of(stored); }
  std::size_t chunk_bytes() const;  // of what is stored; does not overflow
  /// The file of the chunk that is number index[a] along each axis a, or of the shard that is, below the store's folder.
  std::string chunk_file(const std::vector<std::int64_t>& index) const;
};

/// Makes a gap of what stands for no value to netCDF's conventions: _FillValue, missing_value, else the fill value of version 2. Whole numbers become real ones.
void leave_out_fill(ZarrArray& array);

/// The array in a folder of the store ("" is the store's own), if there is one. Throws bad_data for metadata that makes no sense, unsupported for a type, a filter
/// or a codec that is not read, by its name.
std::optional<ZarrArray> read_zarr_array(ZarrStore& store, const std::string& folder);

}  // namespace isostrata
