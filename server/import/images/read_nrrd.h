// NRRD volumes: .nrrd, and .nhdr with detached data below its own directory; and volumes of other headers, said in NRRD's words.
#pragma once

#include <memory>
#include <string>

#include "import/bytes/mapped_file.h"
#include "import/images/nrrd_header.h"
#include "import/imported/imported.h"

namespace isostrata {

/// One array, "scalars" (its components where the file has vector, colour or list axes). Axes of space become x, y, z in the
/// file's order, or in that of the directions if each is along one of x, y and z of its own; a time axis becomes time steps. Such directions give a uniform
/// grid, others a curvilinear one; the file's own space is kept. Throws not_found (detached data, step), bad_data, unsupported, too_large.
Imported read_nrrd(const ReadRequest& request);

/// The same of a header that says so by other words. file: the request's; the values are behind header.length of it, or in the files that the header names.
Imported read_described(const ReadRequest& request, const NrrdHeader& header, const std::shared_ptr<const MappedFile>& file, const std::string& array);

}  // namespace isostrata
