// Cases of EnSight that name their files in quotes, which VTK's reader takes for a part of the names.
#pragma once

#include <filesystem>

#include "import/imported.h"

namespace isostrata {

/// The case itself, or a copy of it in request.scratch whose names have no quotes and lead back to the case's folder. Throws unsupported where a name, or the way to the folder, has
/// blanks in it, at which the reader ends a name.
std::filesystem::path case_without_quotes(const ReadRequest& request);

}  // namespace isostrata
