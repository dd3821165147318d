// One header of a FITS file: cards of 80 letters in blocks of 2880 bytes.
//
// "Definition of the Flexible Image Transport System (FITS)", version 4.0, IAU 2016.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace isostrata {

class FitsHeader {
 public:
  /// The header that begins at `at`. Throws bad_data for one that does not end, or sizes that make no sense; `name` is the file's.
  FitsHeader(std::span<const std::byte> file, std::size_t at, std::string name);

  /// Of a table that holds an image in tiles: the same with the bits and the axes of the image, whose values lie elsewhere. Throws bad_data.
  FitsHeader unpacked() const;

  std::string text(const std::string& key) const;            // without quotes and trailing blanks; empty if there is none
  std::optional<double> real(const std::string& key) const;  // also with a Fortran exponent, 1.5D3
  std::int64_t whole(const std::string& key, std::int64_t otherwise) const;
  bool is_true(const std::string& key) const { return text(key) == "T"; }

  int bits() const { return bits_; }                            // BITPIX: 8, 16, 32, 64, or -32, -64 for real numbers
  const std::vector<std::int64_t>& axes() const { return axes_; }  // the first runs fastest; empty: no values
  std::size_t data() const { return data_; }                    // where they begin
  std::size_t data_bytes() const { return bytes_; }
  std::size_t next() const;                                     // where another header would begin

 private:
  void take_axes(const std::string& bits, const std::string& axes);

  std::string name_;
  std::map<std::string, std::string> cards_;
  int bits_ = 8;
  std::vector<std::int64_t> axes_;
  std::size_t data_ = 0, bytes_ = 0;
};

}  // namespace isostrata
