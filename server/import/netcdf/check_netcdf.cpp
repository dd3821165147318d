#include "import/netcdf/check_netcdf.h"

#include <netcdf.h>

#include <algorithm>
#include <cstdint>
#include <vector>

#include "base/error.h"

namespace isostrata {
namespace {

// The NetCDF Classic Format Specification (Unidata): big-endian; lists are tags and counts; names and values are padded to four bytes.
class Header {
 public:
  Header(std::span<const std::byte> file, const std::string& name) : file_(file), name_(name) {}

  void run() {
    if (file_.size() < 4 || std::to_integer<char>(file_[0]) != 'C' || std::to_integer<char>(file_[1]) != 'D' || std::to_integer<char>(file_[2]) != 'F') return;
    const int version = std::to_integer<int>(file_[3]);
    counts_ = version == 5 ? 8 : 4;
    begins_ = version == 1 ? 4 : 8;
    at_ = 4;
    const std::uint64_t records = count();
    const bool streaming = records == (counts_ == 8 ? ~std::uint64_t{0} : 0xffffffffu);
    dimensions();
    attributes();
    std::uint64_t record_bytes = 0, recorded = 0, last_bytes = 0, end = 0, record_end = 0;
    for (std::uint64_t left = list(); left > 0; --left) {
      text();
      bool has_records = false;
      std::uint64_t bytes = 1;
      for (std::uint64_t rank = count(); rank > 0; --rank) {
        const std::uint64_t dimension = count();
        if (dimension >= sizes_.size()) broken("a variable has a dimension that is not there");
        if (sizes_[dimension] == 0)
          has_records = true;
        else if (__builtin_mul_overflow(bytes, sizes_[dimension], &bytes))
          broken("a variable's size overflows");
      }
      attributes();
      if (__builtin_mul_overflow(bytes, width(number(4)), &bytes)) broken("a variable's size overflows");
      count();  // vsize, which is wrong for large variables
      const std::uint64_t begin = number(begins_);
      if (has_records) {
        ++recorded;
        record_bytes += bytes + (4 - bytes % 4) % 4;
        last_bytes = bytes;
        record_end = std::max(record_end, begin + bytes);
      } else {
        end = std::max(end, begin + bytes);
      }
      if (begin + bytes < begin) broken("a variable's place overflows");
    }
    if (recorded == 1) record_bytes = last_bytes;  // a single record variable is not padded
    std::uint64_t more = 0;
    if (recorded > 0 && records > 0 && !streaming) {
      if (__builtin_mul_overflow(record_bytes, records - 1, &more)) broken("its records' size overflows");
      end = std::max(end, record_end + more);
    }
    if (end > file_.size()) broken(std::to_string(end) + " bytes declared, " + std::to_string(file_.size()) + " present");
  }

 private:
  [[noreturn]] void broken(const std::string& what) const { throw Error(ErrorCode::bad_data, name_ + ": " + what); }
  std::uint64_t number(std::size_t bytes) {
    if (file_.size() - at_ < bytes) broken("ends within its header");
    std::uint64_t value = 0;
    for (std::size_t b = 0; b < bytes; ++b) value = value << 8 | std::to_integer<std::uint64_t>(file_[at_ + b]);
    at_ += bytes;
    return value;
  }
  std::uint64_t count() { return number(counts_); }
  std::uint64_t list() {
    number(4);
    return count();
  }
  void skip(std::uint64_t bytes) {
    if (bytes > file_.size() - at_ || (bytes + 3) / 4 * 4 > file_.size() - at_) broken("ends within its header");
    at_ += static_cast<std::size_t>((bytes + 3) / 4 * 4);
  }
  /// The library writes a longer one past the end of whatever it is given for it.
  void text() {
    const std::uint64_t length = count();
    if (length > NC_MAX_NAME) broken("has a name of " + std::to_string(length) + " letters; expected at most " + std::to_string(NC_MAX_NAME));
    skip(length);
  }
  std::uint64_t width(std::uint64_t type) const {
    static constexpr std::uint64_t kWidths[] = {0, 1, 1, 2, 4, 4, 8, 1, 2, 4, 8, 8};
    if (type < 1 || type > 11) broken("a variable or attribute is of type " + std::to_string(type));
    return kWidths[type];
  }
  void dimensions() {
    for (std::uint64_t left = list(); left > 0; --left) {
      text();
      sizes_.push_back(count());
    }
  }
  void attributes() {
    for (std::uint64_t left = list(); left > 0; --left) {
      text();
      const std::uint64_t of_one = width(number(4)), values = count();
      if (values > file_.size()) broken("ends within its header");
      skip(of_one * values);
    }
  }

  std::span<const std::byte> file_;
  const std::string& name_;
  std::size_t at_ = 0, counts_ = 4, begins_ = 4;
  std::vector<std::uint64_t> sizes_;
};

}  // namespace

void check_netcdf_classic(std::span<const std::byte> file, const std::string& name) { Header(file, name).run(); }

}  // namespace isostrata
