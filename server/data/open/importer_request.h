// What a reader is asked for, as one packet to the process that makes readers (loaded_importer.h, import/limits/fork_for_files.h).
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace isostrata {

/// The argument with which isostrata-import makes readers: its standard input is a socket of packets, each with three descriptors: the reader's standard
/// output, its standard error, and a control. When the reader has ended its status, as of waitpid, is written to the control, which is then
/// closed; the other end closed for writing ends the reader first.
inline constexpr const char* kForkForFiles = "--fork-for-files";
inline constexpr std::size_t kMostRequest = 64 << 10;  // bytes

struct ImporterRequest {
  std::vector<std::string> words;        // the arguments
  std::vector<std::string> environment;  // "NAME=VALUE", all there are
  int nice = 0;                          // of the reader; less than that of the process that makes it is none
};

/// Throws invalid_argument if it is too long.
std::string to_packet(const ImporterRequest& request);
ImporterRequest from_packet(std::string_view packet);

}  // namespace isostrata
