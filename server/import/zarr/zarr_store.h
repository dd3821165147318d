// The files of a Zarr folder: nothing outside of it is opened, whatever its metadata says and whatever links lie in it.
#pragma once

#include <boost/json/value.hpp>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "base/descriptor.h"

namespace isostrata {

class ZarrStore {
 public:
  /// Throws not_found if the folder is not there. `folder` may be marked (data/files/beneath.h).
  explicit ZarrStore(const std::filesystem::path& folder);

  /// What errors call the folder: its name.
  const std::string& name() const { return name_; }
  /// What they call a file in it: "image.zarr/0/.zarray".
  std::string name_of(const std::string& file) const { return name_ + "/" + file; }

  /// Reads a file by its path below the folder into `bytes`; false if there is none. Throws bad_data if it is a link out of the folder, if it is not a
  /// regular file, and if it has more than `most` bytes; unavailable if it cannot be read.
  bool read(const std::string& file, std::size_t most, std::vector<std::byte>& bytes);

  /// Reads `count` bytes of it from `from` on. Throws bad_data, too, if it ends before.
  bool read_part(const std::string& file, std::uint64_t from, std::size_t count, std::vector<std::byte>& bytes);

  /// The same of JSON of at most 16 MiB and 32 levels, in which NaN and Infinity may stand without quotes. Throws bad_data if it is not valid, or not an object.
  std::optional<boost::json::object> read_json(const std::string& file);

  /// Folders in it that are arrays or groups, in the order of their names; at most so many of the first thousand.
  std::vector<std::string> parts(std::size_t most) const;

  /// Of a file in it, a link followed, which is not opened; nothing if there is none.
  std::optional<std::uint64_t> size_of(const std::string& file) const;

  /// Whether there is such a file or folder.
  bool has(const std::string& file) const;

 private:
  /// Gives none if there is no such file.
  Descriptor open_file(const std::string& file, std::uint64_t& size);
  void read_bytes(const std::string& file, const Descriptor& from, std::uint64_t at, std::vector<std::byte>& bytes) const;

  std::filesystem::path folder_;  // real
  std::string name_;
  std::filesystem::path inside_;  // the last folder of a file that was seen to lie in it
};

}  // namespace isostrata
