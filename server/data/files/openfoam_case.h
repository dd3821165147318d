// Where the times of an OpenFOAM case are: in folders of its own, or in those of the processors that compute it.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace isostrata {

/// The folders right in `folder` that are named by a time, in the order of the times.
std::map<double, std::string> openfoam_times(const std::filesystem::path& folder);

/// processor0, processor1 and so on, as far as they go; else the folders of the file handler "collated", processors4 or processors4_0-1 and others, by name. Empty if the case has a mesh and
/// times of its own, as one that was put together, and those of the processors go no further.
std::vector<std::filesystem::path> openfoam_parts(const std::filesystem::path& folder);

/// Whether at the last time fields are in folders of regions alone: then the mesh of the whole, if there is one, is what those were cut from. `folder` has times right in it.
bool has_fields_in_regions_alone(const std::filesystem::path& folder);

/// "processors4", "processors4_0-1".
bool is_collated_name(const std::string& name);

}  // namespace isostrata
