// Numbered pictures of one size as the slices of a volume.
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "data/files/file_series.h"
#include "import/images/picture_files.h"
#include "import/imported/read_own.h"

namespace isostrata {
namespace {

namespace fs = std::filesystem;

std::string text_of(const PageLayout& layout) {
  return std::to_string(layout.columns) + " x " + std::to_string(layout.rows) + " pixels of " + std::to_string(layout.channels) + " components";
}

}  // namespace

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
  check_pages(request, *layout, files.size(), stored, request.file.filename().string());
  auto [storage, values] = allocate<std::byte>(bytes_of(*layout) * files.size());
  for (std::size_t slice = 0; slice < files.size(); ++slice) {
    const auto picture = open_pages(files[slice].path);
    named(files[slice].path.filename().string(), [&] {
      if (picture->layout() != *layout) throw std::runtime_error("it has changed while it was read");
      picture->read(values.subspan(bytes_of(*layout) * slice, bytes_of(*layout)));
    });
    request.progress(static_cast<double>(slice + 1) / static_cast<double>(files.size()));
  }
  std::vector<std::string> notes;
  spacing = spacing_of(spacing, static_cast<std::int64_t>(files.size()) * layout->layers, notes);
  Imported imported = picture_volume(files.front().path, *layout, static_cast<std::int64_t>(files.size()), {spacing[0], spacing[1], 1}, storage, values);
  imported.notes = std::move(notes);
  imported.notes.push_back(std::to_string(files.size()) + " pictures as slices along z, 1 apart");
  return imported;
}

}  // namespace isostrata
