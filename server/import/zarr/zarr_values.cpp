#include "import/zarr/zarr_values.h"

#include <cstring>
#include <limits>
#include <type_traits>

#include "import/bytes/half_number.h"
#include "import/bytes/swap_bytes.h"

namespace isostrata {
namespace {

/// Whole numbers wrap around, as they did when the differences were taken.
template <class T>
void sum_up(std::span<std::byte> bytes) {
  using Sum = std::conditional_t<std::is_integral_v<T>, std::make_unsigned<T>, std::type_identity<T>>::type;
  Sum sum{}, next{};
  for (std::size_t at = 0; at + sizeof next <= bytes.size(); at += sizeof next) {
    std::memcpy(&next, bytes.data() + at, sizeof next);
    sum = static_cast<Sum>(sum + next);
    std::memcpy(bytes.data() + at, &sum, sizeof sum);
  }
}

template <class From, class To>
void unpack(std::span<const std::byte> from, const ZarrPacking& packing, std::vector<std::byte>& room) {
  room.resize(from.size() / sizeof(From) * sizeof(To));
  From number{};
  for (std::size_t i = 0; i < from.size() / sizeof(From); ++i) {
    std::memcpy(&number, from.data() + i * sizeof(From), sizeof number);
    const auto stored = static_cast<double>(number);
    const double whole = packing.divides ? stored / packing.scale : packing.scale * stored;
    const To value = packing.none == stored ? std::numeric_limits<To>::quiet_NaN() : static_cast<To>(packing.offset + whole);
    std::memcpy(room.data() + i * sizeof(To), &value, sizeof value);
  }
}

}  // namespace

std::span<const std::byte> zarr_values(const ZarrArray& array, std::span<std::byte> numbers, std::vector<std::byte>& room) {
  if (array.swap) swap_bytes(numbers, array.stored_width());
  if (array.half) {
    const std::size_t count = numbers.size() / 2;
    room.resize(count * sizeof(float));
    half_numbers(numbers, {reinterpret_cast<float*>(room.data()), count});
    return room;
  }
  if (!array.delta && !array.packing) return numbers;
  std::visit(
      [&](auto of) {
        using T = std::remove_const_t<typename decltype(of)::value_type>;
        if (array.delta) sum_up<T>(numbers);
        if (array.packing && array.type == ScalarType::float32) unpack<T, float>(numbers, *array.packing, room);
        if (array.packing && array.type == ScalarType::float64) unpack<T, double>(numbers, *array.packing, room);
      },
      scalar_span(array.stored, {}));
  return array.packing ? std::span<const std::byte>(room) : numbers;
}

}  // namespace isostrata
