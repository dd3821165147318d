// How NIfTI files begin: one that holds all, and the header of a pair, NAME.hdr, whose values are NAME.img.
#pragma once

#include <filesystem>
#include <string_view>

namespace isostrata {

/// Of the file's first 348 bytes or more.
bool begins_as_nifti(std::string_view head);
bool begins_as_nifti_pair(std::string_view head);

/// The other one of a pair: of NAME.hdr NAME.img, of NAME.img NAME.hdr; empty of other names.
std::filesystem::path other_of_nifti_pair(const std::filesystem::path& file);

}  // namespace isostrata
