// A TIFF: its pages are slices, or what ImageJ or OME-TIFF says that they are.
#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <map>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "import/bytes/mapped_file.h"
#include "import/bytes/swap_bytes.h"
#include "import/dataset/missing_values.h"
#include "import/images/geo_tiff.h"
#include "import/images/picture_files.h"
#include "import/images/tiff_stack.h"
#include "import/imported/appended_file.h"
#include "import/imported/place_image.h"
#include "import/imported/read_own.h"

namespace isostrata {
namespace {

namespace fs = std::filesystem;

/// All of its pages, by the layout of the first.
struct Pages {
  PageLayout layout;
  std::array<double, 2> spacing{};
  std::vector<bool> alike;
  std::int64_t count = 0;  // of those that are
};

Pages look_at_pages(const fs::path& file) {
  const auto picture = open_pages(file);
  Pages pages{picture->layout(), picture->spacing(), {true}, 1};
  named(file.filename().string(), [&] {
    while (picture->next_page()) {
      pages.alike.push_back(picture->layout() == pages.layout);
      pages.count += pages.alike.back();
    }
  });
  return pages;
}

/// Reads each page that is wanted to its place, in the order of the file.
void read_pages(const fs::path& file, const PageLayout& layout, const std::map<std::int64_t, std::span<std::byte>>& wanted, const ReadRequest& request) {
  const auto picture = open_pages(file);
  named(file.filename().string(), [&] {
    std::int64_t page = 0, done = 0;
    for (const auto& [number, to] : wanted) {
      for (; page < number; ++page)
        if (!picture->next_page()) throw std::runtime_error("it ends within its pages");
      if (picture->layout() != layout) throw std::runtime_error("it has changed while it was read");
      picture->read(to);
      request.progress(static_cast<double>(++done) / static_cast<double>(wanted.size()));
    }
  });
}

/// ImageJ's own: numbers of 16 bits that have a sign are stored with 32768 added.
void lower(std::span<std::byte> values) {
  for (std::size_t at = 1; at < values.size(); at += 2) values[at] ^= std::byte{0x80};
}

/// The values of one plane that no directory names, the lowest row first.
void copy_plane(std::span<const std::byte> from, const PageLayout& layout, bool swap, std::span<std::byte> to) {
  const std::size_t row = to.size() / static_cast<std::size_t>(layout.rows);
  for (std::size_t y = 0; y < static_cast<std::size_t>(layout.rows); ++y)
    std::memcpy(to.data() + y * row, from.data() + (layout.bottom_first ? y : static_cast<std::size_t>(layout.rows) - 1 - y) * row, row);
  if (swap) swap_bytes(to, size_of(layout.type));
}

/// Whether each plane has a page of its own, of the one layout.
bool fits(const TiffStack& stack, const Pages& pages) {
  std::vector<bool> taken(pages.alike.size());
  for (const std::int64_t page : stack.pages) {
    const auto at = static_cast<std::size_t>(page);
    if (page < 0 || at >= taken.size() || !pages.alike[at] || taken[at]) return false;
    taken[at] = true;
  }
  return true;
}

/// Throws unsupported if the values of a file with one directory for many planes do not follow each other.
void check_in_one(const TiffDirectory& directory, const TiffStack& stack, const PageLayout& layout, std::uint64_t present, const std::string& name) {
  const bool plain = directory.compression == 1 && directory.strips == 1 && directory.layout == 1 && layout.unused_bits == 0 && layout.layers == 1;
  if (!plain)
    throw Error(ErrorCode::unsupported, name + ": one page that stands for " + std::to_string(stack.planes()) + " of ImageJ, packed or in parts; save it as OME-TIFF or OME-Zarr");
  const auto bytes = static_cast<std::uint64_t>(checked_product({static_cast<std::int64_t>(bytes_of(layout)), stack.planes()}, name));
  if (directory.first_strip > present || bytes > present - directory.first_strip)
    throw Error(ErrorCode::bad_data, name + ": is cut off: " + std::to_string(stack.planes()) + " planes of ImageJ declared, " + std::to_string(bytes) + " bytes, " +
                                         std::to_string(present - std::min(present, directory.first_strip)) + " present");
}

void place(Imported& imported, const TiffStack& stack, const Pages& pages, const std::string& name) {
  const std::int64_t slices = stack.slices * pages.layout.layers;
  const std::array<double, 2> pixels = stack.placed ? std::array{stack.spacing[0], stack.spacing[1]} : spacing_of(pages.spacing, slices, imported.notes);
  const std::array<double, 3> step{pixels[0], pixels[1], stack.spacing[2]};
  place_image(imported.blocks.front(), {pages.layout.columns, pages.layout.rows, slices}, {0, 0, 0}, {{{step[0], 0, 0}, {0, step[1], 0}, {0, 0, step[2]}}}, name);
}

std::string channel_name(const TiffStack& stack, std::size_t c, const fs::path& file) {
  if (stack.channels == 1) return picture_array_name(file);
  return c < stack.names.size() && !stack.names[c].empty() ? stack.names[c] : "channel " + std::to_string(c);
}

Imported read_stack(const ReadRequest& request, const TiffStack& stack, const TiffDirectory& directory, const Pages& pages, const MappedFile& file) {
  const std::string name = request.file.filename().string();
  const bool in_one = directory.last && stack.pages_in_one && stack.planes() > 1;
  Imported imported;
  imported.times.clear();
  for (std::int64_t t = 0; t < stack.frames; ++t) imported.times.push_back(static_cast<double>(t) * (stack.interval > 0 ? stack.interval : 1));
  check_step(request, imported.times.size());
  if (in_one) check_in_one(directory, stack, pages.layout, file.bytes().size(), name);
  if (request.times_only) return imported;
  const std::int64_t planes = stack.channels * stack.slices;
  check_pages(request, pages.layout, static_cast<std::uint64_t>(planes), file.bytes().size(), name);
  Block& block = imported.blocks.emplace_back();
  place(imported, stack, pages, name);
  const std::size_t plane = bytes_of(pages.layout);
  std::map<std::int64_t, std::span<std::byte>> wanted;
  const auto page_at = [&](std::int64_t c, std::int64_t z) { return stack.pages[static_cast<std::size_t>((request.step * stack.channels + c) * stack.slices + z)]; };
  const bool raised = stack.raised && pages.layout.type == ScalarType::uint16;
  std::vector<std::byte> room(in_one ? plane : 0);
  for (std::int64_t c = 0; c < stack.channels; ++c) {
    FileArray& array = block.arrays.emplace_back();
    array.name = channel_name(stack, static_cast<std::size_t>(c), request.file);
    array.type = raised ? ScalarType::int16 : pages.layout.type;
    array.components = pages.layout.channels;
    if (in_one) {
      AppendedFile<std::byte> out(request, "array_" + std::to_string(c) + ".bin");
      for (std::int64_t z = 0; z < stack.slices; ++z) {
        copy_plane(file.bytes().subspan(directory.first_strip + static_cast<std::size_t>(page_at(c, z)) * plane, plane), pages.layout, directory.big_endian, room);
        if (raised) lower(room);
        out.add(room);
        request.progress(static_cast<double>(c * stack.slices + z + 1) / static_cast<double>(planes));
      }
      std::tie(array.values, array.storage) = out.finish();
      continue;
    }
    auto [storage, values] = allocate<std::byte>(plane * static_cast<std::size_t>(stack.slices));
    for (std::int64_t z = 0; z < stack.slices; ++z) wanted[page_at(c, z)] = values.subspan(static_cast<std::size_t>(z) * plane, plane);
    array.values = values;
    array.storage = storage;
  }
  if (!in_one) read_pages(request.file, pages.layout, wanted, request);
  if (raised && !in_one)
    for (const auto& [page, values] : wanted) lower(values);
  imported.notes.insert(imported.notes.end(), stack.notes.begin(), stack.notes.end());
  imported.axes = axes_in(stack.unit);
  if (stack.frames > 1 && stack.interval > 0) imported.notes.push_back("times are in " + stack.time_unit);
  return imported;
}

Imported read_slices(const ReadRequest& request, const Pages& pages, std::uint64_t stored) {
  const std::string name = request.file.filename().string();
  check_step(request, 1);
  if (request.times_only) return {};
  check_pages(request, pages.layout, static_cast<std::uint64_t>(pages.count), stored, name);
  const std::size_t plane = bytes_of(pages.layout);
  auto [storage, values] = allocate<std::byte>(plane * static_cast<std::size_t>(pages.count));
  std::map<std::int64_t, std::span<std::byte>> wanted;
  for (std::size_t page = 0; page < pages.alike.size(); ++page)
    if (pages.alike[page]) wanted[static_cast<std::int64_t>(page)] = values.subspan(plane * wanted.size(), plane);
  read_pages(request.file, pages.layout, wanted, request);
  std::vector<std::string> notes;
  const std::array<double, 2> spacing = spacing_of(pages.spacing, pages.count * pages.layout.layers, notes);
  Imported imported = picture_volume(request.file, pages.layout, pages.count, {spacing[0], spacing[1], 1}, storage, values);
  imported.notes = std::move(notes);
  if (const std::size_t others = pages.alike.size() - wanted.size(); others > 0)
    imported.notes.push_back(std::to_string(others) + " pages of another size or type than the first are left out");
  return imported;
}

/// North is up: y grows to the north, and the lowest row comes first, as in every picture here.
void place_on_earth(Imported& imported, const TiffDirectory& directory, const PageLayout& layout, const std::string& name) {
  const std::optional<GeoPlace> at = geo_place(directory);
  if (!at) return;
  const auto below = static_cast<double>(layout.bottom_first ? 0 : layout.rows - 1), turn = layout.bottom_first ? 1.0 : -1.0;
  Block& block = imported.blocks.front();
  place_image(block, block.grid.dims(), {at->first[0] + below * at->row[0], at->first[1] + below * at->row[1], 0},
              {{{at->column[0], at->column[1], 0}, {turn * at->row[0], turn * at->row[1], 0}, {0, 0, 1}}}, name);
  if (at->degrees) imported.axes = {Axis{"longitude", "degrees"}, Axis{"latitude", "degrees"}, Axis{}};
  imported.notes.emplace_back("placed by its GeoTIFF tags, in the middles of the pixels: x to the east, y to the north");
}

}  // namespace

Imported read_tiff(const ReadRequest& request) {
  const MappedFile file(request.file);
  const Pages pages = look_at_pages(request.file);
  const std::optional<TiffDirectory> directory = first_tiff_directory(file.bytes());
  if (leads_beyond_end(file.bytes(), pages.alike.size()))
    throw Error(ErrorCode::bad_data, request.file.filename().string() + ": is cut off: page " + std::to_string(pages.alike.size() + 1) + " lies beyond its end");
  std::string why;
  std::optional<TiffStack> stack;
  if (directory) stack = describe_tiff_stack(*directory, pages.layout.channels, why);
  if (stack && (fits(*stack, pages) || (directory->last && stack->pages_in_one && stack->planes() > 1))) return read_stack(request, *stack, *directory, pages, file);
  if (stack)
    why = "its description speaks of " + std::to_string(stack->planes()) + " pages, " + std::to_string(pages.count) + " are there: they are read as slices";
  Imported imported = read_slices(request, pages, file.bytes().size());
  if (directory && !request.times_only) {
    place_on_earth(imported, *directory, pages.layout, request.file.filename().string());
    if (const auto none = geo_no_data(*directory)) leave_out_value(imported.blocks.front().arrays.front(), *none);
  }
  if (!why.empty()) imported.notes.push_back(why);
  return imported;
}

}  // namespace isostrata
