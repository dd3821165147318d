#include <vtkCellType.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <iterator>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "import/bytes/mapped_file.h"
#include "import/bytes/parsed_number.h"
#include "import/bytes/trimmed.h"
#include "import/imported/read_own.h"
#include "import/meshes/numbered_mesh.h"

namespace isostrata {
namespace {

const ElementKind* frd_kind(std::int64_t type) {
  static const std::array kKinds{
      ElementKind{1, 8, VTK_HEXAHEDRON, 3, {}},
      ElementKind{2, 6, VTK_WEDGE, 3, {}},
      ElementKind{3, 4, VTK_TETRA, 3, {}},
      ElementKind{4, 20, VTK_QUADRATIC_HEXAHEDRON, 3, {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 16, 17, 18, 19, 12, 13, 14, 15}},
      ElementKind{5, 15, VTK_QUADRATIC_WEDGE, 3, {0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 13, 14, 9, 10, 11}},
      ElementKind{6, 10, VTK_QUADRATIC_TETRA, 3, {}},
      ElementKind{7, 3, VTK_TRIANGLE, 2, {}},
      ElementKind{8, 6, VTK_QUADRATIC_TRIANGLE, 2, {}},
      ElementKind{9, 4, VTK_QUAD, 2, {}},
      ElementKind{10, 8, VTK_QUADRATIC_QUAD, 2, {}},
      ElementKind{11, 2, VTK_LINE, 1, {}},
      ElementKind{12, 3, VTK_QUADRATIC_EDGE, 1, {}},
  };
  return find_kind(kKinds, type);
}

/// Lines whose words stand in columns, and binary numbers behind some of them.
class FrdText {
 public:
  FrdText(std::string_view text, const std::string& name) : text_(text), name_(&name) {}

  std::size_t left() const { return text_.size(); }
  std::string_view next_line() {
    const auto end = std::min(text_.find('\n'), text_.size());
    const std::string_view line = text_.substr(0, end);
    text_.remove_prefix(std::min(end + 1, text_.size()));
    return line;
  }
  /// The line that begins with this mark, " -1" or the like.
  std::string_view line_of(std::string_view mark) {
    const std::string_view line = next_line();
    if (!line.starts_with(mark)) refuse("expected a line that begins with '" + std::string(mark) + "', not '" + printable(line) + "'");
    return line;
  }
  void skip_past(std::string_view mark) {
    const auto at = text_.find(mark);
    if (at == std::string_view::npos) refuse("is cut off, or damaged: expected ' -3'");
    text_.remove_prefix(at + mark.size());
    next_line();
  }
  std::string_view bytes(std::size_t count) {
    if (count > text_.size()) refuse("is cut off: " + std::to_string(count) + " bytes of numbers declared, " + std::to_string(text_.size()) + " present");
    const auto out = text_.substr(0, count);
    text_.remove_prefix(count);
    return out;
  }
  template <class T>
  T binary() {
    T value{};
    std::memcpy(&value, bytes(sizeof value).data(), sizeof value);
    return value;
  }
  /// The number in so many columns from the one of this place, counted from 0.
  template <class T>
  T number(std::string_view line, std::size_t from, std::size_t columns, const char* what) const {
    std::string_view word = from < line.size() ? trimmed(line.substr(from, columns)) : std::string_view();
    if (word.starts_with('+')) word.remove_prefix(1);
    const auto value = parsed_number<T>(word);
    if (!value) refuse(std::string("expected ") + what + " in column " + std::to_string(from + 1) + " of '" + printable(line) + "'");
    return *value;
  }
  std::int64_t count(std::string_view line, std::size_t least_bytes, const char* what) const {
    const auto said = number<std::int64_t>(line, 24, 12, what);
    if (said < 0 || static_cast<std::uint64_t>(said) > left() / least_bytes) refuse(std::to_string(said) + " as " + what + ", and " + std::to_string(left()) + " bytes left for them");
    return said;
  }
  /// 0, 1: text with numbers of 5 and 10 columns; 2, 3: binary with real numbers of 4 and 8 bytes.
  int form(std::string_view line) const {
    const auto form = number<int>(line, 73, 2, "the form of the numbers (0 to 3)");
    if (form < 0 || form > 3) refuse("has numbers of form " + std::to_string(form) + "; expected 0 to 3");
    return form;
  }
  [[noreturn]] void refuse(const std::string& why) const { throw Error(ErrorCode::bad_data, *name_ + ": " + why); }

 private:
  static std::string printable(std::string_view text) {
    std::string out(text.substr(0, 60));
    for (char& c : out)
      if (c < 32 || c > 126) c = ' ';
    return out;
  }

  std::string_view text_;
  const std::string* name_;
};

/// Values at nodes, and where they stand.
struct FrdValues {
  std::string name;
  std::vector<std::string> components;
  double time = 0;
  int form = 1;
  std::int64_t step = 0, tuples = 0;
  FrdText at;
};

class FrdReader {
 public:
  FrdReader(const ReadRequest& request, std::string_view text, std::string name) : request_(request), name_(std::move(name)), text_(text, name_) {}

  Imported run() {
    while (text_.left() > 0) {
      const std::string_view line = text_.next_line();
      if (line.starts_with("    2C")) read_nodes(line);
      if (line.starts_with("    3C")) read_elements(line);
      if (line.starts_with("  100C")) note_values(line);
      if (line.starts_with(" 9999")) break;
    }
    Imported imported;
    std::map<std::int64_t, double> by_step;
    for (const FrdValues& values : values_) by_step.emplace(values.step, values.time);
    if (!by_step.empty()) imported.times = times_of(by_step);
    check_step(request_, imported.times.size());
    if (request_.times_only) return imported;
    if (mesh_.elements.size() == 0) text_.refuse("has no elements; expected a block 3C");
    for (FrdValues& values : values_)
      if (values.step == std::next(by_step.begin(), request_.step)->first) add(values);
    mesh_.append_to(imported, request_);
    return imported;
  }

 private:
  void read_nodes(std::string_view head) {
    const int form = text_.form(head);
    const std::int64_t nodes = text_.count(head, 16, "the number of nodes");
    check_bytes(request_, static_cast<std::uint64_t>(nodes) * sizeof(Vec3d), name_);
    const std::size_t width = form == 0 ? 5 : 10;
    for (std::int64_t i = 0; i < nodes; ++i) {
      Vec3d& at = mesh_.points.emplace_back();
      if (form < 2) {
        const std::string_view line = text_.line_of(" -1");
        mesh_.nodes.add(text_.number<std::int64_t>(line, 3, width, "the number of a node"));
        std::size_t column = 3 + width;
        for (double* x : {&at.x, &at.y, &at.z}) *x = text_.number<double>(line, std::exchange(column, column + 12), 12, "a place");
      } else {
        mesh_.nodes.add(text_.binary<std::int32_t>());
        for (double* x : {&at.x, &at.y, &at.z}) *x = form == 2 ? static_cast<double>(text_.binary<float>()) : text_.binary<double>();
      }
    }
    mesh_.nodes.close(name_, "nodes");
  }

  void read_elements(std::string_view head) {
    const int form = text_.form(head);
    const std::int64_t elements = text_.count(head, 16, "the number of elements");
    const std::size_t width = form == 0 ? 5 : 10, in_line = form == 0 ? 15 : 10;
    std::vector<std::int64_t> nodes;
    for (std::int64_t i = 0; i < elements; ++i) {
      const std::string_view line = form < 2 ? text_.line_of(" -1") : std::string_view();
      const std::int64_t number = form < 2 ? text_.number<std::int64_t>(line, 3, width, "the number of an element") : text_.binary<std::int32_t>();
      const std::int64_t type = form < 2 ? text_.number<std::int64_t>(line, 3 + width, 5, "the type of an element") : text_.binary<std::int32_t>();
      if (form >= 2) text_.bytes(2 * sizeof(std::int32_t));  // group and material
      const ElementKind* kind = frd_kind(type);
      if (!kind) text_.refuse("element " + std::to_string(number) + " is of type " + std::to_string(type) + "; expected 1 to 12");
      nodes.clear();
      std::string_view ids;
      for (std::size_t v = 0; v < static_cast<std::size_t>(kind->nodes); ++v) {
        if (form < 2 && v % in_line == 0) ids = text_.line_of(" -2");
        nodes.push_back(form < 2 ? text_.number<std::int64_t>(ids, 3 + width * (v % in_line), width, "a node") : text_.binary<std::int32_t>());
      }
      mesh_.add_element(number, *kind, nodes, name_);
    }
    mesh_.elements.close(name_, "elements");
  }

  void note_values(std::string_view head) {
    FrdValues out{.name = {}, .components = {}, .at = text_};
    out.form = text_.form(head);
    out.time = text_.number<double>(head, 12, 12, "a time");
    out.tuples = text_.count(head, 1, "the number of values");
    out.step = text_.number<std::int64_t>(head, 58, 5, "the number of a step");
    if (!std::isfinite(out.time)) text_.refuse("a time is not a finite number");
    const std::string_view called = text_.line_of(" -4");
    out.name = trimmed(called.substr(std::min<std::size_t>(5, called.size()), 8));
    const auto components = text_.number<int>(called, 13, 5, "the number of components");
    for (int c = 0; c < components; ++c) {
      const std::string_view line = text_.line_of(" -5");
      const bool computed = line.size() > 33 && text_.number<int>(line, 33, std::min<std::size_t>(5, line.size() - 33), "whether it is computed") != 0;
      if (!computed) out.components.emplace_back(trimmed(line.substr(std::min<std::size_t>(5, line.size()), 8)));
    }
    out.at = text_;
    if (out.form < 2)
      text_.skip_past(" -3");
    else
      text_.bytes(static_cast<std::size_t>(checked_product({out.tuples, static_cast<std::int64_t>(4 + out.components.size() * (out.form == 2 ? 4 : 8))}, name_)));
    values_.push_back(std::move(out));
  }

  /// Three components are a vector; other ones are arrays of their own, "STRESS_SXX".
  void add(FrdValues& from) {
    const std::size_t components = from.components.size(), first = mesh_.arrays.size();
    if (components == 0) return;
    const bool vector = components == 3;
    check_bytes(request_, (first + components) * static_cast<std::uint64_t>(mesh_.nodes.size()) * sizeof(double), name_);
    for (const std::string& component : from.components)
      if (!vector || mesh_.arrays.size() == first) mesh_.arrays.emplace_back(components == 1 || vector ? from.name : from.name + "_" + component, false, vector ? 3 : 1, mesh_.nodes.size());
    const std::size_t width = from.form == 0 ? 5 : 10;
    for (std::int64_t i = 0; i < from.tuples; ++i) {
      std::string_view line = from.form < 2 ? from.at.line_of(" -1") : std::string_view();
      const std::int64_t number = from.form < 2 ? from.at.number<std::int64_t>(line, 3, width, "the number of a node") : from.at.binary<std::int32_t>();
      const auto node = mesh_.nodes.place(number);
      if (!node) from.at.refuse("'" + from.name + "' has values for node " + std::to_string(number) + ", which is not there");
      for (std::size_t c = 0; c < components; ++c) {
        if (from.form < 2 && c > 0 && c % 6 == 0) line = from.at.line_of(" -2");
        const double value = from.form == 2   ? static_cast<double>(from.at.binary<float>())
                             : from.form == 3 ? from.at.binary<double>()
                                              : from.at.number<double>(line, 3 + width + 12 * (c % 6), 12, "a value");
        mesh_.arrays[vector ? first : first + c].tuple(*node)[vector ? c : 0] = value;
      }
    }
  }

  const ReadRequest& request_;
  const std::string name_;
  FrdText text_;
  NumberedMesh mesh_;
  std::vector<FrdValues> values_;
};

}  // namespace

// Blocks that a line with a key begins: 2C nodes, 3C elements, 100C values at nodes. Described in CalculiX GraphiX's manual, "Result Format".
Imported read_frd(const ReadRequest& request) {
  const MappedFile file(request.file);
  return FrdReader(request, {reinterpret_cast<const char*>(file.bytes().data()), file.bytes().size()}, request.file.filename().string()).run();
}

}  // namespace isostrata
