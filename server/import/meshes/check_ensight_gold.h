// What VTK's reader of binary EnSight Gold does not check: it reads as many numbers as a file declares.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>

namespace isostrata {

/// How many values each part of a geometry has at its points, and in its cells of each kind.
struct GoldPart {
  std::uint64_t points = 0;
  bool block = false;
  std::map<std::string, std::uint64_t> cells;
};
using GoldParts = std::map<std::int32_t, GoldPart>;

/// Throws bad_data if a geometry in C's binary form ends early, has lines that the format lacks, or a cell has a point that its part lacks. Nothing of
/// several steps in one file, and if blocks are given in another way than by their points: those are VTK's to read. `name` is the file's, for messages.
std::optional<GoldParts> check_gold_geometry(std::span<const std::byte> file, const std::string& name);

/// Throws bad_data if values of that many components are of a part that the geometry lacks, or end early.
void check_gold_values(std::span<const std::byte> file, const GoldParts& parts, bool on_cells, std::uint64_t components, const std::string& name);

}  // namespace isostrata
