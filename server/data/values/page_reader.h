// Between the import child and the module that reads picture files with OpenImageIO (encoding/oiio, where it stands why that is a module). Both are of one
// build: whoever changes this changes kPageReaderAbi.
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <span>
#include <string>

#include "data/values/array.h"

namespace isostrata {

inline constexpr int kPageReaderAbi = 1;

/// What all slices of a volume have in common.
struct PageLayout {
  int columns = 0, rows = 0, layers = 1, channels = 0;
  ScalarType type = ScalarType::uint8;
  int unused_bits = 0;  // at the low end, that OpenImageIO fills up values of 1, 2, 4, 6, 10, 12, 14 or 24 bits with
  bool bottom_first = false;
  bool operator==(const PageLayout&) const = default;
};

/// One file, at its first page. Not thread-safe. Everything throws std::domain_error (what it is, is not read) or std::runtime_error (it is damaged), with one
/// line that does not name the file.
class PageReader {
 public:
  virtual ~PageReader() = default;
  virtual const PageLayout& layout() const = 0;  // of the page
  /// Millimetres between pixels if the page says how many there are on an inch or a centimetre, else 1.
  virtual std::array<double, 2> spacing() const = 0;
  /// False: there are no more pages.
  virtual bool next_page() = 0;
  /// One value of the type for each channel of each pixel: as they are stored, channels fastest, the lowest row first, as y runs.
  virtual void read(std::span<std::byte> to) = 0;
};

struct PageModule {
  int abi = kPageReaderAbi;
  std::unique_ptr<PageReader> (*open)(const std::string& path);
};

}  // namespace isostrata

extern "C" const isostrata::PageModule* isostrata_page_module();
