// The optional module with libavcodec, if it is there.
#pragma once

#include <string>

#include "encoding/avcodec/avcodec_abi.h"

namespace isostrata {

struct AvcodecModule {
  const isostrata_avcodec* functions = nullptr;  // null: there is none
  std::string path;                              // where it was found
  std::string problem;                           // or why there is none
};

/// Looked for once: where $ISOSTRATA_AVCODEC says, beside the program, and in lib/ beside the program's folder. Any thread.
const AvcodecModule& avcodec_module();

}  // namespace isostrata
