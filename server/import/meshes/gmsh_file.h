// Gmsh's .msh: its sections, and the numbers in them as text or binary.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "import/bytes/text_numbers.h"

namespace isostrata {

/// What the file's first section says.
struct GmshForm {
  int version = 0;  // 2 or 4
  bool binary = false, swapped = false;
};

/// The numbers of a section, one after the other. Throws bad_data if it ends before them.
class GmshNumbers {
 public:
  GmshNumbers(std::string_view section, const GmshForm& form, const std::string& name) : words_(section, name), form_(form) {}

  /// A whole number: of 32 bits in binary files, or of 64.
  std::int64_t integer(const char* what) { return form_.binary ? binary<std::int32_t>(what) : words_.integer(what, std::int64_t{1} << 53); }
  std::int64_t size(const char* what) { return form_.binary ? static_cast<std::int64_t>(binary<std::uint64_t>(what)) : words_.integer(what, std::int64_t{1} << 53); }
  double real(const char* what) { return form_.binary ? binary<double>(what) : words_.number(what); }
  /// How many follow that take at least so many bytes each. Throws bad_data if these cannot be in what is left.
  std::int64_t count(std::int64_t said, std::size_t least_bytes, const char* what) const;
  /// Text stands in lines in binary files, too.
  TextNumbers& words() { return words_; }
  const GmshForm& form() const { return form_; }

 private:
  template <class T>
  T binary(const char* what);

  TextNumbers words_;
  GmshForm form_;
};

struct GmshFile {
  GmshForm form;
  std::vector<std::pair<std::string_view, std::string_view>> sections;  // name without the '$', and what is between its line and that of its end

  /// `name` is the file's, for messages; the text must outlive it. Throws bad_data, and unsupported for other versions than 2.0 to 2.2 and 4.1.
  GmshFile(std::string_view text, const std::string& name);
  /// The first of this name; empty if there is none.
  std::string_view section(std::string_view of) const;
};

}  // namespace isostrata
