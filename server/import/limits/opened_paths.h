// Which paths the libraries of this program may open, where the kernel cannot be asked to refuse the others.
#pragma once

#include <filesystem>
#include <vector>

namespace isostrata {

/// From now on open, openat, fopen and opendir of every library of this process fail with EACCES but below `directory` (what is hidden right in it shut, but
/// for Zarr's metadata) and `output`, and of `files`. So a file that names one elsewhere, as those of HDF5 and EnSight can, has it not read. It holds nobody
/// who makes system calls of his own: that is Landlock's. Links are followed to where they lead. Before there are threads; once.
void open_only(const std::filesystem::path& directory, const std::vector<std::filesystem::path>& files, const std::filesystem::path& output);

}  // namespace isostrata
