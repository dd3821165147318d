// Values mapped where they lie in a file of the user's.
//
// Such a file is not ours: a program may change it, and then other values are there, or cut it short, and then reading them raises SIGBUS. That
// ends this process, which is a worker or a command and no server, with one line that says which file it was.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "data/values/array.h"

namespace isostrata {

/// `bytes` bytes of the open file from `offset` on, read-only, as long as `storage` lives. `name` is for messages. The descriptor can be closed.
/// Throws bad_data (not a regular file, or too short: says what is declared and what is there), unavailable. Any thread.
struct SourceMapping {
  std::span<const std::byte> bytes;
  std::shared_ptr<const void> storage;
};
SourceMapping map_source(int descriptor, std::uint64_t offset, std::uint64_t bytes, const std::string& name);

/// Whether it lies in such a mapping: then it is the kernel's to keep or to drop, and takes none of our memory. Any thread.
bool is_in_source(const void* address);

/// What was read of the array's values leaves this process's memory, if they are mapped so; it is read again when it is looked at. Any thread.
void drop_pages(const PointArray& array);

}  // namespace isostrata
