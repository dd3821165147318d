// The import child takes its own rights away before it looks at a foreign file.
#pragma once

#include <cstdint>
#include <filesystem>

namespace isostrata {

/// What a broken or hostile file can still do afterwards: use up to memory_bytes of address space and cpu_seconds, write files of
/// up to memory_bytes below `output`, and read `file` and what is below `directory`. The last two need a kernel with Landlock
/// (5.13 or newer) and are otherwise not enforced. Sockets and new programs are refused by seccomp. Where a kernel lacks Landlock
/// or seccomp the rest still holds.
void confine(const std::filesystem::path& directory, const std::filesystem::path& file, const std::filesystem::path& output,
             std::uint64_t memory_bytes, std::uint64_t cpu_seconds);

}  // namespace isostrata
