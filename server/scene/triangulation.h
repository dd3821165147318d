// How the part of a cell becomes tetrahedra.
#pragma once

namespace isostrata {

enum class Triangulation {
  table,  // the interval tables as they are
  strict  // no tetrahedron is turned against its cell, same facets on the cells' faces
};

}  // namespace isostrata
