// The ten scalar types of arrays, with what the functions for each are called. A macro, because Highway compiles the files that use it
// once for each level of vector instructions.
#pragma once

#include <cstdint>

#define ISOSTRATA_FOR_EACH_SCALAR(X) \
  X(std::int8_t, I8)                 \
  X(std::uint8_t, U8)                \
  X(std::int16_t, I16)               \
  X(std::uint16_t, U16)              \
  X(std::int32_t, I32)               \
  X(std::uint32_t, U32)              \
  X(std::int64_t, I64)               \
  X(std::uint64_t, U64)              \
  X(float, F32)                      \
  X(double, F64)
