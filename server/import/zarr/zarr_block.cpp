#include "import/zarr/zarr_block.h"

#include <memory>
#include <tuple>
#include <vector>

#include "import/imported/appended_file.h"

namespace isostrata {

ZarrCount add_zarr_arrays(ZarrStore& store, const ZarrArray& array, const ZarrBox& box, const ReadRequest& request, const std::function<std::string(std::size_t)>& name, Block& block) {
  const auto bytes = static_cast<std::uint64_t>(checked_product({box.size[0], box.size[1], box.size[2], static_cast<std::int64_t>(size_of(array.type))}, array.file));
  check_bytes(request, array.chunk_bytes(), array.file + ": one chunk");
  const std::size_t before = block.arrays.size();
  block.arrays.resize(before + static_cast<std::size_t>(box.size[3]));
  std::vector<std::unique_ptr<AppendedFile<std::byte>>> files(block.arrays.size() - before);  // open from a channel's first value to its last
  std::vector<std::uint64_t> written(files.size());
  const auto add = [&](std::size_t c, std::span<const std::byte> values) {
    if (!files[c]) files[c] = std::make_unique<AppendedFile<std::byte>>(request, "array_" + std::to_string(before + c) + ".bin");
    files[c]->add(values);
    if ((written[c] += values.size()) < bytes) return;
    FileArray& one = block.arrays[before + c];
    std::tie(one.values, one.storage) = files[c]->finish();
    one.type = array.type;
    one.name = name(c);
  };
  return read_zarr_box(store, array, box, add, request.progress);
}

void note_missing(const ZarrCount& count, std::vector<std::string>& notes) {
  if (count.missing > 0) notes.push_back(std::to_string(count.missing) + " of " + std::to_string(count.chunks) + " chunks are not there and hold the fill value");
}

}  // namespace isostrata
