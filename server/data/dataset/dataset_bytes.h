// How large a dataset is.
#pragma once

#include <cstdint>

#include "data/dataset/dataset.h"

namespace isostrata {

/// What the dataset holds in memory or mapped: points, cells and arrays, in bytes. Any thread.
std::uint64_t dataset_bytes(const Dataset& dataset);

}  // namespace isostrata
