// VTK's readers print errors and hand over what they have. Here every error ends the import.
#pragma once

#include <string>
#include <vector>

namespace isostrata {

/// Installs VTK's output window that keeps messages instead of printing them. An abort because memory is missing becomes the error too_large, said of NAME. Call once.
void collect_vtk_messages(const std::string& name);

/// Throws bad_data with the first error that VTK's readers printed so far, said as "NAME: text".
void throw_on_vtk_error(const std::string& name);

/// Takes the errors that begin like this from those that throw_on_vtk_error looks at, without their beginning; each text once.
std::vector<std::string> take_vtk_errors(const std::string& beginning);

/// Errors that begin like this are none from now on.
void pass_over_vtk_errors(const std::string& beginning);

/// What VTK warned of so far, at most a few, one line each.
std::vector<std::string> vtk_warnings();

}  // namespace isostrata
