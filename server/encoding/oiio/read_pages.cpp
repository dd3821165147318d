// Picture files through OpenImageIO, as the import child reads them; no other process of ours does.
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "data/values/page_reader.h"

namespace isostrata {
namespace {

/// Its values as the file has them: colours times nothing, no colour space changed.
class OiioPages final : public PageReader {
 public:
  explicit OiioPages(const std::string& path) : place_(path) {
    OIIO::attribute("threads", 1);
    OIIO::attribute("exr_threads", -1);
    OIIO::ImageSpec wishes;
    wishes.attribute("oiio:UnassociatedAlpha", 1);
    input_ = OIIO::ImageInput::open(place_, &wishes);
    if (!input_) refuse(OIIO::geterror());
    look();
  }

  /// False: there are no more pages.
  bool next_page() override {
    if (!input_->seek_subimage(page_ + 1, 0)) {
      static_cast<void>(input_->geterror());
      return false;
    }
    ++page_;
    look();
    return true;
  }
  const PageLayout& layout() const override { return layout_; }
  std::array<double, 2> spacing() const override {
    const std::string unit(spec().get_string_attribute("ResolutionUnit"));
    const double length = unit == "in" ? 25.4 : unit == "cm" ? 10 : 0;
    const double x = spec().get_float_attribute("XResolution", 0), y = spec().get_float_attribute("YResolution", 0);
    return length > 0 && x > 0 && y > 0 ? std::array{length / x, length / y} : std::array{1.0, 1.0};
  }

  void read(std::span<std::byte> to) override {
    const auto row = static_cast<std::ptrdiff_t>(format_.size()) * layout_.columns * layout_.channels;
    std::byte* const begin = layout_.bottom_first ? to.data() : to.data() + row * (layout_.rows - 1);
    const bool good = input_->read_image(page_, 0, 0, layout_.channels, format_, begin, OIIO::AutoStride, layout_.bottom_first ? row : -row, row * layout_.rows);
    if (!good || input_->has_error()) refuse(input_->geterror());
    if (inverted_)
      for (std::byte& value : to) value = ~value;
    if (layout_.unused_bits == 0) return;
    if (layout_.type == ScalarType::uint8) shift<std::uint8_t>(to);
    if (layout_.type == ScalarType::uint16) shift<std::uint16_t>(to);
    if (layout_.type == ScalarType::uint32) shift<std::uint32_t>(to);
  }

 private:
  const OIIO::ImageSpec& spec() const { return input_->spec(); }
  [[noreturn]] void refuse(std::string why) const {
    for (auto at = why.find(place_); at != std::string::npos; at = why.find(place_)) why.replace(at, place_.size(), "the file");
    why = why.substr(0, why.find('\n'));
    throw std::runtime_error(why.empty() ? "it is not the picture that its name says" : why);
  }
  void look() {
    const OIIO::ImageSpec& of = spec();
    if (of.deep) throw std::domain_error("a picture of deep samples; expected one value for each channel of a pixel");
    static constexpr std::array<std::pair<OIIO::TypeDesc::BASETYPE, ScalarType>, 9> kTypes{{{OIIO::TypeDesc::UINT8, ScalarType::uint8},
                                                                                           {OIIO::TypeDesc::INT8, ScalarType::int8},
                                                                                           {OIIO::TypeDesc::UINT16, ScalarType::uint16},
                                                                                           {OIIO::TypeDesc::INT16, ScalarType::int16},
                                                                                           {OIIO::TypeDesc::UINT32, ScalarType::uint32},
                                                                                           {OIIO::TypeDesc::INT32, ScalarType::int32},
                                                                                           {OIIO::TypeDesc::HALF, ScalarType::float32},
                                                                                           {OIIO::TypeDesc::FLOAT, ScalarType::float32},
                                                                                           {OIIO::TypeDesc::DOUBLE, ScalarType::float64}}};
    const auto type = std::find_if(kTypes.begin(), kTypes.end(), [&](const auto& known) { return known.first == of.format.basetype; });
    if (type == kTypes.end())
      throw std::domain_error("pixels of type " + std::string(of.format.c_str()) + "; expected whole numbers of at most 4 bytes, or real ones");
    layout_ = {of.width, of.height, std::max(of.depth, 1), of.nchannels, type->second};
    format_ = of.format.basetype == OIIO::TypeDesc::HALF ? OIIO::TypeDesc(OIIO::TypeDesc::FLOAT) : of.format;
    if (layout_.columns < 1 || layout_.rows < 1 || layout_.channels < 1) refuse("it has no pixels");
    const int bits = of.get_int_attribute("oiio:BitsPerSample", 0), all = static_cast<int>(8 * format_.size());
    const bool whole = layout_.type == ScalarType::uint8 || layout_.type == ScalarType::uint16 || layout_.type == ScalarType::uint32;
    if (whole && bits > 0 && bits < all && !palette()) layout_.unused_bits = all - bits;
    inverted_ = layout_.type == ScalarType::uint8 && spec().get_int_attribute("tiff:PhotometricInterpretation", -1) == 0;  // 0 is white: then OpenImageIO turns bytes round, and no others
    layout_.bottom_first = of.get_int_attribute("Orientation", 1) == 4;
  }
  bool palette() const { return spec().get_int_attribute("tiff:PhotometricInterpretation", -1) == 3; }

  template <class T>
  void shift(std::span<std::byte> bytes) const {
    for (T& value : std::span(reinterpret_cast<T*>(bytes.data()), bytes.size() / sizeof(T))) value = static_cast<T>(value >> layout_.unused_bits);
  }

  const std::string place_;
  std::unique_ptr<OIIO::ImageInput> input_;
  OIIO::TypeDesc format_;  // of what is handed over
  int page_ = 0;
  bool inverted_ = false;
  PageLayout layout_;
};

std::unique_ptr<PageReader> open_pages(const std::string& path) { return std::make_unique<OiioPages>(path); }

}  // namespace
}  // namespace isostrata

extern "C" __attribute__((visibility("default"))) const isostrata::PageModule* isostrata_page_module() {
  static const isostrata::PageModule module{isostrata::kPageReaderAbi, isostrata::open_pages};
  return &module;
}
