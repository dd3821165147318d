#include "import/zarr/zarr_shards.h"

#include <cstring>
#include <limits>

#include "base/error.h"
#include "import/bytes/swap_bytes.h"

namespace isostrata {
namespace {

constexpr std::uint64_t kNotStored = std::numeric_limits<std::uint64_t>::max();
constexpr std::size_t kMostKept = std::size_t{4} << 20;  // entries: 64 MiB

}  // namespace

std::size_t ZarrChunkPlaces::number_in_shard(const std::vector<std::int64_t>& index) const {
  std::int64_t number = 0;
  for (std::size_t a = 0; a < index.size(); ++a) number = number * array_.shards->chunks[a] + index[a] % array_.shards->chunks[a];
  return static_cast<std::size_t>(number);
}

std::string ZarrChunkPlaces::name_of(const std::vector<std::int64_t>& index) const {
  const std::string file = store_.name_of(array_.chunk_file(index));
  return array_.shards ? file + ", chunk " + std::to_string(number_in_shard(index)) + " of the shard" : file;
}

const std::vector<ZarrChunkPlaces::Part>& ZarrChunkPlaces::index_of(const std::string& file) {
  if (const auto known = indices_.find(file); known != indices_.end()) return known->second;
  const ZarrShards& shards = *array_.shards;
  const std::string name = store_.name_of(file);
  std::size_t entries = 1;
  for (const std::int64_t chunks : shards.chunks) entries *= static_cast<std::size_t>(chunks);
  if (kept_ + entries > kMostKept) {
    indices_.clear();
    kept_ = 0;
  }
  std::vector<Part> parts;
  if (const std::optional<std::uint64_t> size = store_.size_of(file)) {
    const std::size_t bytes = entries * sizeof(Part) + (shards.sum ? 4 : 0);
    if (*size < bytes) throw Error(ErrorCode::bad_data, name + ": is cut off: has " + std::to_string(*size) + " bytes; expected an index of " + std::to_string(bytes));
    std::vector<std::byte> stored, room;
    if (!store_.read_part(file, shards.index_first ? 0 : *size - bytes, bytes, stored)) throw Error(ErrorCode::bad_data, name + ": was removed while it was read");
    const std::vector<ZarrCodec> sum(shards.sum ? 1 : 0, ZarrCodec{ZarrCodec::Kind::crc32c});
    const std::span<std::byte> index = decode_chunk(sum, stored, entries * sizeof(Part), room, name + ", the index of the shard");
    if (shards.swap) swap_bytes(index, sizeof(std::uint64_t));
    parts.resize(entries);
    std::memcpy(parts.data(), index.data(), index.size());
    std::uint64_t all = 0;
    for (const auto& [from, count] : parts) {
      if (from == kNotStored && count == kNotStored) continue;
      if (from > *size || count > *size - from)
        throw Error(ErrorCode::bad_data, name + ": is damaged or cut off: its index names " + std::to_string(count) + " bytes from " + std::to_string(from) + " on; it has " + std::to_string(*size));
      if ((all += count) > *size) throw Error(ErrorCode::bad_data, name + ": is damaged: its index names more bytes than the " + std::to_string(*size) + " that it has");
    }
  }
  kept_ += entries;
  return indices_.emplace(file, std::move(parts)).first->second;
}

std::optional<ZarrChunkPlaces::Part> ZarrChunkPlaces::part_of(const std::vector<std::int64_t>& index) {
  const std::vector<Part>& parts = index_of(array_.chunk_file(index));
  if (parts.empty()) return std::nullopt;
  const Part& part = parts[number_in_shard(index)];
  return part[1] == kNotStored ? std::nullopt : std::optional(part);
}

std::optional<std::uint64_t> ZarrChunkPlaces::size_of(const std::vector<std::int64_t>& index) {
  if (!array_.shards) return store_.size_of(array_.chunk_file(index));
  const std::optional<Part> part = part_of(index);
  return part ? std::optional((*part)[1]) : std::nullopt;
}

bool ZarrChunkPlaces::read(const std::vector<std::int64_t>& index, std::size_t most, std::vector<std::byte>& bytes) {
  if (!array_.shards) return store_.read(array_.chunk_file(index), most, bytes);
  const std::optional<Part> part = part_of(index);
  if (!part) return false;
  if ((*part)[1] > most) throw Error(ErrorCode::bad_data, name_of(index) + ": has " + std::to_string((*part)[1]) + " bytes; expected at most " + std::to_string(most));
  return store_.read_part(array_.chunk_file(index), (*part)[0], static_cast<std::size_t>((*part)[1]), bytes);
}

}  // namespace isostrata
