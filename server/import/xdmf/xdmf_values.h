// The numbers of XDMF's DataItems: within the XML, in HDF5, in binary files; parts of others, and others put together.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "import/bytes/array_file.h"
#include "import/bytes/mapped_file.h"
#include "import/xdmf/xdmf_file.h"

namespace isostrata {

class Hdf5File;

struct XdmfArray {
  ScalarType type = ScalarType::float32;
  std::vector<std::size_t> shape;  // the last axis is the fastest
  std::span<const std::byte> values;
  std::shared_ptr<const void> storage;

  std::size_t count() const { return values.size() / size_of(type); }
  std::vector<std::int64_t> whole() const;
  std::vector<double> real() const;
};

class XdmfValues {
 public:
  XdmfValues(const ReadRequest& request, XdmfFile& file);
  ~XdmfValues();

  /// Throws bad_data, not_found, unsupported, too_large.
  XdmfArray read(const XdmfElement& item);

 private:
  /// Some places along each axis.
  struct Slab {
    std::vector<std::size_t> from, stride, count;
  };
  XdmfArray uniform(const XdmfElement& item, const Slab* slab);
  XdmfArray of_hdf(const XdmfElement& item, const std::vector<std::size_t>& declared, const Slab* slab);
  XdmfArray of_binary(const XdmfElement& item, const std::vector<std::size_t>& declared);
  XdmfArray of_text(const XdmfElement& item, std::vector<std::size_t> declared);
  XdmfArray slab(const XdmfElement& item);
  XdmfArray joined(const XdmfElement& item);
  XdmfArray taken(const XdmfArray& from, const Slab& slab, const std::string& name);
  XdmfArray room(ScalarType type, std::vector<std::size_t> shape, std::span<std::byte>& to, const std::string& name);
  const Hdf5File& hdf(const std::filesystem::path& file);

  const ReadRequest& request_;
  XdmfFile& file_;
  std::map<std::filesystem::path, std::unique_ptr<Hdf5File>> open_;
  std::uint64_t bytes_ = 0;
  int depth_ = 0;
};

}  // namespace isostrata
