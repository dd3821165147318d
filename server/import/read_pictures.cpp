// Pictures as slices: the pages of a TIFF, numbered files of one size.
#include <algorithm>
#include <optional>
#include <stdexcept>

#include "base/load_module.h"
#include "data/file_series.h"
#include "data/page_reader.h"
#include "data/recognise.h"
#include "import/memory_limit.h"
#include "import/place_image.h"
#include "import/read_own.h"

namespace isostrata {
namespace {

namespace fs = std::filesystem;

const LoadedModule& module_of_pages() {
  static const LoadedModule found = load_module("libisostrata_oiio.so", "ISOSTRATA_OIIO", "isostrata_page_module", kPageReaderAbi);
  return found;
}

/// What the reader says, with the file's name.
template <class Do>
auto named(const std::string& name, const Do& what) {
  try {
    return what();
  } catch (const std::domain_error& error) {
    throw Error(ErrorCode::unsupported, name + ": " + error.what());
  } catch (const std::runtime_error& error) {
    throw Error(ErrorCode::bad_data, name + ": " + error.what());
  }
}

std::unique_ptr<PageReader> open_pages(const fs::path& file) {
  const auto* const module = static_cast<const PageModule*>(module_of_pages().entry);
  if (!module) throw Error(ErrorCode::unavailable, "OpenImageIO, which reads pictures, cannot be loaded: " + module_of_pages().problem);
  return named(file.filename().string(), [&] { return module->open(file.string()); });
}

std::size_t bytes_of(const PageLayout& layout) {
  return static_cast<std::size_t>(layout.columns) * static_cast<std::size_t>(layout.rows) * static_cast<std::size_t>(layout.layers) *
         static_cast<std::size_t>(layout.channels) * size_of(layout.type);
}

std::string text_of(const PageLayout& layout) {
  return std::to_string(layout.columns) + " x " + std::to_string(layout.rows) + " pixels of " + std::to_string(layout.channels) + " components";
}

/// As VTK calls what it reads of these, by which saved scenes know it.
std::string array_name(const fs::path& file) {
  const std::string name = small_letters(file.filename().string());
  if (name.ends_with(".png")) return "PNGImage";
  if (name.ends_with(".bmp")) return "BMPImage";
  if (name.ends_with(".exr")) return "EXRImage";
  return ends_with_one_of(name, ".pnm .pgm") ? "PNMImage" : "Tiff Scalars";
}

void check_size(const ReadRequest& request, const PageLayout& layout, std::uint64_t pages, std::uint64_t stored, const std::string& name) {
  const auto bytes = static_cast<std::uint64_t>(
      checked_product({layout.columns, layout.rows, layout.layers, layout.channels, static_cast<std::int64_t>(size_of(layout.type)), static_cast<std::int64_t>(pages)}, name));
  check_unpacked(bytes, stored, name);
  check_bytes(request, bytes, name);
}

Imported volume_of(const fs::path& file, const PageLayout& layout, std::int64_t slices, const std::array<double, 2>& spacing, std::shared_ptr<const void> storage,
                   std::span<const std::byte> values) {
  Imported imported;
  Block& block = imported.blocks.emplace_back();
  place_image(block, {layout.columns, layout.rows, slices * layout.layers}, {0, 0, 0}, {{{spacing[0], 0, 0}, {0, spacing[1], 0}, {0, 0, 1}}}, file.filename().string());
  FileArray& array = block.arrays.emplace_back();
  array.name = array_name(file);
  array.type = layout.type;
  array.components = layout.channels;
  array.values = values;
  array.storage = std::move(storage);
  return imported;
}

}  // namespace

void prepare_pictures(const fs::path& file) {
  if (names_pictures(file)) static_cast<void>(module_of_pages());
}

Imported read_tiff(const ReadRequest& request) {
  const std::string name = request.file.filename().string();
  check_step(request, 1);
  std::uint64_t pages = 1, others = 0;
  PageLayout layout;
  std::array<double, 2> spacing{};
  {
    const auto first = open_pages(request.file);
    layout = first->layout();
    spacing = first->spacing();
    named(name, [&] {
      while (first->next_page()) ++(first->layout() == layout ? pages : others);
    });
  }
  check_size(request, layout, pages, fs::file_size(request.file), name);
  auto [storage, values] = allocate<std::byte>(bytes_of(layout) * pages);
  const auto picture = open_pages(request.file);
  named(name, [&] {
    for (std::uint64_t page = 0; page < pages;) {
      if (picture->layout() == layout) {
        picture->read(values.subspan(bytes_of(layout) * page, bytes_of(layout)));
        request.progress(static_cast<double>(++page) / static_cast<double>(pages));
      }
      if (page < pages && !picture->next_page()) throw std::runtime_error("it ends within its pages");
    }
  });
  Imported imported = volume_of(request.file, layout, static_cast<std::int64_t>(pages), spacing, storage, values);
  if (others > 0) imported.notes.push_back(std::to_string(others) + " pages of another size or type than the first are left out");
  return imported;
}

Imported read_pictures(const ReadRequest& request) {
  check_step(request, 1);
  const std::vector<SeriesFile> files = series_files(request.file);
  std::optional<PageLayout> layout;
  std::string first_name;
  std::uint64_t stored = 0;
  std::array<double, 2> spacing{};
  for (const SeriesFile& file : files) {
    const std::string name = file.path.filename().string();
    const auto picture = open_pages(file.path);
    stored += fs::file_size(file.path);
    if (!layout) layout = picture->layout(), first_name = name, spacing = picture->spacing();
    if (picture->layout() != *layout)
      throw Error(ErrorCode::bad_data, name + ": " + text_of(picture->layout()) + "; the first slice, " + first_name + ", has " + text_of(*layout) + ", or another type");
    if (named(name, [&] { return picture->next_page(); }) && picture->layout() == *layout) throw Error(ErrorCode::unsupported, name + ": a slice of several pages; expected one page");
  }
  check_size(request, *layout, files.size(), stored, request.file.filename().string());
  auto [storage, values] = allocate<std::byte>(bytes_of(*layout) * files.size());
  for (std::size_t slice = 0; slice < files.size(); ++slice) {
    const auto picture = open_pages(files[slice].path);
    named(files[slice].path.filename().string(), [&] {
      if (picture->layout() != *layout) throw std::runtime_error("it has changed while it was read");
      picture->read(values.subspan(bytes_of(*layout) * slice, bytes_of(*layout)));
    });
    request.progress(static_cast<double>(slice + 1) / static_cast<double>(files.size()));
  }
  Imported imported = volume_of(files.front().path, *layout, static_cast<std::int64_t>(files.size()), spacing, storage, values);
  imported.notes.push_back(std::to_string(files.size()) + " pictures as slices along z, 1 apart");
  return imported;
}

}  // namespace isostrata
