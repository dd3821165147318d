// NRRD's five encodings.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "import/images/nrrd_header.h"

namespace isostrata {

/// Decodes `values` values of the header's type from the bytes of one data file (after the header, where both share a file),
/// after the header's line skip and byte skip; the result is in native byte order. A negative byte skip -N-1 says that the data
/// end N bytes before the end (of what was decompressed); if there is no room for that, they end with the file and a note says
/// so. Memory grows with what is really there, not with what is declared. Throws bad_data saying what is declared and what is
/// present.
std::vector<std::byte> decode_nrrd(std::span<const std::byte> file, const NrrdHeader& header, std::int64_t values,
                                   const std::string& name, std::vector<std::string>& notes);

/// Those values where they lie in the file, if its encoding is raw and their bytes are in the machine's order; nothing otherwise. Throws as
/// decode_nrrd.
std::optional<std::span<const std::byte>> nrrd_in_place(std::span<const std::byte> file, const NrrdHeader& header, std::int64_t values,
                                                        const std::string& name, std::vector<std::string>& notes);

}  // namespace isostrata
