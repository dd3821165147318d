// MRC and CCP4: density maps of electron microscopy and crystallography.
//
// "MRC2014", Cheng et al., Journal of Structural Biology 192 (2015); www.ccpem.ac.uk/mrc_format/mrc2014.php.
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <numbers>

#include "import/bytes/half_number.h"
#include "import/bytes/mapped_file.h"
#include "import/bytes/swap_bytes.h"
#include "import/imported/place_image.h"
#include "import/imported/read_own.h"

namespace isostrata {
namespace {

constexpr std::size_t kMrcHeader = 1024;

/// The words of the header, counted from 1 as its description does.
class MrcHeader {
 public:
  MrcHeader(std::span<const std::byte> file, const std::string& name) {
    if (file.size() < kMrcHeader) throw Error(ErrorCode::bad_data, name + ": ends within its header");
    std::memcpy(words_.data(), file.data(), kMrcHeader);
    const std::byte stamp = file[212];  // of the machine; older files have none, but small sizes
    const bool odd = whole(1) < 0 || whole(1) > 0xffffff || whole(4) < 0 || whole(4) > 0xffff;
    swap = stamp == std::byte{0x11} || (stamp != std::byte{0x44} && odd);
    if (swap) swap_bytes(std::as_writable_bytes(std::span(words_)), 4);
  }
  std::int32_t whole(std::size_t n) const { return words_[n - 1]; }
  double real(std::size_t n) const { return std::bit_cast<float>(words_[n - 1]); }
  bool swap = false;

 private:
  std::array<std::int32_t, kMrcHeader / 4> words_{};
};

struct MrcType {
  ScalarType type = ScalarType::float32;
  bool half = false;
  std::size_t width() const { return half ? 2 : size_of(type); }
};

MrcType type_of(const MrcHeader& header, const std::string& name) {
  switch (header.whole(4)) {
    case 0: {
      const bool imod = header.whole(39) == 1146047817;  // IMOD's mark: the lowest bit of the word behind it says that bytes have a sign
      return {imod && !(header.whole(40) & 1) ? ScalarType::uint8 : ScalarType::int8};
    }
    case 1: return {ScalarType::int16};
    case 2: return {ScalarType::float32};
    case 6: return {ScalarType::uint16};
    case 12: return {ScalarType::float32, true};
    default: throw Error(ErrorCode::unsupported, name + ": MRC of mode " + std::to_string(header.whole(4)) + "; expected 0, 1, 2, 6 or 12, numbers of 1, 2 or 4 bytes");
  }
}

/// One step along each axis of the cell: the first runs along x, the second lies in the plane of x and y.
std::array<std::array<double, 3>, 3> cell_steps(const MrcHeader& header) {
  std::array<double, 3> length{}, cosine{};
  bool angled = false;
  for (std::size_t a = 0; a < 3; ++a) {
    const int parts = header.whole(8 + a);
    length[a] = parts > 0 && header.real(11 + a) > 0 ? header.real(11 + a) / parts : 1;
    const double angle = header.real(14 + a);
    const bool oblique = angle > 0 && angle < 180 && angle != 90;
    angled = angled || oblique;
    cosine[a] = oblique ? std::cos(angle * std::numbers::pi / 180) : 0;
  }
  if (!angled) return {{{length[0], 0, 0}, {0, length[1], 0}, {0, 0, length[2]}}};
  const double sine = std::sqrt(1 - cosine[2] * cosine[2]), across = (cosine[0] - cosine[1] * cosine[2]) / sine;
  const double up = std::sqrt(std::max(1 - cosine[1] * cosine[1] - across * across, 0.0));
  return {{{length[0], 0, 0}, {length[1] * cosine[2], length[1] * sine, 0}, {length[2] * cosine[1], length[2] * across, length[2] * up}}};
}

void place(Block& block, const MrcHeader& header, const std::array<std::int64_t, 3>& dims, const std::string& name) {
  std::array<std::size_t, 3> axis{0, 1, 2};
  if (const std::array<std::int32_t, 3> said{header.whole(17), header.whole(18), header.whole(19)}; said != std::array{0, 0, 0}) {
    bool seen[3]{};
    for (std::size_t i = 0; i < 3; ++i) {
      if (said[i] < 1 || said[i] > 3 || seen[said[i] - 1]) throw Error(ErrorCode::bad_data, name + ": its header numbers the axes " + std::to_string(said[0]) + ", " + std::to_string(said[1]) + ", " + std::to_string(said[2]) + "; expected 1, 2 and 3");
      seen[said[i] - 1] = true;
      axis[i] = static_cast<std::size_t>(said[i] - 1);
    }
  }
  const auto steps = cell_steps(header);
  std::array<std::array<double, 3>, 3> step{};
  std::array<double, 3> origin{header.real(50), header.real(51), header.real(52)};
  const bool said = origin != std::array<double, 3>{0, 0, 0};
  for (std::size_t i = 0; i < 3; ++i) {
    step[i] = steps[axis[i]];
    for (std::size_t a = 0; a < 3 && !said; ++a) origin[a] += header.whole(5 + i) * step[i][a];
  }
  place_image(block, dims, origin, step, name);
}

}  // namespace

Imported read_mrc(const ReadRequest& request) {
  const std::string name = request.file.filename().string();
  const auto file = std::make_shared<const MappedFile>(request.file);
  const MrcHeader header(file->bytes(), name);
  const MrcType of = type_of(header, name);
  std::array<std::int64_t, 3> dims{header.whole(1), header.whole(2), header.whole(3)};
  const std::int32_t group = header.whole(23), sheets = header.whole(10), more = header.whole(24);
  if (dims[0] < 1 || dims[1] < 1 || dims[2] < 1 || more < 0) throw Error(ErrorCode::bad_data, name + ": its header has a size below 1");
  Imported imported;
  if (group >= 401 && group <= 630 && sheets > 0 && dims[2] % sheets == 0) {  // volumes, one after the other
    imported.times.resize(static_cast<std::size_t>(dims[2] / sheets));
    for (std::size_t t = 0; t < imported.times.size(); ++t) imported.times[t] = static_cast<double>(t);
    dims[2] = sheets;
  }
  check_step(request, imported.times.size());
  const std::int64_t points = checked_product({dims[0], dims[1], dims[2]}, name);
  const auto bytes = static_cast<std::size_t>(checked_product({points, static_cast<std::int64_t>(of.width())}, name));
  const std::size_t begin = kMrcHeader + static_cast<std::size_t>(more), present = file->bytes().size() - std::min(begin, file->bytes().size());
  if (bytes > present / imported.times.size())
    throw Error(ErrorCode::bad_data, name + ": " + std::to_string(bytes) + " bytes of numbers declared" + (imported.times.size() > 1 ? " for each of " + std::to_string(imported.times.size()) + " volumes" : "") + ", " +
                                         std::to_string(present) + " present");
  if (request.times_only) return imported;
  Block& block = imported.blocks.emplace_back();
  place(block, header, dims, name);
  FileArray& array = block.arrays.emplace_back();
  array.name = "density";
  array.type = of.type;
  const std::size_t first = begin + bytes * static_cast<std::size_t>(request.step);
  array.values = file->bytes().subspan(first, bytes);
  array.storage = file;
  if (header.swap || of.half || first % of.width() != 0) {
    check_bytes(request, bytes, name);
    auto [storage, to] = allocate<std::byte>(bytes);
    std::memcpy(to.data(), array.values.data(), bytes);
    if (header.swap) swap_bytes(to, of.width());
    array.values = to;
    array.storage = storage;
  }
  if (of.half) {
    check_bytes(request, 2 * bytes, name);
    auto [wider, floats] = allocate<float>(bytes / 2);
    half_numbers(array.values, floats);
    array.values = std::as_bytes(std::span<const float>(floats));
    array.storage = wider;
  }
  imported.axes = axes_in("Å");
  return imported;
}

}  // namespace isostrata
