#include <zlib.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <utility>

#include "import/bytes/swap_bytes.h"
#include "import/imported/place_image.h"
#include "import/imported/read_own.h"

namespace isostrata {
namespace {

constexpr std::size_t kHeader = 284;
constexpr std::int64_t kMostFrames = 1'000'000;

using Packed = std::unique_ptr<gzFile_s, int (*)(gzFile)>;

/// A number at a place of the header, which is big-endian.
template <class T>
T number_at(const std::array<std::byte, kHeader>& header, std::size_t at) {
  std::array<std::byte, sizeof(T)> bytes{};
  std::copy_n(header.begin() + static_cast<std::ptrdiff_t>(at), sizeof(T), bytes.begin());
  if constexpr (std::endian::native == std::endian::little) std::reverse(bytes.begin(), bytes.end());
  return std::bit_cast<T>(bytes);
}

void read_all(gzFile file, std::span<std::byte> to, const std::string& name) {
  constexpr std::size_t kAtOnce = 1 << 20;
  for (std::size_t at = 0; at < to.size();) {
    const int got = gzread(file, to.data() + at, static_cast<unsigned>(std::min(kAtOnce, to.size() - at)));
    if (got <= 0) throw Error(ErrorCode::bad_data, name + ": is damaged, or cut off: " + std::to_string(to.size()) + " bytes expected, " + std::to_string(at) + " present");
    at += static_cast<std::size_t>(got);
  }
}

ScalarType type_of(std::int32_t code, const std::string& name) {
  switch (code) {
    case 0: return ScalarType::uint8;
    case 1: return ScalarType::int32;
    case 3: return ScalarType::float32;
    case 4: return ScalarType::int16;
    case 10: return ScalarType::uint16;
    default: throw Error(ErrorCode::unsupported, name + ": numbers of type " + std::to_string(code) + "; expected 0, 1, 3, 4 or 10 (bytes, whole numbers of 32 bits, real ones, whole ones of 16 bits)");
  }
}

/// Where the points are: the directions of the axes, how far points are apart, and the middle of the volume, in mm to the right, to the front and up.
void place(Block& block, const std::array<std::byte, kHeader>& header, const std::array<std::int64_t, 3>& dims, Imported& imported, const std::string& name) {
  std::array<std::array<double, 3>, 3> step{{{-1, 0, 0}, {0, 0, -1}, {0, 1, 0}}};
  std::array<double, 3> origin{};
  const bool placed = number_at<std::int16_t>(header, 28) > 0;
  for (std::size_t a = 0; placed && a < 3; ++a)
    for (std::size_t c = 0; c < 3; ++c)
      step[a][c] = static_cast<double>(number_at<float>(header, 42 + 4 * (3 * a + c))) * static_cast<double>(number_at<float>(header, 30 + 4 * a));
  for (std::size_t c = 0; c < 3; ++c) {
    origin[c] = placed ? static_cast<double>(number_at<float>(header, 78 + 4 * c)) : 0;
    for (std::size_t a = 0; a < 3; ++a) origin[c] -= step[a][c] * static_cast<double>(dims[a]) / 2;
  }
  place_image(block, dims, origin, step, name);
  imported.notes.emplace_back(placed ? "placed by its header: x to the right, y to the front, z up" : "its header says no place: points 1 apart, as FreeSurfer takes them");
  imported.axes = axes_in("mm");
}

}  // namespace

// FreeSurfer's MGH, as its documents have it: version 1, four sizes, the type, whether it is placed, sizes and directions of the axes, the middle; from byte 284 on the values, big-endian, x fastest,
// one frame after the other. MGZ is the same within gzip.
Imported read_mgh(const ReadRequest& request) {
  const std::string name = request.file.filename().string();
  const Packed file(gzopen(request.file.c_str(), "rb"), gzclose);
  if (!file) throw Error(ErrorCode::unavailable, name + ": cannot be opened for reading");
  std::array<std::byte, kHeader> header{};
  read_all(file.get(), header, name);
  if (number_at<std::int32_t>(header, 0) != 1) throw Error(ErrorCode::bad_data, name + ": expected version 1 at its start, as FreeSurfer's volumes have it");
  std::array<std::int64_t, 4> sizes{};
  for (std::size_t a = 0; a < 4; ++a) {
    sizes[a] = number_at<std::int32_t>(header, 4 + 4 * a);
    if (sizes[a] < 1) throw Error(ErrorCode::bad_data, name + ": a size of " + std::to_string(sizes[a]) + "; expected at least 1");
  }
  if (sizes[3] > kMostFrames) throw Error(ErrorCode::too_large, name + ": has " + std::to_string(sizes[3]) + " frames; expected at most " + std::to_string(kMostFrames));
  const ScalarType type = type_of(number_at<std::int32_t>(header, 20), name);
  const std::array<std::int64_t, 3> dims{sizes[0], sizes[1], sizes[2]};
  const std::int64_t points = checked_product({dims[0], dims[1], dims[2]}, name);
  const std::int64_t bytes = checked_product({points, static_cast<std::int64_t>(size_of(type)), sizes[3]}, name) / sizes[3];
  check_bytes(request, static_cast<std::uint64_t>(bytes), name);
  check_step(request, static_cast<std::size_t>(sizes[3]));
  Imported imported;
  imported.times.clear();
  for (std::int64_t frame = 0; frame < sizes[3]; ++frame) imported.times.push_back(static_cast<double>(frame));
  if (request.times_only) return imported;

  Block block;
  place(block, header, dims, imported, name);
  auto [storage, values] = allocate<std::byte>(static_cast<std::size_t>(bytes));
  for (int frame = 0; frame <= request.step; ++frame) read_all(file.get(), values, name);
  if constexpr (std::endian::native == std::endian::little) swap_bytes(values, size_of(type));
  FileArray array;
  array.name = "intensity";
  array.type = type;
  array.values = values;
  array.storage = storage;
  block.arrays.push_back(std::move(array));
  imported.blocks.push_back(std::move(block));
  return imported;
}

}  // namespace isostrata
