// Images whose values are read past VTK's readers, or need not be read, because they lie in the file as they are in memory.
#pragma once

#include <optional>

#include "import/imported/imported.h"
#include "import/vtk/meta_header.h"

namespace isostrata {

/// Of .vti: one piece whose arrays xml_arrays.h finds; of .mhd and .mha: one file of values in the machine's byte order. Values that lie there as in memory, but
/// are not aligned, are copied once, from file to file, without passing through the child's memory. VTK's readers tell where the image lies in space, and
/// are not asked for its values. Nothing for every other file, also
/// for one that is too short or says what makes no sense: what is wrong with it is VTK's readers' to say.
std::optional<Imported> vti_in_place(const ReadRequest& request);
std::optional<Imported> meta_image_in_place(const ReadRequest& request, const MetaHeader& header);

/// An image of these values, placed by VTK's reader. Nothing if that has another number of points.
std::optional<Imported> placed_meta_image(const ReadRequest& request, const MetaHeader& header, FileArray array);

}  // namespace isostrata
