// A mesh's arrays at the points of a uniform grid: what takes the place of every n-th point, which a mesh does not have.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "base/task.h"
#include "data/dataset/dataset.h"

namespace isostrata {

/// Whether sampled() has something to make: an unstructured grid of cells with a volume, whose bounds have one too.
bool can_be_sampled(const Dataset& mesh);

/// The arrays of these names at the points of a uniform grid of some `most_points` over the mesh's bounds, with the ranges and the bounds of the mesh, so
/// that it is drawn in its colours and place. A point has the value that runs linearly between the corners of the cell that holds it (of a tetrahedron of
/// that cell, if it has more corners); outside of the mesh, and in hidden cells, NaN. So what is thinner than the grid is not there. The same for any
/// number of threads. O(cells + points). Precondition: can_be_sampled. Throws not_found (an array that is not there), cancelled. Parallel.
std::shared_ptr<const Dataset> sampled(const Dataset& mesh, std::int64_t most_points, std::span<const std::string> arrays, const Task& task);

}  // namespace isostrata
