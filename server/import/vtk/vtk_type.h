// VTK's numbers of the types of values.
#pragma once

#include <vtkType.h>

#include "data/values/array.h"

namespace isostrata {

inline int vtk_type_of(ScalarType type) {
  switch (type) {
    case ScalarType::int8: return VTK_SIGNED_CHAR;
    case ScalarType::uint8: return VTK_UNSIGNED_CHAR;
    case ScalarType::int16: return VTK_SHORT;
    case ScalarType::uint16: return VTK_UNSIGNED_SHORT;
    case ScalarType::int32: return VTK_INT;
    case ScalarType::uint32: return VTK_UNSIGNED_INT;
    case ScalarType::int64: return VTK_LONG_LONG;
    case ScalarType::uint64: return VTK_UNSIGNED_LONG_LONG;
    case ScalarType::float32: return VTK_FLOAT;
    default: return VTK_DOUBLE;
  }
}

}  // namespace isostrata
