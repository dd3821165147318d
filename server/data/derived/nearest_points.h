// Arrays of points that are not interpolated: everywhere the field has the value of the nearest point. So labels are read: halfway between an organ 1 and
// an organ 5 there is no organ 3.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "base/task.h"
#include "data/dataset/dataset.h"

namespace isostrata {

/// The same domain, cut into cells of which each belongs to one point of `whole`; the named arrays (also those that were averaged from cells) have
/// that point's value as CellValues, and no values at the new points. Bounds, ranges, times and notes are the whole's.
///
/// Of a structured grid without hidden cells the cells are the boxes between the middles of neighbouring points, ended by the domain: one for each
/// point, and the values are not copied. Of other grids each cell is cut at the middles of its edges, faces and its own into one piece at each
/// of its points (the barycentric subdivision); on boxes that is the same solid. Pieces share whole faces.
///
/// Throws unsupported (a cell of an unstructured grid repeats a point), not_found (no such array), too_large (above max_bytes), cancelled. What is made
/// stays for the next call as long as somebody holds it. Any thread.
std::shared_ptr<const Dataset> nearest_point_cells(const std::shared_ptr<const Dataset>& whole, std::span<const std::string> arrays,
                                                   std::uint64_t max_bytes, const Task& task);

}  // namespace isostrata
