// A file read whole by the reader that VTK has for it.
#pragma once

#include <memory>
#include <string>

namespace isostrata::peers {

/// Reads all point and cell arrays of the first step and finds their ranges, as opening does. Returns what was read, alive. Throws unsupported for an ending
/// that no reader here has, bad_data if it reads nothing.
std::shared_ptr<void> read_by_vtk(const std::string& file);

}  // namespace isostrata::peers
