// Folders that hold arrays in Zarr, version 2 or 3: what their small files of JSON are called, and which folders are one dataset.
#pragma once

#include <filesystem>
#include <string_view>
#include <vector>

namespace isostrata {

/// ".zarray", "zarr.json" and their like: what says what a folder of Zarr is. All else in it are values, in chunks.
bool is_zarr_metadata(std::string_view name);

/// Whether an entry of a folder with this name is nobody's data: it begins with a dot and is not Zarr's metadata.
bool is_hidden(std::string_view name);

/// Whether the folder is one dataset: it is named .zarr, or it is an array, an image of OME-Zarr, or a group of arrays
/// that name their axes. The words in its metadata say so, of which
/// at most 1 MiB is looked at; that it can be read is for the reader to say.
bool is_zarr(const std::filesystem::path& folder);

/// The files outside of the folder that say what a level of an image means, if it may be one: those in the folder above.
std::vector<std::filesystem::path> zarr_files_above(const std::filesystem::path& folder);

/// How many folders below it the files of a dataset in this folder may lie, as far as anyone looks for changes: Zarr has one for each axis, OpenFOAM processor0/0.5/region/polyMesh.
int deepest_file(const std::filesystem::path& folder);

}  // namespace isostrata
