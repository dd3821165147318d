// A netCDF file as its own library tells of it: for what VTK does not tell, and for values that VTK does not read.
#pragma once

#include <netcdf.h>

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "data/values/array.h"

namespace isostrata {

/// Of numbers, and of names for whole numbers (enum). `file` is where the type is known.
std::optional<ScalarType> netcdf_type(int file, nc_type type);

struct NetcdfVariable;

/// One group of a file: the root, or one in it (netCDF-4). Its own variables go by their numbers, dimensions by theirs, which are those of the whole file.
class NetcdfGroup {
 public:
  explicit NetcdfGroup(int number) : file_(number) {}

  int number() const { return file_; }
  int variables() const;
  bool has_groups() const { return !groups().empty(); }
  std::vector<NetcdfGroup> groups() const;
  /// "run/first/", of the root "".
  std::string prefix() const;
  bool has_many_axes() const;  // a variable over more than VTK reads: time and three
  bool has_dimension(const char* name) const;
  std::optional<int> variable(const std::string& name) const;
  std::string name(int variable) const;
  std::vector<int> dimensions() const;
  std::vector<int> dimensions(int variable) const;
  std::size_t length(int dimension) const;
  std::string dimension_name(int dimension) const;
  /// Whether it is Exodus II, which its name or its first bytes need not tell.
  bool is_exodus() const { return has_dimension("num_nodes") && has_dimension("num_el_blk"); }
  /// The variable that says where the points of a dimension are, over it alone and of its name: of this group, else of those that it lies in, else of the first that has it (CF 1.8, section 2.7).
  std::optional<NetcdfVariable> coordinate(int dimension) const;

  /// Nothing if it does not hold numbers. Bytes and whole numbers have a sign if it does not say otherwise.
  std::optional<ScalarType> type(int variable) const;
  /// An attribute of a variable, or of the file (NC_GLOBAL); empty if it has none of the kind.
  std::string text(int variable, const char* attribute) const;
  std::vector<double> numbers(int variable, const char* attribute) const;
  /// All of a variable; empty if it cannot be read as numbers.
  std::vector<double> values(int variable) const;

 private:
  std::optional<int> own_coordinate(int dimension) const;
  std::optional<NetcdfVariable> coordinate_below(int dimension, int depth) const;

  int file_;
};

struct NetcdfVariable {
  NetcdfGroup group;
  int variable = 0;

  std::optional<ScalarType> type() const { return group.type(variable); }
  std::string name() const { return group.name(variable); }
  std::string text(const char* attribute) const { return group.text(variable, attribute); }
  bool is_packed() const { return !group.numbers(variable, "scale_factor").empty() || !group.numbers(variable, "add_offset").empty(); }
  /// All of it, unpacked; empty if it cannot be read as numbers.
  std::vector<double> values() const;
};

/// The root of a file, which is open as long as this lives.
class NetcdfFile : public NetcdfGroup {
 public:
  /// Throws bad_data if the library cannot open it.
  explicit NetcdfFile(const std::filesystem::path& file);
  ~NetcdfFile();
  NetcdfFile(const NetcdfFile&) = delete;
  NetcdfFile& operator=(const NetcdfFile&) = delete;
};

}  // namespace isostrata
