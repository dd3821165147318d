// A dataset that lies in pieces, each the part of one region with its margin (take_region.h) in a file of its own: what `isostrata partition`
// writes. Beside the list of pieces that VTK knows (NAME.pvtu, .pvti, .pvtr, .pvts) a manifest says what is known of the whole and which planes part
// the regions, so that whoever wants one part opens one piece and nothing else.
//
// NAME.parts.json: {"format":1, "points":n, "cells":n, "cell_types":{"hexahedron":n}, "bounds":[[x,x],[y,y],[z,z]],
//   "grid":"uniform"|..., "dims":[ni,nj,nk], "origin":[x,y,z], "spacing":[x,y,z]    (uniform grids: where points lie, to the last bit),
//   "arrays":[{"name":..., "type":..., "range":[lower,upper] or null, "nan_count":n}],
//   "planes":[{"axis":0, "at":x, "below":n, "above":n}]    (RegionTree::nodes: n or more than 0 is a plane of this list, ~n is part n),
//   "parts":[{"file":NAME_0.vtu, "first":[i,j,k] (structured grids), "points":n, "cells":n, "own_cells":n}]}
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "data/dataset/dataset.h"
#include "data/grids/region_tree.h"

namespace isostrata {

/// The array in an unstructured piece that says which points of the whole its points are, as VTK's attribute GlobalIds.
inline constexpr const char* kGlobalPoints = "GlobalPointIds";

struct DatasetParts {
  struct Array {
    std::string name;
    ScalarType type = ScalarType::float32;
    double lower = 0, upper = 0;
    std::int64_t nan_count = 0;
  };
  struct Part {
    std::string file;                   // beside the list
    std::array<std::int64_t, 3> first{};  // its first point in the whole, of structured grids
    std::int64_t points = 0, cells = 0, own_cells = 0;
  };
  std::int64_t points = 0, cells = 0;  // of the whole
  std::map<std::string, std::int64_t> cell_types;
  Box3d bounds;
  std::string grid;                      // Grid::kind_name() of the whole
  std::array<std::int64_t, 3> dims{};    // of structured grids
  Vec3d origin{}, spacing{1, 1, 1};      // of uniform ones
  std::vector<Array> arrays;
  RegionTree regions;
  std::vector<Part> parts;  // one a region, in their order
};

/// What is the same for all parts; the parts are still to be added.
DatasetParts partition_of(const Dataset& whole, const RegionTree& regions);

/// "folder/NAME.parts.json" of "folder/NAME.pvtu".
std::filesystem::path manifest_of(const std::filesystem::path& list);
std::string to_text(const DatasetParts& partition);
/// Throws bad_data saying what was expected; `name` is for messages.
DatasetParts parse_partition(const std::string& text, const std::string& name);

/// Of a list of pieces beside which a manifest lies; nothing if there is none, or the name is another one. Throws bad_data.
std::optional<DatasetParts> find_partition(const std::filesystem::path& list);

/// The part of one region, as take_region gives it with the margin that was written; what is said of the whole is the manifest's. Only its own file
/// is opened. Throws what open_dataset throws, and bad_data if the piece is another one than the manifest says.
std::shared_ptr<const Dataset> open_piece(const DatasetParts& partition, const std::filesystem::path& list, int region, const OpenOptions& options, const Task& task);

}  // namespace isostrata
