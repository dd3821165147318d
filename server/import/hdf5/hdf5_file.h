// HDF5 by its own library: netCDF's refuses a whole file for one link to nothing or one named type, and knows no names for numbers (h5py's bool).
#pragma once

#include <hdf5.h>

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "import/bytes/array_file.h"

namespace isostrata {

/// Something of the library's that is given back.
class Hdf5Handle {
 public:
  Hdf5Handle(hid_t id, herr_t (*close)(hid_t)) : id_(id), close_(close) {}
  ~Hdf5Handle() {
    if (id_ >= 0) close_(id_);
  }
  Hdf5Handle(const Hdf5Handle&) = delete;
  Hdf5Handle& operator=(const Hdf5Handle&) = delete;
  hid_t id() const { return id_; }
  bool is_there() const { return id_ >= 0; }

 private:
  hid_t id_;
  herr_t (*close_)(hid_t);
};

enum class Hdf5Walk { all, none };

class Hdf5File : public ArrayFile {
 public:
  /// Throws bad_data if the library cannot open it. Without a walk through it arrays() is empty.
  explicit Hdf5File(const std::filesystem::path& file, Hdf5Walk walk = Hdf5Walk::all);
  /// The array of numbers with at least one axis that is at that path; nothing if none is.
  std::optional<StoredArray> find(const std::string& path) const;
  bool has(const char* name) const;
  bool has_group(const char* name) const;
  /// An attribute of a group or an array: a text, or an array of letters; empty if there is none.
  std::string text(const std::string& path, const std::string& attribute) const;
  /// An attribute, of the root if nothing else is named: its numbers; empty if it has none.
  std::vector<double> numbers(const char* attribute, const std::string& path = "/") const;
  /// Of the root, of fixed length.
  std::vector<std::string> words(const char* attribute) const;
  /// The number beside a name in a table of names and numbers, as FLASH has them; nothing if there is none.
  std::optional<double> number_beside(const char* table, std::string_view name) const;
  int lost_links() const { return lost_; }
  void read(const StoredArray& array, const std::vector<std::size_t>& from, const std::vector<std::size_t>& count, std::span<std::byte> to) const override;
  std::size_t chunk(const StoredArray& array, std::size_t axis) const override;
  std::string unit(const StoredArray& array) const override;
  std::vector<double> micrometres(const StoredArray& array) const override { return numbers("element_size_um", array.path); }

 private:
  void walk(hid_t group, const std::string& prefix);
  bool is_above(hid_t group) const;

  std::string name_;
  Hdf5Handle file_;
  std::vector<hid_t> above_;  // the groups that a walk is in: one that holds itself ends there
  int lost_ = 0, groups_ = 0;
};

}  // namespace isostrata
