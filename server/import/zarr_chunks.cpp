#include "import/zarr_chunks.h"

#include <algorithm>
#include <cstring>

#include "import/imported.h"
#include "import/memory_limit.h"

namespace isostrata {
namespace {

using Four = std::array<std::int64_t, 4>;  // x, y, z, channel

/// Values of one chunk, or one value for all of them, to their places.
struct Copy {
  const std::byte* from;
  Four from_step;  // in values
  Four first, last;  // in the box
  Four box;
};

template <std::size_t width>
void copy_values(const Copy& of, std::span<const std::span<std::byte>> out) {
  const auto length = static_cast<std::size_t>(of.last[0] - of.first[0]);
  for (std::int64_t c = of.first[3]; c < of.last[3]; ++c)
    for (std::int64_t z = of.first[2]; z < of.last[2]; ++z)
      for (std::int64_t y = of.first[1]; y < of.last[1]; ++y) {
        const std::byte* from = of.from + ((c - of.first[3]) * of.from_step[3] + (z - of.first[2]) * of.from_step[2] + (y - of.first[1]) * of.from_step[1]) *
                                              static_cast<std::int64_t>(width);
        std::byte* to = out[static_cast<std::size_t>(c)].data() + static_cast<std::size_t>(of.first[0] + of.box[0] * (y + of.box[1] * z)) * width;
        if (of.from_step[0] == 1) {
          std::memcpy(to, from, length * width);
          continue;
        }
        const std::int64_t step = of.from_step[0] * static_cast<std::int64_t>(width);
        for (std::size_t i = 0; i < length; ++i, to += width, from += step) std::memcpy(to, from, width);
      }
}

void copy_values(const Copy& of, std::size_t width, std::span<const std::span<std::byte>> out) {
  switch (width) {
    case 1: return copy_values<1>(of, out);
    case 2: return copy_values<2>(of, out);
    case 4: return copy_values<4>(of, out);
    default: return copy_values<8>(of, out);
  }
}

template <class T>
void swap_values(std::span<std::byte> bytes) {
  for (std::size_t at = 0; at < bytes.size(); at += sizeof(T)) {
    T word;
    std::memcpy(&word, bytes.data() + at, sizeof word);
    if constexpr (sizeof(T) == 2) word = __builtin_bswap16(word);
    if constexpr (sizeof(T) == 4) word = __builtin_bswap32(word);
    if constexpr (sizeof(T) == 8) word = __builtin_bswap64(word);
    std::memcpy(bytes.data() + at, &word, sizeof word);
  }
}

void swap_values(std::span<std::byte> bytes, std::size_t width) {
  if (width == 2) return swap_values<std::uint16_t>(bytes);
  if (width == 4) return swap_values<std::uint32_t>(bytes);
  swap_values<std::uint64_t>(bytes);
}

/// Values between neighbours along each axis of a chunk, and along the box's.
std::vector<std::int64_t> steps_of(const ZarrArray& array) {
  std::vector<std::int64_t> steps(array.shape.size(), 1);
  std::int64_t step = 1;
  for (std::size_t o = array.order.size(); o-- > 0;) {
    steps[array.order[o]] = step;
    step *= array.chunk[array.order[o]];
  }
  return steps;
}

}  // namespace

ZarrCount read_zarr_box(ZarrStore& store, const ZarrArray& array, const ZarrBox& box, std::span<const std::span<std::byte>> out,
                        const std::function<void(double fraction)>& progress) {
  const std::size_t width = size_of(array.type), bytes = array.chunk_bytes(), most_stored = 2 * bytes + (std::size_t{1} << 20);
  const std::vector<std::int64_t> steps = steps_of(array);
  std::vector<std::int64_t> index(array.shape.size());  // of a chunk
  std::int64_t before = 0;                               // values of a chunk before the place on every other axis
  for (std::size_t a = 0; a < index.size(); ++a) {
    index[a] = box.at[a] / array.chunk[a];
    before += box.at[a] % array.chunk[a] * steps[a];
  }
  Four size{1, 1, 1, 1}, count{1, 1, 1, 1}, chunk_step{};
  ZarrCount counted{.chunks = 1};
  for (std::size_t b = 0; b < 4; ++b) {
    const std::size_t axis = box.axes[b];
    if (axis == ZarrBox::kNone) continue;
    size[b] = array.chunk[axis];
    count[b] = (box.size[b] - 1) / size[b] + 1;
    chunk_step[b] = steps[axis];
    counted.chunks = checked_product({counted.chunks, count[b]}, array.file);
  }
  constexpr std::int64_t kMostChunks = 10'000'000;
  if (counted.chunks > kMostChunks) throw Error(ErrorCode::too_large, array.file + ": " + std::to_string(counted.chunks) + " chunks; expected at most " + std::to_string(kMostChunks));

  const auto to_place = [&](std::int64_t n) {  // of a chunk; from the fill value, until it says otherwise
    Copy copy{.from = array.fill.data(), .from_step = {}, .first = {}, .last = {}, .box = box.size};
    std::int64_t rest = n;
    for (std::size_t b = 0; b < 4; ++b) {
      const std::int64_t at = rest % count[b];
      rest /= count[b];
      copy.first[b] = at * size[b];
      copy.last[b] = std::min(box.size[b], copy.first[b] + size[b]);
      if (box.axes[b] != ZarrBox::kNone) index[box.axes[b]] = at;
    }
    return copy;
  };
  std::vector<std::byte> stored, unpacked;
  std::vector<std::int64_t> missing;
  std::uint64_t stored_bytes = 0;
  for (std::int64_t n = 0; n < counted.chunks; ++n) {
    Copy copy = to_place(n);
    const std::string file = array.chunk_file(index);
    progress(static_cast<double>(n) / static_cast<double>(counted.chunks));
    if (!store.read(file, most_stored, stored)) {
      missing.push_back(n);
      continue;
    }
    stored_bytes += stored.size();
    const std::span<std::byte> values = decode_chunk(array.codecs, stored, bytes, unpacked, store.name_of(file));
    if (array.swap) swap_values(values, width);
    copy.from = values.data() + static_cast<std::size_t>(before) * width;
    copy.from_step = chunk_step;
    copy_values(copy, width, out);
  }
  // Only now is memory taken for what is in no file.
  counted.missing = static_cast<std::int64_t>(missing.size());
  const double filled = static_cast<double>(counted.missing) / static_cast<double>(counted.chunks) * static_cast<double>(out.size() * out.front().size());
  if (filled > static_cast<double>(unpacked_bytes(stored_bytes)))
    throw Error(ErrorCode::too_large, array.file + ": " + std::to_string(counted.missing) + " of " + std::to_string(counted.chunks) + " chunks are not there, and the others have " +
                                          std::to_string(stored_bytes) + " bytes; expected more, for an array of " + std::to_string(out.size() * out.front().size()));
  for (const std::int64_t n : missing) copy_values(to_place(n), width, out);
  return counted;
}

}  // namespace isostrata
