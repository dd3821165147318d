#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "data/files/raw_name.h"
#include "import/bytes/swap_bytes.h"
#include "import/images/read_nrrd.h"
#include "import/imported/read_own.h"
#include "import/raw/raw_axes.h"

namespace isostrata {
namespace {

constexpr std::size_t kRows = 64;          // that are looked at
constexpr std::size_t kOfRow = 1u << 16;  // values of a row, at most

/// The sum of the steps from value to value along rows, over that of the distances from the rows' means: about 1 of noise, much less of a field.
template <class T>
double roughness(std::span<const std::byte> bytes, std::size_t row, bool swapped) {
  const std::size_t rows = bytes.size() / sizeof(T) / row, stride = std::max<std::size_t>(rows / kRows, 1);
  double steps = 0, distances = 0;
  std::vector<std::byte> one(row * sizeof(T));
  std::vector<T> values(row);
  for (std::size_t r = 0; r < rows; r += stride) {
    std::memcpy(one.data(), bytes.data() + r * one.size(), one.size());
    if (swapped) swap_bytes(one, sizeof(T));
    std::memcpy(values.data(), one.data(), one.size());
    double mean = 0;
    for (const T value : values) mean += static_cast<double>(value) / static_cast<double>(row);
    for (std::size_t i = 0; i < row; ++i) {
      distances += std::abs(static_cast<double>(values[i]) - mean);
      if (i > 0) steps += std::abs(static_cast<double>(values[i]) - static_cast<double>(values[i - 1]));
    }
    if (!std::isfinite(steps) || !std::isfinite(distances)) return std::numeric_limits<double>::infinity();
  }
  return distances > 0 ? steps / distances : 0;
}

/// Whether the values run smoothly with their bytes the other way round, and do not as they are.
bool runs_the_other_way(std::span<const std::byte> bytes, ScalarType type, std::size_t row) {
  if (size_of(type) == 1 || bytes.empty()) return false;
  return std::visit(
      [&]<class T>(std::span<const T>) {
        const double as_it_is = roughness<T>(bytes, row, false), swapped = roughness<T>(bytes, row, true);
        return as_it_is > 0.4 && swapped < 0.5 * as_it_is;
      },
      scalar_span(type, {}));
}

}  // namespace

Imported read_raw(const ReadRequest& request) {
  const std::string name = request.file.filename().string();
  const auto file = std::make_shared<const MappedFile>(request.file);
  const auto said = raw_name(name, file->bytes().size());
  if (!said) throw Error(ErrorCode::unsupported, name + ": its name does not say how many numbers of which type it holds; expected NAME_256x256x256_uint8.raw");
  NrrdHeader header;
  header.type = *said->type;
  for (std::size_t a = 0; a < said->sizes.size(); ++a) add_axis(header, said->sizes[a], a == 3 ? NrrdRole::time : NrrdRole::space, name);
  header.big_endian = said->big_endian.value_or(false);
  const bool other = !said->big_endian && runs_the_other_way(file->bytes(), header.type, std::min(static_cast<std::size_t>(header.axes[0].size), kOfRow));
  if (other) header.big_endian = true;
  Imported imported = read_described(request, header, file, "scalars");
  imported.notes.push_back("sizes and type are those of its name; points 1 apart");
  if (!said->says_type) imported.notes.push_back(std::string("its name says no type: taken for ") + to_string(header.type) + ", by the file's size");
  if (other) imported.notes.push_back("its bytes are taken from the highest to the lowest (big-endian): so its values run smoothly");
  return imported;
}

}  // namespace isostrata
