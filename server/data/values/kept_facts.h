// What took a look at every value of an array to know, kept beside its import for whoever opens it next: ranges of bricks, histograms.
//
// A fact is a file of a few kilobytes to a few megabytes in the array's entry of the cache (import_cache.h), written under another name and renamed,
// with a checksum, so that half of one is none. It goes with its entry. Any thread.
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "data/values/array.h"

namespace isostrata {

/// Facts about the array that `storage` keeps alive lie in this folder and begin with `prefix`. For whoever maps arrays from an entry that is
/// believed.
void set_place_of_facts(const std::shared_ptr<const void>& storage, std::filesystem::path folder, std::string prefix);

/// The bytes that were kept under this name; nothing if none are, or the array has no place for them.
std::optional<std::vector<std::byte>> kept_fact(const PointArray& array, const std::string& name);

/// Bytes in a file with a checksum. Nothing if they are not as they were written.
std::optional<std::vector<std::byte>> read_checked(const std::filesystem::path& file);
/// Whether they could be written.
bool write_checked(const std::filesystem::path& file, std::span<const std::byte> bytes);

/// Keeps them where the array has a place for them and the disk has room; else does nothing.
void keep_fact(const PointArray& array, const std::string& name, std::span<const std::byte> bytes);

}  // namespace isostrata
