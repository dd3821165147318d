// What of a DICOM file says where its pixels are and what they mean.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <vector>

namespace isostrata {

struct DicomHeader {
  std::filesystem::path file;
  std::string series, syntax, modality, rescale_type, dose_unit;
  std::string instance_uid;                                 // the same of copies
  int rows = 0, columns = 0, frames = 1, samples = 1, bits = 0, stored = 0, is_signed = 0, instance = 0;
  double slope = 1, intercept = 0, thickness = 1;
  double between = 0;                                       // slices, along the normal; 0: not said
  std::array<double, 2> spacing{1, 1};                      // between rows, between columns
  std::array<double, 6> orientation{1, 0, 0, 0, 1, 0};      // of a row, then of a column, in the patient's space (left, back, up)
  std::vector<std::array<double, 3>> positions;             // of the first pixel: of the file, or of each frame; may be empty
  std::vector<double> offsets;                              // of the frames of a dose, along the normal; may be empty
  std::size_t pixels = 0, pixel_bytes = 0;                  // where they begin; 0 bytes if they are compressed

  std::size_t frame_bytes() const { return static_cast<std::size_t>(rows) * static_cast<std::size_t>(columns) * static_cast<std::size_t>(bits / 8); }
};

/// Reads DICOM (PS3.5, explicit or implicit, little endian). Throws bad_data if it ends early or is nested too deep, unsupported for other
/// byte orders. Whether pixels are there, and uncompressed, is for the caller to ask.
DicomHeader parse_dicom(std::span<const std::byte> bytes, const std::filesystem::path& file);

}  // namespace isostrata
