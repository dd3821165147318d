// Writing while the reader goes on computing: what goes to files is a third of an import's time, and a reader has one thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

namespace isostrata {

/// Who waits for it soon comes first.
enum class Hurry { some, none };

struct WriteCall {
  Hurry hurry = Hurry::some;
  std::uint64_t number = 0;  // of those of its hurry
};

/// Has bytes written behind what the file has, by the only other thread of the process, in the order of the calls of their hurry. Fewer than kLeastBehind are
/// written when it returns, and so are all where there can be no thread. The others must stay until wait_for_written, or as long as `storage`, which the
/// other thread lets go. close: the file, afterwards. Waits while kMostBehind calls are not done. Of one thread, and not before a fork.
WriteCall write_behind(Hurry hurry, int file, std::span<const std::byte> bytes, bool close = false, std::shared_ptr<const void> storage = nullptr);
/// Until this call, and all before it of its hurry, are done. Throws unavailable if any has ever failed: there is no dataset then.
void wait_for_written(const WriteCall& call);

constexpr std::size_t kMostBehind = 64;
constexpr std::size_t kLeastBehind = 1u << 16;

}  // namespace isostrata
