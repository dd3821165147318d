#include "import/hdf5/hdf5_file.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <string_view>
#include <utility>

#include "base/error.h"

namespace isostrata {
namespace {

hid_t open_hdf5(const std::filesystem::path& file) {
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);  // it prints all that it tries
  return H5Fopen(file.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
}

/// The first thing that went wrong.
std::string hdf5_reason() {
  std::string reason;
  H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, [](unsigned, const H5E_error2_t* error, void* to) -> herr_t {
    auto& text = *static_cast<std::string*>(to);
    if (text.empty() && error->desc) text = error->desc;
    return 0;
  }, &reason);
  std::replace_if(reason.begin(), reason.end(), [](unsigned char c) { return c < 32 || c > 126; }, ' ');
  return reason.empty() ? "no reason given" : reason.substr(0, 200);
}

std::optional<ScalarType> hdf5_type(hid_t type) {
  const std::size_t size = H5Tget_size(type);
  switch (H5Tget_class(type)) {
    case H5T_INTEGER: {
      const bool sign = H5Tget_sign(type) == H5T_SGN_2;
      if (size == 1) return sign ? ScalarType::int8 : ScalarType::uint8;
      if (size == 2) return sign ? ScalarType::int16 : ScalarType::uint16;
      if (size == 4) return sign ? ScalarType::int32 : ScalarType::uint32;
      if (size == 8) return sign ? ScalarType::int64 : ScalarType::uint64;
      return std::nullopt;
    }
    case H5T_FLOAT: return size <= 4 ? ScalarType::float32 : ScalarType::float64;
    case H5T_ENUM: return hdf5_type(Hdf5Handle(H5Tget_super(type), H5Tclose).id());
    default: return std::nullopt;
  }
}

hid_t hdf5_native(ScalarType type) {
  switch (type) {
    case ScalarType::int8: return H5T_NATIVE_INT8;
    case ScalarType::uint8: return H5T_NATIVE_UINT8;
    case ScalarType::int16: return H5T_NATIVE_INT16;
    case ScalarType::uint16: return H5T_NATIVE_UINT16;
    case ScalarType::int32: return H5T_NATIVE_INT32;
    case ScalarType::uint32: return H5T_NATIVE_UINT32;
    case ScalarType::int64: return H5T_NATIVE_INT64;
    case ScalarType::uint64: return H5T_NATIVE_UINT64;
    case ScalarType::float32: return H5T_NATIVE_FLOAT;
    default: return H5T_NATIVE_DOUBLE;
  }
}

/// netCDF writes an array without values for a dimension that has none.
bool is_bare_dimension(hid_t dataset) {
  const Hdf5Handle attribute(H5Aexists(dataset, "NAME") > 0 ? H5Aopen(dataset, "NAME", H5P_DEFAULT) : -1, H5Aclose);
  if (!attribute.is_there()) return false;
  const Hdf5Handle type(H5Aget_type(attribute.id()), H5Tclose);
  std::array<char, 256> text{};
  if (H5Tget_class(type.id()) != H5T_STRING || H5Tis_variable_str(type.id()) > 0 || H5Tget_size(type.id()) >= text.size() || H5Aread(attribute.id(), type.id(), text.data()) < 0) return false;
  return std::string_view(text.data()).starts_with("This is a netCDF dimension but not a netCDF variable");
}

/// Nothing if it is not an array of numbers.
std::optional<StoredArray> stored_array(hid_t dataset, const std::string& name) {
  const Hdf5Handle type(H5Dget_type(dataset), H5Tclose), space(H5Dget_space(dataset), H5Sclose);
  const int axes = H5Sget_simple_extent_ndims(space.id());
  const std::optional<ScalarType> scalars = hdf5_type(type.id());
  if (axes < 1 || !scalars || is_bare_dimension(dataset)) return std::nullopt;
  std::vector<hsize_t> sizes(static_cast<std::size_t>(axes));
  H5Sget_simple_extent_dims(space.id(), sizes.data(), nullptr);
  std::uint64_t values = 1;
  for (const hsize_t size : sizes)
    if (__builtin_mul_overflow(values, size, &values) || values > std::uint64_t{1} << 60) return std::nullopt;  // of a broken file
  StoredArray array{name, name, *scalars, {sizes.begin(), sizes.end()}};
  constexpr std::string_view kNoCoordinate = "_nc4_non_coord_";  // what netCDF puts before a name that is a dimension's as well
  if (const auto last = name.rfind('/') + 1; name.compare(last, kNoCoordinate.size(), kNoCoordinate) == 0) array.name.erase(last, kNoCoordinate.size());
  array.packed = std::ranges::any_of(std::array{"scale_factor", "add_offset", "_FillValue"}, [&](const char* attribute) { return H5Aexists(dataset, attribute) > 0; });
  array.placed = H5Aexists(dataset, "DIMENSION_LIST") > 0;
  return array;
}

/// The names in a group, in the order in which they were made, if it keeps that.
std::vector<std::string> names_in(hid_t group) {
  unsigned order = 0;
  const Hdf5Handle made(H5Gget_create_plist(group), H5Pclose);
  const bool kept = H5Pget_link_creation_order(made.id(), &order) >= 0 && (order & H5P_CRT_ORDER_INDEXED);
  std::vector<std::string> names;
  hsize_t at = 0;
  H5Literate(group, kept ? H5_INDEX_CRT_ORDER : H5_INDEX_NAME, H5_ITER_INC, &at, [](hid_t, const char* name, const H5L_info_t*, void* to) -> herr_t {
    static_cast<std::vector<std::string>*>(to)->emplace_back(name);
    return 0;
  }, &names);
  return names;
}

bool same_object(hid_t a, hid_t b) {
#if H5_VERSION_GE(1, 12, 0)
  H5O_info2_t of_a{}, of_b{};
  int order = 1;
  return H5Oget_info3(a, &of_a, H5O_INFO_BASIC) >= 0 && H5Oget_info3(b, &of_b, H5O_INFO_BASIC) >= 0 && of_a.fileno == of_b.fileno && H5Otoken_cmp(a, &of_a.token, &of_b.token, &order) >= 0 && order == 0;
#else
  H5O_info_t of_a{}, of_b{};
  return H5Oget_info(a, &of_a) >= 0 && H5Oget_info(b, &of_b) >= 0 && of_a.fileno == of_b.fileno && of_a.addr == of_b.addr;
#endif
}

/// Up to its first zero, without the blanks that Fortran leaves at its end.
std::string trimmed(std::string text) {
  text.resize(std::min(text.find('\0'), text.size()));
  text.resize(text.find_last_not_of(' ') + 1);
  return text;
}

/// An attribute that is one text of any length, as Python's h5py writes them; empty if it is not.
std::string one_text(hid_t file, const char* path, const char* attribute) {
  if (H5Aexists_by_name(file, path, attribute, H5P_DEFAULT) <= 0) return {};
  const Hdf5Handle of(H5Aopen_by_name(file, path, attribute, H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  if (!of.is_there()) return {};
  const Hdf5Handle type(H5Aget_type(of.id()), H5Tclose), space(H5Aget_space(of.id()), H5Sclose);
  if (H5Tget_class(type.id()) != H5T_STRING || H5Tis_variable_str(type.id()) <= 0 || H5Sget_simple_extent_npoints(space.id()) != 1) return {};
  char* letters = nullptr;
  if (H5Aread(of.id(), type.id(), &letters) < 0 || !letters) return {};
  std::string text(letters, strnlen(letters, 4096));
  H5free_memory(letters);
  return text;
}

/// All letters of an attribute of texts of one length, and that length; none if it is not one, or has more than `most`.
std::pair<std::string, std::size_t> letters_of(hid_t file, const char* path, const char* attribute, std::size_t most) {
  const Hdf5Handle of(H5Aopen_by_name(file, path, attribute, H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  if (!of.is_there()) return {};
  const Hdf5Handle type(H5Aget_type(of.id()), H5Tclose), space(H5Aget_space(of.id()), H5Sclose);
  const hssize_t count = H5Sget_simple_extent_npoints(space.id());
  const std::size_t size = H5Tget_size(type.id());
  if (H5Tget_class(type.id()) != H5T_STRING || H5Tis_variable_str(type.id()) > 0 || count < 1 || size < 1 || static_cast<std::size_t>(count) > most / size) return {};
  std::string text(static_cast<std::size_t>(count) * size, '\0');
  if (H5Aread(of.id(), type.id(), text.data()) < 0) return {};
  return {text, size};
}

std::vector<hsize_t> sizes_of(const std::vector<std::size_t>& sizes) { return {sizes.begin(), sizes.end()}; }

}  // namespace

Hdf5File::Hdf5File(const std::filesystem::path& file, Hdf5Walk how) : name_(file.filename().string()), file_(open_hdf5(file), H5Fclose) {
  if (!file_.is_there()) throw Error(ErrorCode::bad_data, name_ + ": is damaged or cut off, or not read: " + hdf5_reason());
  const Hdf5Handle root(H5Gopen2(file_.id(), "/", H5P_DEFAULT), H5Gclose);
  if (!root.is_there()) throw Error(ErrorCode::bad_data, name_ + ": is damaged or cut off: " + hdf5_reason());
  if (how == Hdf5Walk::all) walk(root.id(), "");
}

std::optional<StoredArray> Hdf5File::find(const std::string& path) const {
  const Hdf5Handle dataset(H5Dopen2(file_.id(), path.c_str(), H5P_DEFAULT), H5Dclose);
  return dataset.is_there() ? stored_array(dataset.id(), path) : std::nullopt;
}

bool Hdf5File::has(const char* name) const { return H5Lexists(file_.id(), name, H5P_DEFAULT) > 0; }

bool Hdf5File::has_group(const char* name) const {
  return Hdf5Handle(has(name) ? H5Gopen2(file_.id(), name, H5P_DEFAULT) : -1, H5Gclose).is_there();
}

std::string Hdf5File::text(const std::string& path, const std::string& attribute) const {
  std::string text = one_text(file_.id(), path.c_str(), attribute.c_str());
  if (text.empty()) text = letters_of(file_.id(), path.c_str(), attribute.c_str(), 4096).first;
  std::erase(text, '\0');
  return text.substr(0, text.find_last_not_of(' ') + 1);
}

std::string Hdf5File::unit(const StoredArray& array) const {
  for (const char* attribute : {"units", "unit", "Units", "Unit"})
    if (std::string said = text(array.path, attribute); !said.empty()) return said;
  return {};
}

std::vector<double> Hdf5File::numbers(const char* attribute, const std::string& path) const {
  const bool there = H5Aexists_by_name(file_.id(), path.c_str(), attribute, H5P_DEFAULT) > 0;
  const Hdf5Handle found(there ? H5Aopen_by_name(file_.id(), path.c_str(), attribute, H5P_DEFAULT, H5P_DEFAULT) : -1, H5Aclose);
  if (!found.is_there()) return {};
  const Hdf5Handle type(H5Aget_type(found.id()), H5Tclose), space(H5Aget_space(found.id()), H5Sclose);
  const hssize_t count = H5Sget_simple_extent_npoints(space.id());
  if (!hdf5_type(type.id()) || count < 1 || count > 10'000) return {};
  std::vector<double> values(static_cast<std::size_t>(count));
  return H5Aread(found.id(), H5T_NATIVE_DOUBLE, values.data()) < 0 ? std::vector<double>() : values;
}

std::vector<std::string> Hdf5File::words(const char* attribute) const {
  const auto [text, length] = letters_of(file_.id(), "/", attribute, 1 << 20);
  std::vector<std::string> out;
  for (std::size_t at = 0; at < text.size(); at += length) out.push_back(trimmed(text.substr(at, length)));
  return out;
}

std::optional<double> Hdf5File::number_beside(const char* table, std::string_view name) const {
  constexpr std::size_t kLongest = 256;
  struct Row {
    std::array<char, kLongest> name;
    double value;
  };
  const Hdf5Handle dataset(has(table) ? H5Dopen2(file_.id(), table, H5P_DEFAULT) : -1, H5Dclose);
  if (!dataset.is_there()) return std::nullopt;
  const Hdf5Handle stored(H5Dget_type(dataset.id()), H5Tclose), space(H5Dget_space(dataset.id()), H5Sclose);
  const hssize_t count = H5Sget_simple_extent_npoints(space.id());
  if (H5Tget_class(stored.id()) != H5T_COMPOUND || H5Tget_member_index(stored.id(), "name") < 0 || H5Tget_member_index(stored.id(), "value") < 0 || count < 1 || count > 100'000) return std::nullopt;
  const Hdf5Handle text(H5Tcopy(H5T_C_S1), H5Tclose), row(H5Tcreate(H5T_COMPOUND, sizeof(Row)), H5Tclose);
  H5Tset_size(text.id(), kLongest);
  H5Tinsert(row.id(), "name", offsetof(Row, name), text.id());
  H5Tinsert(row.id(), "value", offsetof(Row, value), H5T_NATIVE_DOUBLE);
  std::vector<Row> rows(static_cast<std::size_t>(count));
  if (H5Dread(dataset.id(), row.id(), H5S_ALL, H5S_ALL, H5P_DEFAULT, rows.data()) < 0) return std::nullopt;
  for (const Row& one : rows)
    if (trimmed({one.name.begin(), one.name.end()}) == name) return one.value;
  return std::nullopt;
}

/// Arrays first, then groups.
void Hdf5File::walk(hid_t group, const std::string& prefix) {
  constexpr std::size_t kMostArrays = 10'000, kDeepest = 16;
  constexpr int kMostGroups = 10'000;
  if (++groups_ > kMostGroups) return;
  above_.push_back(group);
  std::vector<std::string> groups;
  for (const std::string& name : names_in(group)) {
    if (arrays_.size() >= kMostArrays) break;
    const Hdf5Handle object(H5Oopen(group, name.c_str(), H5P_DEFAULT), H5Oclose);
    const H5I_type_t kind = object.is_there() ? H5Iget_type(object.id()) : H5I_BADID;
    if (auto array = kind == H5I_DATASET ? stored_array(object.id(), prefix + name) : std::nullopt) arrays_.push_back(std::move(*array));
    if (kind == H5I_GROUP && !name.starts_with('#')) groups.push_back(name);  // MATLAB's own: "#refs#"
    lost_ += !object.is_there();
  }
  for (const std::string& name : groups) {
    const Hdf5Handle below(H5Gopen2(group, name.c_str(), H5P_DEFAULT), H5Gclose);
    if (below.is_there() && above_.size() < kDeepest && !is_above(below.id())) walk(below.id(), prefix + name + "/");
  }
  above_.pop_back();
}

bool Hdf5File::is_above(hid_t group) const {
  return std::any_of(above_.begin(), above_.end(), [&](hid_t one) { return same_object(group, one); });
}

void Hdf5File::read(const StoredArray& array, const std::vector<std::size_t>& from, const std::vector<std::size_t>& count, std::span<std::byte> to) const {
  const Hdf5Handle dataset(H5Dopen2(file_.id(), array.path.c_str(), H5P_DEFAULT), H5Dclose), space(H5Dget_space(dataset.id()), H5Sclose);
  const std::vector<hsize_t> begin = sizes_of(from), size = sizes_of(count);
  const Hdf5Handle memory(H5Screate_simple(static_cast<int>(size.size()), size.data(), nullptr), H5Sclose);
  if (H5Sselect_hyperslab(space.id(), H5S_SELECT_SET, begin.data(), nullptr, size.data(), nullptr) >= 0 &&
      H5Dread(dataset.id(), hdf5_native(array.type), memory.id(), space.id(), H5P_DEFAULT, to.data()) >= 0)
    return;
  const std::string reason = hdf5_reason();
  const Hdf5Handle made(H5Dget_create_plist(dataset.id()), H5Pclose);
  for (int f = 0; f < H5Pget_nfilters(made.id()); ++f) {
    unsigned flags = 0, settings = 0;
    std::size_t none = 0;
    std::array<char, 64> called{};
    const H5Z_filter_t filter = H5Pget_filter2(made.id(), static_cast<unsigned>(f), &flags, &none, nullptr, called.size(), called.data(), &settings);
    if (filter >= 0 && H5Zfilter_avail(filter) <= 0)
      throw Error(ErrorCode::unsupported, name_ + ": '" + array.name + "' is packed by filter " + std::to_string(filter) + (called[0] ? " (" + std::string(called.data()) + ")" : "") + ", which is not read; write it with gzip");
  }
  throw Error(ErrorCode::bad_data, name_ + ": '" + array.name + "' cannot be read: " + reason);
}

std::size_t Hdf5File::chunk(const StoredArray& array, std::size_t axis) const {
  const Hdf5Handle dataset(H5Dopen2(file_.id(), array.path.c_str(), H5P_DEFAULT), H5Dclose), made(H5Dget_create_plist(dataset.id()), H5Pclose);
  std::vector<hsize_t> sizes(array.shape.size(), 1);
  if (H5Pget_layout(made.id()) != H5D_CHUNKED || H5Pget_chunk(made.id(), static_cast<int>(sizes.size()), sizes.data()) < 0) return 1;
  return std::max<std::size_t>(static_cast<std::size_t>(sizes[axis]), 1);
}

}  // namespace isostrata
