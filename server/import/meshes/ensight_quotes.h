// Cases of EnSight as VTK's reader takes them: it takes quotes for a part of the names, ends a name at a blank, knows no lists of numbers in files of their own, and
// from VTK 9.6 on no numbers on several lines.
#pragma once

#include <filesystem>

#include "import/imported/imported.h"

namespace isostrata {

/// For a case, links in request.scratch: to its folder, and to each file below it whose name has blanks. From names alone; for whoever may soon make no more links.
void make_links_without_blanks(const ReadRequest& request);

/// The case itself, or a copy of it in request.scratch whose names have neither quotes nor blanks, and lead back to the case's files, with the numbers of files that it names.
/// Throws bad_data if such a file holds other than numbers, unsupported if a name is too long.
std::filesystem::path case_for_reader(const ReadRequest& request);

/// Removes these links.
void remove_links(const ReadRequest& request);

}  // namespace isostrata
