// Where the bytes of each chunk of a Zarr array lie: in a file of its own, or in a part of a shard.
//
// "Sharding codec (version 1.0)", zarr-specs.readthedocs.io: an index of two 64-bit numbers for each chunk of the shard, the first byte and how many, stands at
// the file's start or end; both are 2^64-1 for a chunk that is not there.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "import/zarr/zarr_array.h"
#include "import/zarr/zarr_store.h"

namespace isostrata {

class ZarrChunkPlaces {
 public:
  /// Both outlive it.
  ZarrChunkPlaces(ZarrStore& store, const ZarrArray& array) : store_(store), array_(array) {}

  /// What errors call the chunk that is number index[a] along each axis a.
  std::string name_of(const std::vector<std::int64_t>& index) const;

  /// Reads what is stored of it into `bytes`; false if it is not there. Throws bad_data above `most` bytes, and for a shard that is cut off or whose index is
  /// damaged: it names bytes that the file has not, or all in all more of them.
  bool read(const std::vector<std::int64_t>& index, std::size_t most, std::vector<std::byte>& bytes);

  /// Bytes that are stored of it; nothing if it is not there. Reads an index, but no chunk.
  std::optional<std::uint64_t> size_of(const std::vector<std::int64_t>& index);

 private:
  using Part = std::array<std::uint64_t, 2>;  // the first byte, and how many
  std::optional<Part> part_of(const std::vector<std::int64_t>& index);
  /// None if there is no such file; one for each chunk of it, C order.
  const std::vector<Part>& index_of(const std::string& file);
  std::size_t number_in_shard(const std::vector<std::int64_t>& index) const;

  ZarrStore& store_;
  const ZarrArray& array_;
  std::map<std::string, std::vector<Part>> indices_;  // of the shards that were met last: they are met again along the next row
  std::size_t kept_ = 0;                              // entries of all of them
};

}  // namespace isostrata
