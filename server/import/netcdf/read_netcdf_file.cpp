#include "import/netcdf/netcdf_file.h"

#include <numeric>

#include "base/error.h"

namespace isostrata {
namespace {

std::optional<ScalarType> unsigned_type(ScalarType type) {
  switch (type) {
    case ScalarType::int8: return ScalarType::uint8;
    case ScalarType::int16: return ScalarType::uint16;
    case ScalarType::int32: return ScalarType::uint32;
    case ScalarType::int64: return ScalarType::uint64;
    default: return std::nullopt;
  }
}

int opened(const std::filesystem::path& file) {
  int number = 0;
  if (const int error = nc_open(file.c_str(), NC_NOWRITE, &number); error != NC_NOERR)
    throw Error(ErrorCode::bad_data, file.filename().string() + ": cannot be read as netCDF: " + nc_strerror(error));
  return number;
}

constexpr int kDeepestGroups = 8;

}  // namespace

std::optional<ScalarType> netcdf_type(int file, nc_type type) {
  switch (type) {
    case NC_BYTE:
    case NC_CHAR: return ScalarType::int8;
    case NC_UBYTE: return ScalarType::uint8;
    case NC_SHORT: return ScalarType::int16;
    case NC_USHORT: return ScalarType::uint16;
    case NC_INT: return ScalarType::int32;
    case NC_UINT: return ScalarType::uint32;
    case NC_INT64: return ScalarType::int64;
    case NC_UINT64: return ScalarType::uint64;
    case NC_FLOAT: return ScalarType::float32;
    case NC_DOUBLE: return ScalarType::float64;
    default: break;
  }
  nc_type base = NC_NAT;
  int kind = 0;
  if (type < NC_FIRSTUSERTYPEID || nc_inq_user_type(file, type, nullptr, nullptr, &base, nullptr, &kind) != NC_NOERR || kind != NC_ENUM) return std::nullopt;
  return netcdf_type(file, base);
}

NetcdfFile::NetcdfFile(const std::filesystem::path& file) : NetcdfGroup(opened(file)) {}

NetcdfFile::~NetcdfFile() { nc_close(number()); }

std::vector<double> NetcdfVariable::values() const {
  std::vector<double> out = group.values(variable);
  const std::vector<double> scale = group.numbers(variable, "scale_factor"), offset = group.numbers(variable, "add_offset");
  for (double& value : out) value = value * (scale.size() == 1 ? scale.front() : 1) + (offset.size() == 1 ? offset.front() : 0);
  return out;
}

int NetcdfGroup::variables() const {
  int count = 0;
  return nc_inq_nvars(file_, &count) == NC_NOERR ? count : 0;
}

std::vector<NetcdfGroup> NetcdfGroup::groups() const {
  int count = 0;
  if (nc_inq_grps(file_, &count, nullptr) != NC_NOERR || count < 1) return {};
  std::vector<int> numbers(static_cast<std::size_t>(count));
  if (nc_inq_grps(file_, &count, numbers.data()) != NC_NOERR) return {};
  return {numbers.begin(), numbers.end()};
}

std::string NetcdfGroup::prefix() const {
  std::size_t length = 0;
  if (nc_inq_grpname_full(file_, &length, nullptr) != NC_NOERR || length < 2) return {};
  std::string name(length, '\0');
  if (nc_inq_grpname_full(file_, &length, name.data()) != NC_NOERR) return {};
  return name.substr(1) + "/";
}

bool NetcdfGroup::has_many_axes() const {
  for (int variable = 0; variable < variables(); ++variable)
    if (dimensions(variable).size() > 4) return true;
  return false;
}

bool NetcdfGroup::has_dimension(const char* name) const {
  int dimension = 0;
  return nc_inq_dimid(file_, name, &dimension) == NC_NOERR;
}

std::optional<int> NetcdfGroup::variable(const std::string& name) const {
  int variable = 0;
  return nc_inq_varid(file_, name.c_str(), &variable) == NC_NOERR ? std::optional(variable) : std::nullopt;
}

std::string NetcdfGroup::name(int variable) const {
  char name[NC_MAX_NAME + 1] = {};
  return nc_inq_varname(file_, variable, name) == NC_NOERR ? name : "";
}

std::vector<int> NetcdfGroup::dimensions() const {
  int count = 0;
  if (nc_inq_dimids(file_, &count, nullptr, 0) != NC_NOERR || count < 1) return {};
  std::vector<int> dimensions(static_cast<std::size_t>(count));
  return nc_inq_dimids(file_, &count, dimensions.data(), 0) == NC_NOERR ? dimensions : std::vector<int>{};
}

std::vector<int> NetcdfGroup::dimensions(int variable) const {
  int count = 0;
  if (nc_inq_varndims(file_, variable, &count) != NC_NOERR || count < 1) return {};
  std::vector<int> dimensions(static_cast<std::size_t>(count));
  return nc_inq_vardimid(file_, variable, dimensions.data()) == NC_NOERR ? dimensions : std::vector<int>{};
}

std::size_t NetcdfGroup::length(int dimension) const {
  std::size_t length = 0;
  return nc_inq_dimlen(file_, dimension, &length) == NC_NOERR ? length : 0;
}

std::string NetcdfGroup::dimension_name(int dimension) const {
  char name[NC_MAX_NAME + 1] = {};
  return nc_inq_dimname(file_, dimension, name) == NC_NOERR ? name : "";
}

std::optional<int> NetcdfGroup::own_coordinate(int dimension) const {
  const std::optional<int> found = variable(dimension_name(dimension));
  return found && dimensions(*found) == std::vector{dimension} ? found : std::nullopt;
}

std::optional<NetcdfVariable> NetcdfGroup::coordinate_below(int dimension, int depth) const {
  if (const std::optional<int> own = own_coordinate(dimension)) return NetcdfVariable{*this, *own};
  if (depth >= kDeepestGroups) return std::nullopt;
  for (const NetcdfGroup& group : groups())
    if (const auto found = group.coordinate_below(dimension, depth + 1)) return found;
  return std::nullopt;
}

std::optional<NetcdfVariable> NetcdfGroup::coordinate(int dimension) const {
  NetcdfGroup group = *this;
  for (int parent = 0;; group = NetcdfGroup(parent)) {
    if (const std::optional<int> own = group.own_coordinate(dimension)) return NetcdfVariable{group, *own};
    if (nc_inq_grp_parent(group.file_, &parent) != NC_NOERR) break;
  }
  return group.coordinate_below(dimension, 0);
}

std::optional<ScalarType> NetcdfGroup::type(int variable) const {
  nc_type stored = NC_NAT;
  if (nc_inq_vartype(file_, variable, &stored) != NC_NOERR) return std::nullopt;
  const std::optional<ScalarType> type = netcdf_type(file_, stored);
  const bool without_sign = text(variable, "_Unsigned") == "true" || text(variable, "signtype") == "unsigned";  // the latter of MINC
  return type && without_sign && stored != NC_CHAR ? unsigned_type(*type).value_or(*type) : type;
}

std::string NetcdfGroup::text(int variable, const char* attribute) const {
  nc_type type = NC_NAT;
  std::size_t length = 0;
  if (nc_inq_att(file_, variable, attribute, &type, &length) != NC_NOERR || length < 1) return {};
  if (type == NC_STRING) {
    std::vector<char*> strings(length);
    if (nc_get_att_string(file_, variable, attribute, strings.data()) != NC_NOERR) return {};
    const std::string first = strings.front() ? strings.front() : "";
    nc_free_string(length, strings.data());
    return first;
  }
  std::string text(length, '\0');
  if (type != NC_CHAR || nc_get_att_text(file_, variable, attribute, text.data()) != NC_NOERR) return {};
  return text.c_str();  // some end with a zero
}

std::vector<double> NetcdfGroup::numbers(int variable, const char* attribute) const {
  std::size_t length = 0;
  if (nc_inq_attlen(file_, variable, attribute, &length) != NC_NOERR || length < 1) return {};
  std::vector<double> numbers(length);
  return nc_get_att_double(file_, variable, attribute, numbers.data()) == NC_NOERR ? numbers : std::vector<double>{};
}

std::vector<double> NetcdfGroup::values(int variable) const {
  const std::vector<int> over = dimensions(variable);
  const std::size_t count = std::accumulate(over.begin(), over.end(), std::size_t{1}, [&](std::size_t all, int dimension) { return all * length(dimension); });
  std::vector<double> values(count);
  return nc_get_var_double(file_, variable, values.data()) == NC_NOERR ? values : std::vector<double>{};
}

}  // namespace isostrata
