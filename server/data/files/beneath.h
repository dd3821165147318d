// Paths that may not lead out of a directory, whatever becomes of the files in it.
#pragma once

#include <filesystem>

namespace isostrata {

/// ROOT/./REST: the same file as ROOT/REST for everybody, and for those below one that is reached from ROOT without leaving it.
std::filesystem::path beneath(const std::filesystem::path& root, const std::filesystem::path& rest);

/// ROOT/REST.
std::filesystem::path without_mark(const std::filesystem::path& path);
/// The same without a slash or a dot at its end.
std::filesystem::path plain_folder(const std::filesystem::path& folder);

/// Opens as open(2) does, and closes on exec; of ROOT/./REST by way of ROOT's descriptor (openat2, or a look at the real path
/// where the kernel has none), so that a file that was swapped for a link is not followed out of ROOT. -1 and errno where it
/// fails, EXDEV where it would leave.
int open_beneath(const std::filesystem::path& path, int flags);
/// The same of a name in an open directory.
int open_beneath(int directory, const std::filesystem::path& name, int flags);

}  // namespace isostrata
