// Files like 0/alpha.water.orig, from which the fields that a run begins with were made, in a case of OpenFOAM. They say that they are the same object as 0/alpha.water, and VTK's reader takes the
// one that it comes upon last.
#pragma once

#include <filesystem>

#include "import/imported/imported.h"

namespace isostrata {

/// For a case that has such files, links in request.scratch to all its files but them. For whoever may soon make no more links.
void make_links_without_originals(const ReadRequest& request);

/// The case's folder, or the folder of such links in its place.
std::filesystem::path case_without_originals(const std::filesystem::path& folder, const ReadRequest& request);

/// Removes these links.
void remove_links_without_originals(const ReadRequest& request);

}  // namespace isostrata
