#include "import/images/picture_files.h"

#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <sstream>
#include <string>
#include <vector>

#include "base/load_module.h"
#include "data/files/file_series.h"
#include "data/files/recognise.h"
#include "import/imported/place_image.h"
#include "import/imported/read_own.h"
#include "import/limits/memory_limit.h"

namespace isostrata {
namespace {

namespace fs = std::filesystem;

bool prepared = false;

const LoadedModule& module_of_pages() {
  static const LoadedModule found = load_module("libisostrata_oiio.so", "ISOSTRATA_OIIO", "isostrata_page_module", kPageReaderAbi);
  return found;
}

/// By its name, or by what whoever looked at it has said.
bool may_be_picture(const fs::path& file) {
  std::string name = small_letters(file.filename().string());
  while (ends_with_one_of(name, ".gz .series")) name.resize(name.rfind('.'));
  return names_pictures(name) || std::getenv(kPictureVariable) != nullptr;
}

}  // namespace

std::unique_ptr<PageReader> open_pages(const fs::path& file) {
  if (!prepared) throw Error(ErrorCode::unsupported, file.filename().string() + ": a picture by its first bytes, but not by its name; name it .tif");
  const auto* const module = static_cast<const PageModule*>(module_of_pages().entry);
  if (!module) throw Error(ErrorCode::unavailable, "OpenImageIO, which reads pictures, cannot be loaded: " + module_of_pages().problem);
  return named(file.filename().string(), [&] { return module->open(file.string()); });
}

std::size_t bytes_of(const PageLayout& layout) {
  return static_cast<std::size_t>(layout.columns) * static_cast<std::size_t>(layout.rows) * static_cast<std::size_t>(layout.layers) *
         static_cast<std::size_t>(layout.channels) * size_of(layout.type);
}

std::string picture_array_name(const fs::path& file) {
  const std::string name = small_letters(file.filename().string());
  if (name.ends_with(".png")) return "PNGImage";
  if (name.ends_with(".bmp")) return "BMPImage";
  if (name.ends_with(".exr")) return "EXRImage";
  return ends_with_one_of(name, ".pnm .pgm") ? "PNMImage" : "Tiff Scalars";
}

void check_pages(const ReadRequest& request, const PageLayout& layout, std::uint64_t pages, std::uint64_t stored, const std::string& name) {
  const auto bytes = static_cast<std::uint64_t>(
      checked_product({layout.columns, layout.rows, layout.layers, layout.channels, static_cast<std::int64_t>(size_of(layout.type)), static_cast<std::int64_t>(pages)}, name));
  check_unpacked(bytes, stored, name);
  check_bytes(request, bytes, name);
}

std::array<double, 2> spacing_of(const std::array<double, 2>& said, std::int64_t slices, std::vector<std::string>& notes) {
  constexpr double kNear = 1e-6;  // numbers of pixels on an inch are of 32 bits
  if (slices == 1 || (std::abs(said[0] - 1) < kNear && std::abs(said[1] - 1) < kNear)) return said;
  std::ostringstream text;
  text << "pixels are " << said[0] << " x " << said[1] << " mm apart, which says nothing of slices: all points are 1 apart";
  notes.push_back(text.str());
  return {1, 1};
}

Imported picture_volume(const fs::path& file, const PageLayout& layout, std::int64_t slices, const std::array<double, 3>& spacing, std::shared_ptr<const void> storage,
                        std::span<const std::byte> values) {
  Imported imported;
  Block& block = imported.blocks.emplace_back();
  place_image(block, {layout.columns, layout.rows, slices * layout.layers}, {0, 0, 0}, {{{spacing[0], 0, 0}, {0, spacing[1], 0}, {0, 0, spacing[2]}}}, file.filename().string());
  FileArray& array = block.arrays.emplace_back();
  array.name = picture_array_name(file);
  array.type = layout.type;
  array.components = layout.channels;
  array.values = values;
  array.storage = std::move(storage);
  return imported;
}

void prepare_pictures(const fs::path& file) {
  prepared = may_be_picture(file);
  if (prepared) static_cast<void>(module_of_pages());
}

}  // namespace isostrata
