#include "import/images/dicom_header.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <string_view>
#include <vector>

#include "base/error.h"

namespace isostrata {
namespace {

constexpr std::uint32_t kUndefined = 0xffffffff;

class Parser {
 public:
  Parser(std::span<const std::byte> bytes, const std::filesystem::path& file)
      : text_(reinterpret_cast<const char*>(bytes.data()), bytes.size()), name_(file.filename().string()) {
    header_.file = file;
  }

  DicomHeader run() {
    at_ = text_.size() > 132 && text_.substr(128, 4) == "DICM" ? 132 : 0;
    explicit_ = true;
    bool meta = true;
    while (at_ + 8 <= text_.size()) {
      if (meta && number(at_, 2) != 2) {
        meta = false;
        if (header_.syntax == "1.2.840.10008.1.2.2") broken("its numbers are big-endian; expected little-endian", ErrorCode::unsupported);
        if (header_.syntax == "1.2.840.10008.1.2.1.99") broken("it is deflated; write it with an uncompressed syntax (gdcmconv --raw)", ErrorCode::unsupported);
        explicit_ = header_.syntax != "1.2.840.10008.1.2" && (!header_.syntax.empty() || looks_explicit());
      }
      const Element element = next();
      if (element.tag == 0x7fe00010) {
        header_.pixels = at_;
        header_.pixel_bytes = element.length == kUndefined ? 0 : std::min<std::size_t>(element.length, text_.size() - at_);
        return header_;
      }
      take(element);
    }
    return header_;
  }

 private:
  struct Element {
    std::uint32_t tag = 0, length = 0;
    bool sequence = false;
  };

  [[noreturn]] void broken(const std::string& what, ErrorCode code = ErrorCode::bad_data) const { throw Error(code, name_ + ": " + what); }

  std::uint32_t number(std::size_t at, std::size_t bytes) const {
    if (at + bytes > text_.size()) broken("ends within its header");
    std::uint32_t value = 0;
    for (std::size_t b = bytes; b-- > 0;) value = value << 8 | static_cast<unsigned char>(text_[at + b]);
    return value;
  }

  bool looks_explicit() const {
    const auto letter = [&](std::size_t at) { return at < text_.size() && text_[at] >= 'A' && text_[at] <= 'Z'; };
    return letter(at_ + 4) && letter(at_ + 5);
  }

  Element next() {
    Element element;
    element.tag = number(at_, 2) << 16 | number(at_ + 2, 2);
    if (!explicit_ || element.tag >> 16 == 0xfffe) {
      element.length = number(at_ + 4, 4);
      element.sequence = element.length == kUndefined || element.tag == 0x52009229 || element.tag == 0x52009230;
      at_ += 8;
      return element;
    }
    const std::string_view kind = text_.substr(at_ + 4, 2);
    for (const char* with_long : {"OB", "OD", "OF", "OL", "OV", "OW", "SQ", "SV", "UC", "UN", "UR", "UT", "UV"})
      if (kind == with_long) {
        element.length = number(at_ + 8, 4);
        element.sequence = kind == "SQ" || (kind == "UN" && element.length == kUndefined);
        at_ += 12;
        return element;
      }
    element.length = number(at_ + 6, 2);
    at_ += 8;
    return element;
  }

  /// Functional groups (5200,92xx) hold what single pictures have beside their pixels: they are walked through as if they were not nested.
  void take(const Element& element) {
    const std::uint32_t group = element.tag >> 16;
    if (group == 0xfffe || element.tag == 0x52009229 || element.tag == 0x52009230) {
      in_groups_ = true;
      return;
    }
    if (element.sequence && in_groups_) return;
    if (element.length == kUndefined) return skip_items(0);
    if (element.length > text_.size() - at_) broken("ends within element " + std::to_string(element.tag));
    if (!element.sequence) read(element.tag, text_.substr(at_, element.length));
    at_ += element.length;
  }

  void skip_items(int depth) {
    if (depth > 16) broken("its sequences are nested too deep");
    while (at_ + 8 <= text_.size()) {
      const Element item = next();
      if (item.tag == 0xfffee0dd || item.tag == 0xfffee00d) return;
      if (item.length == kUndefined) {
        skip_items(depth + 1);
      } else {
        if (item.length > text_.size() - at_) broken("ends within a sequence");
        at_ += item.length;
      }
    }
  }

  template <std::size_t n>
  std::array<double, n> reals(std::string_view text, std::array<double, n> otherwise) const {
    std::array<double, n> out{};
    for (double& value : out) {
      text.remove_prefix(std::min(text.find_first_not_of(" +\\"), text.size()));
      const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
      if (error != std::errc{} || !std::isfinite(value)) return otherwise;
      text.remove_prefix(static_cast<std::size_t>(end - text.data()));
    }
    return out;
  }
  /// Numbers with a \ between two, as far as they are some.
  static std::vector<double> list(std::string_view text) {
    std::vector<double> out;
    while (!text.empty()) {
      double value = 0;
      text.remove_prefix(std::min(text.find_first_not_of(" +\\"), text.size()));
      const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
      if (error != std::errc{} || !std::isfinite(value)) break;
      out.push_back(value);
      text.remove_prefix(static_cast<std::size_t>(end - text.data()));
    }
    return out;
  }
  int word(std::string_view text) const {
    return text.size() < 2 ? 0 : static_cast<unsigned char>(text[0]) | static_cast<unsigned char>(text[1]) << 8;
  }
  static std::string plain(std::string_view text) {
    while (!text.empty() && (text.back() == ' ' || text.back() == '\0')) text.remove_suffix(1);
    return std::string(text.substr(0, 128));
  }
  int whole(std::string_view text, int otherwise) const {
    const double value = reals<1>(text, {static_cast<double>(otherwise)})[0];
    return std::abs(value) < 1e9 ? static_cast<int>(value) : otherwise;
  }

  void read(std::uint32_t tag, std::string_view text) {
    DicomHeader& h = header_;
    switch (tag) {
      case 0x00020010: h.syntax = plain(text); break;
      case 0x00080060: h.modality = plain(text); break;
      case 0x00080018: h.instance_uid = plain(text); break;
      case 0x00180088: h.between = reals<1>(text, {0})[0]; break;
      case 0x00180050: h.thickness = reals<1>(text, {h.thickness})[0]; break;
      case 0x0020000e: h.series = plain(text); break;
      case 0x00200013: h.instance = whole(text, 0); break;
      case 0x00200032: {
        const double none = std::nan("");
        const auto position = reals<3>(text, {none, none, none});
        if (std::isfinite(position[0]) && h.positions.size() < 1'000'000) h.positions.push_back(position);
        break;
      }
      case 0x00200037: h.orientation = reals<6>(text, h.orientation); break;
      case 0x00280002: h.samples = word(text); break;
      case 0x00280008: h.frames = whole(text, 1); break;
      case 0x00280010: h.rows = word(text); break;
      case 0x00280011: h.columns = word(text); break;
      case 0x00280030: h.spacing = reals<2>(text, h.spacing); break;
      case 0x00280100: h.bits = word(text); break;
      case 0x00280101: h.stored = word(text); break;
      case 0x00280103: h.is_signed = word(text); break;
      case 0x00281052: h.intercept = reals<1>(text, {0})[0]; break;
      case 0x00281053: h.slope = reals<1>(text, {1})[0]; break;
      case 0x00281054: h.rescale_type = plain(text); break;
      case 0x30040002: h.dose_unit = plain(text); break;
      case 0x3004000c: h.offsets = list(text); break;
      case 0x3004000e: h.slope = reals<1>(text, {1})[0]; break;
      default: break;
    }
  }

  std::string_view text_;
  std::string name_;
  DicomHeader header_;
  std::size_t at_ = 0;
  bool explicit_ = true, in_groups_ = false;
};

}  // namespace

DicomHeader parse_dicom(std::span<const std::byte> bytes, const std::filesystem::path& file) { return Parser(bytes, file).run(); }

}  // namespace isostrata
