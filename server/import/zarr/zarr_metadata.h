// What the metadata of both versions of Zarr have in common, for zarr_array.cpp and the file of each version.
#pragma once

#include <boost/json/serialize.hpp>
#include <boost/json/value.hpp>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "import/zarr/zarr_array.h"

namespace isostrata {

[[noreturn]] inline void bad(const ZarrArray& array, const std::string& why) { throw Error(ErrorCode::bad_data, array.file + ": " + why); }
[[noreturn]] inline void unsupported(const ZarrArray& array, const std::string& why) { throw Error(ErrorCode::unsupported, array.file + ": " + why); }

/// JSON as an error shows it.
inline std::string shown(const boost::json::value& value) { return boost::json::serialize(value).substr(0, 60); }

/// A list of 1 to 16 whole numbers of at least 1.
std::vector<std::int64_t> zarr_sizes(const ZarrArray& array, const boost::json::object& of, const char* name);

/// Version 2's name without its order of bytes ("u2"), or version 3's ("uint16").
void take_zarr_type(ZarrArray& array, std::string_view name);

/// A filter of numbers by numcodecs' name and settings; they come in the order in which values went through them. False if it is none of those that are
/// known: delta, fixedscaleoffset, and quantize and bitround, which leave nothing to undo. Throws unsupported for one that makes another type than expected.
bool take_zarr_filter(ZarrArray& array, std::string_view id, const boost::json::object& settings);

/// What chunks that are not there hold; null is 0. After the type.
void take_zarr_fill(ZarrArray& array, const boost::json::value* value);

/// Everything but `file`, `folder` and version 2's names. They throw what read_zarr_array throws.
void take_version_2(ZarrArray& array, const boost::json::object& of);
void take_version_3(ZarrArray& array, const boost::json::object& of);

}  // namespace isostrata
