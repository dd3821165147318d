#include "import/images/fits_rice.h"

#include <algorithm>

namespace isostrata {
namespace {

class BitReader {
 public:
  explicit BitReader(std::span<const std::byte> code) : code_(code) {}

  /// At most 32.
  std::uint32_t bits(int count) {
    while (held_ < count) take();
    held_ -= count;
    return static_cast<std::uint32_t>(word_ >> held_ & ((std::uint64_t{1} << count) - 1));
  }
  /// How many zeros stand before the next one, which is taken, too.
  std::uint32_t zeros() {
    std::uint32_t count = 0;
    while (!ended() && bits(1) == 0) ++count;
    return count;
  }
  bool ended() const { return past_ > 8; }  // what is behind the end reads as zeros, of which a few may be asked for

 private:
  void take() {
    word_ = word_ << 8 | (at_ < code_.size() ? std::to_integer<std::uint64_t>(code_[at_]) : 0);
    past_ += at_ >= code_.size();
    ++at_;
    held_ += 8;
  }
  std::span<const std::byte> code_;
  std::size_t at_ = 0;
  std::uint64_t word_ = 0;
  int held_ = 0, past_ = 0;
};

}  // namespace

bool unpack_rice(std::span<const std::byte> code, int width, int block, std::span<std::int32_t> to) {
  if ((width != 1 && width != 2 && width != 4) || block < 1 || block > 65536) return false;
  const int of_split = width == 1 ? 3 : width == 2 ? 4 : 5, raw = width == 1 ? 6 : width == 2 ? 14 : 25, whole = 8 * width;
  if (code.size() < static_cast<std::size_t>(width)) return to.empty();
  BitReader in(code);
  std::uint32_t last = in.bits(whole);
  const auto number = [&](std::uint32_t value) { return width == 1 ? static_cast<std::int32_t>(value & 0xff) : width == 2 ? static_cast<std::int32_t>(static_cast<std::int16_t>(value)) : static_cast<std::int32_t>(value); };
  for (std::size_t at = 0; at < to.size();) {
    if (in.ended()) return false;
    const int split = static_cast<int>(in.bits(of_split)) - 1;
    for (const std::size_t end = std::min(to.size(), at + static_cast<std::size_t>(block)); at < end; ++at) {
      std::uint32_t code_of = 0;
      if (split == raw) code_of = in.bits(whole);
      else if (split >= 0) code_of = in.zeros() << split, code_of |= split > 0 ? in.bits(split) : 0;
      last += code_of & 1 ? ~(code_of >> 1) : code_of >> 1;
      to[at] = number(last);
      if (in.ended()) return false;
    }
  }
  return true;
}

}  // namespace isostrata
