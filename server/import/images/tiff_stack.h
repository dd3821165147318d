// What the pages of a TIFF are, as ImageJ or OME-TIFF says in the description of the first: channels, slices and frames, and how far they are apart.
//
// ImageJ: lines "key=value" (ij.io.TiffEncoder and FileInfo). OME-TIFF: "The OME-TIFF file structure" and the OME schema 2016-06, docs.openmicroscopy.org.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "import/images/tiff_directory.h"

namespace isostrata {

struct TiffStack {
  std::int64_t channels = 1, slices = 1, frames = 1;
  std::vector<std::int64_t> pages;         // [frames][channels][slices] the page of each; -1: none
  std::array<double, 3> spacing{1, 1, 1};  // of columns, rows, slices
  bool placed = false;                     // the first two are said, too
  double interval = 0;                     // between frames; 0: not said
  std::string unit, time_unit;             // may be empty
  std::vector<std::string> names;          // of channels; may be fewer
  std::vector<std::string> notes;
  bool raised = false;       // numbers of 16 bits are stored with 32768 added
  bool pages_in_one = false; // one page may stand for all: their values follow those of the first (ImageJ, above 4 GB)

  std::int64_t planes() const { return channels * slices * frames; }
};

/// Nothing if neither says anything, or what is said makes no sense; then `why` says so, if somebody should know. `samples` are the components of a pixel.
std::optional<TiffStack> describe_tiff_stack(const TiffDirectory& directory, int samples, std::string& why);

}  // namespace isostrata
