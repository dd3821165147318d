// One door to all readers.
#pragma once

#include "import/imported/imported.h"

namespace isostrata {

/// Recognises the file and reads one time step. Throws not_found, bad_data, unsupported, too_large.
Imported read_file(const ReadRequest& request);

}  // namespace isostrata
