// The directions of combined ranges' surfaces: those of one array's isosurface along that array's gradient, another's along its own.
#pragma once

#include <span>
#include <vector>

#include "base/buffer.h"
#include "base/task.h"
#include "data/grids/grid.h"
#include "data/values/array.h"
#include "extraction/mesh/interval_mesh.h"

namespace isostrata {

/// Appends three fields of each array, [3 * arrays][np]: gradient_normals of the mesh that is about to be cut, which the cuts carry
/// to the points that they make. The mesh has origins. Throws cancelled.
void append_directions(const Grid& grid, std::span<const PointArray* const> arrays, const IntervalMesh& mesh,
                       std::vector<Buffer<double>>& fields, const Task& task);

/// Unit vectors at the points of the surfaces, [np], from the fields that append_directions gave: directions[3 * i] and the two
/// after it are of the i-th array, array_of_range[BoundaryFacet::range] is i. Zero at points that are on no surface and on edges at
/// which surfaces of two arrays meet: facets beside them turn to their own normals.
std::vector<Vec3f> surface_normals(const IntervalMesh& mesh, std::span<const int> array_of_range,
                                   std::span<const Buffer<double>> directions);

/// The three fields of one array as unit vectors, [np]; zero if there is none.
std::vector<Vec3f> unit_directions(std::span<const Buffer<double>> directions);

}  // namespace isostrata
