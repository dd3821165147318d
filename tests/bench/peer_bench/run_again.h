// This program once more, for what is measured in a process of its own.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace isostrata::peers {

/// Runs this program with these words, the first of which is its name, and returns what it printed. max_bytes: of address space; 0: any. Throws
/// unavailable if it did not end with 0.
std::string run_again(const std::vector<std::string>& words, std::uint64_t max_bytes = 0);

/// A line of a /proc file in bytes: "VmHWM:    123 kB". 0 if it is not there.
std::uint64_t proc_bytes(const char* file, const std::string& name);

}  // namespace isostrata::peers
