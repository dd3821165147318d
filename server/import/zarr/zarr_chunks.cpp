#include "import/zarr/zarr_chunks.h"

#include <algorithm>
#include <cstring>
#include <optional>

#include "import/imported/imported.h"
#include "import/limits/memory_limit.h"
#include "import/zarr/zarr_shards.h"
#include "import/zarr/zarr_values.h"

namespace isostrata {
namespace {

using Four = std::array<std::int64_t, 4>;  // x, y, z, channel

/// Values of one chunk, or one value for all of them, to their places in a layer of chunks.
struct Copy {
  const std::byte* from;
  Four from_step;    // in values
  Four first, last;  // in the box
  std::byte* to;     // the first place of the layer
  Four to_step;
};

template <std::size_t width>
void copy_values(const Copy& of) {
  const auto length = static_cast<std::size_t>(of.last[0] - of.first[0]);
  const std::int64_t step = of.from_step[0] * static_cast<std::int64_t>(width);
  for (std::int64_t c = 0; c < of.last[3] - of.first[3]; ++c)
    for (std::int64_t z = 0; z < of.last[2] - of.first[2]; ++z)
      for (std::int64_t y = 0; y < of.last[1] - of.first[1]; ++y) {
        const std::byte* from = of.from + (c * of.from_step[3] + z * of.from_step[2] + y * of.from_step[1]) * static_cast<std::int64_t>(width);
        std::byte* to = of.to + (c * of.to_step[3] + z * of.to_step[2] + (of.first[1] + y) * of.to_step[1] + of.first[0]) * static_cast<std::int64_t>(width);
        if (of.from_step[0] == 1) {
          std::memcpy(to, from, length * width);
          continue;
        }
        for (std::size_t i = 0; i < length; ++i, to += width, from += step) std::memcpy(to, from, width);
      }
}

void copy_values(const Copy& of, std::size_t width) {
  switch (width) {
    case 1: return copy_values<1>(of);
    case 2: return copy_values<2>(of);
    case 4: return copy_values<4>(of);
    default: return copy_values<8>(of);
  }
}

/// The chunks that a box meets, numbered along x, then y, z and the channels. Those of one z and one channel are a layer.
class Chunks {
 public:
  Chunks(const ZarrArray& array, const ZarrBox& box) : array_(array), box_(box), index_(array.shape.size()) {
    std::vector<std::int64_t> steps(array.shape.size());
    std::int64_t step = 1;
    for (std::size_t o = array.order.size(); o-- > 0; step *= array.chunk[array.order[o]]) steps[array.order[o]] = step;
    for (std::size_t a = 0; a < index_.size(); ++a) {
      index_[a] = box.at[a] / array.chunk[a];
      before_ += box.at[a] % array.chunk[a] * steps[a];
    }
    for (std::size_t b = 0; b < 4; ++b) {
      const std::size_t axis = box.axes[b];
      if (axis == ZarrBox::kNone) continue;
      size_[b] = array.chunk[axis];
      count_[b] = (box.size[b] - 1) / size_[b] + 1;
      step_[b] = steps[axis];
    }
    all_ = checked_product({count_[0], count_[1], count_[2], count_[3]}, array.file);
    constexpr std::int64_t kMost = 10'000'000;
    if (all_ > kMost) throw Error(ErrorCode::too_large, array.file + ": " + std::to_string(all_) + " chunks; expected at most " + std::to_string(kMost));
  }

  std::int64_t count() const { return all_; }
  std::int64_t layers() const { return count_[2] * count_[3]; }
  std::int64_t in_layer() const { return count_[0] * count_[1]; }
  /// Values of a chunk, in values, along the box's axes, and those before the place on every other axis.
  const Four& steps() const { return step_; }
  std::size_t before() const { return static_cast<std::size_t>(before_); }

  /// Goes to one of them.
  void go(std::int64_t n) {
    for (std::size_t b = 0; b < 4; ++b, n /= count_[b - 1]) {
      const std::int64_t at = n % count_[b];
      first[b] = at * size_[b];
      last[b] = std::min(box_.size[b], first[b] + size_[b]);
      if (box_.axes[b] != ZarrBox::kNone) index_[box_.axes[b]] = at;
    }
  }
  Four first{}, last{};  // of the chunk, in the box
  const std::vector<std::int64_t>& index() const { return index_; }

 private:
  const ZarrArray& array_;
  const ZarrBox& box_;
  std::vector<std::int64_t> index_;
  Four size_{1, 1, 1, 1}, count_{1, 1, 1, 1}, step_{};
  std::int64_t before_ = 0, all_ = 1;
};

/// A folder that has next to nothing in it may not fill a disk. What any folder may take is not looked at.
void check_missing(ZarrChunkPlaces& places, const ZarrArray& array, Chunks& chunks, std::uint64_t bytes) {
  if (bytes <= unpacked_bytes(0)) return;
  std::uint64_t stored = 0;
  std::int64_t missing = 0;
  for (std::int64_t n = 0; n < chunks.count(); ++n) {
    chunks.go(n);
    const std::optional<std::uint64_t> size = places.size_of(chunks.index());
    stored += size.value_or(0);
    missing += !size;
  }
  const double filled = static_cast<double>(missing) / static_cast<double>(chunks.count()) * static_cast<double>(bytes);
  if (filled > static_cast<double>(unpacked_bytes(stored)))
    throw Error(ErrorCode::too_large, array.file + ": " + std::to_string(missing) + " of " + std::to_string(chunks.count()) + " chunks are not there, and the others have " +
                                          std::to_string(stored) + " bytes; expected more, for " + std::to_string(bytes) + " bytes of values");
}

}  // namespace

ZarrCount read_zarr_box(ZarrStore& store, const ZarrArray& array, const ZarrBox& box, const AddValues& add, const std::function<void(double fraction)>& progress) {
  const std::size_t width = size_of(array.type), bytes = array.chunk_bytes(), most_stored = 2 * bytes + (std::size_t{1} << 20);
  Chunks chunks(array, box);
  ZarrChunkPlaces places(store, array);
  check_missing(places, array, chunks, static_cast<std::uint64_t>(checked_product({box.size[0], box.size[1], box.size[2], box.size[3], static_cast<std::int64_t>(width)}, array.file)));
  ZarrCount counted{.chunks = chunks.count()};
  std::vector<std::byte> stored, unpacked, wider, layer;
  for (std::int64_t l = 0, n = 0; l < chunks.layers(); ++l) {
    chunks.go(n);
    const std::int64_t channel = chunks.first[3], channels = chunks.last[3] - channel, area = box.size[0] * box.size[1];
    const Four to_step{1, box.size[0], area, area * (chunks.last[2] - chunks.first[2])};
    const std::size_t of_channel = static_cast<std::size_t>(to_step[3]) * width;
    layer.resize(of_channel * static_cast<std::size_t>(channels));
    for (const std::int64_t end = n + chunks.in_layer(); n < end; ++n) {
      chunks.go(n);
      Copy copy{array.fill.data(), {}, chunks.first, chunks.last, layer.data(), to_step};
      if (places.read(chunks.index(), most_stored, stored)) {
        const std::span<const std::byte> values = zarr_values(array, decode_chunk(array.codecs, stored, bytes, unpacked, places.name_of(chunks.index())), wider);
        copy.from = values.data() + chunks.before() * width;
        copy.from_step = chunks.steps();
      } else {
        ++counted.missing;
      }
      copy_values(copy, width);
      progress(static_cast<double>(n + 1) / static_cast<double>(counted.chunks));
    }
    for (std::int64_t c = 0; c < channels; ++c)
      add(static_cast<std::size_t>(channel + c), std::span<const std::byte>(layer).subspan(static_cast<std::size_t>(c) * of_channel, of_channel));
  }
  return counted;
}

}  // namespace isostrata
