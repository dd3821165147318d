// How much memory and time reading one file may take.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace isostrata {

/// Bytes of address space: the least of what a dataset of max_bytes needs (its arrays exist twice for a moment), of what files of
/// this size can hold when they are packed as tightly as deflate can, and of what is free; and the libraries' part on top. A file
/// that may name others (.pvd, .mhd) is taken with all that lies beside and below it.
std::uint64_t memory_limit(const std::filesystem::path& file, std::uint64_t max_bytes);

/// Seconds of processor time: at most `most`, and no more than a file of this size can need, so that a reader that a broken file sends in
/// circles ends within ten seconds. Files that may name others are taken with them, as above.
std::uint64_t cpu_limit(const std::filesystem::path& file, std::uint64_t most);

/// Throws bad_data, with the numbers, if so many declared bytes are more than `stored` ones can hold, packed as tightly as deflate can.
void check_unpacked(std::uint64_t declared, std::uint64_t stored, const std::string& name);

/// The second of those of memory_limit on its own: the memory that reading `stored` bytes can take.
std::uint64_t unpacked_bytes(std::uint64_t stored);

}  // namespace isostrata
