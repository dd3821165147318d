// Meshes from a device: what GlExtraction leaves there as the IntervalMesh that extract_intervals makes, and a check that it
// does.
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "extraction/intervals/extract_intervals.h"
#include "rendering/device/gl_extraction.h"

namespace isostrata {

/// Cells, cases, points and tetrahedra are found on the device; positions, volumes and facets are computed here in double
/// precision by the functions that extract_intervals uses. So the mesh is that of extract_intervals but for the order of its
/// points and cells: points by the grid's bricks of 8^3 points, cells in increasing order. Loads the field first. Throws what
/// GlExtraction and extract_intervals throw.
IntervalMesh extract_intervals_on(GlExtraction& device, const Grid& grid, const PointArray& array,
                                  std::span<const Interval> intervals, const ExtractOptions& options, const Task& task);

/// Whether `device` extracts as the CPU does: the counts and the volume of a small field. "" where it does, else what is wrong.
std::string check_gl_extraction(std::string_view device);

}  // namespace isostrata
