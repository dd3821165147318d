// A small picture of what is shown of a dataset first, for lists of files: made for whoever looks at such a list, behind all other work.
//
// It is kept in the import cache (KeptWork, import_cache.h), if there is one. It must cost little: files of more than kMostThumbnailRead bytes a
// step have none, unless every n-th of their values can be read without the rest.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "base/task.h"
#include "encoding/encode_image.h"
#include "engine/engine/open_datasets.h"

namespace isostrata {

inline constexpr int kThumbnailWidth = 192, kThumbnailHeight = 144;
inline constexpr std::uint64_t kMostThumbnailRead = std::uint64_t{128} << 20;
inline constexpr double kMostThumbnailSeconds = 10;  // that a step may take to be read

/// A PNG of that size, drawn by the CPU. `room(bytes)` gives what it may take of the memory, as long as it is held, or throws. Throws unsupported (there is
/// nothing to show, or it is a part of a dataset), too_large, unavailable (the file is not as it was listed), what opening and drawing throw, and
/// cancelled. Any thread.
std::shared_ptr<const Bytes> make_thumbnail(OpenDatasets& datasets, const std::string& id, std::uint64_t max_memory,
                                            const std::function<std::shared_ptr<void>(std::uint64_t bytes)>& room, const Task& task);

}  // namespace isostrata
