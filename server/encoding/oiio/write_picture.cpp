// Picture files through OpenImageIO, as they are written.
#include <OpenImageIO/imageio.h>

#include <stdexcept>

#include "encoding/oiio/picture_writer.h"

namespace isostrata {
namespace {

class OiioWriter final : public PictureWriter {
 public:
  explicit OiioWriter(const PictureSpec& wanted) : type_(wanted.floats ? OIIO::TypeDesc::FLOAT : OIIO::TypeDesc::UINT8) {
    OIIO::ImageSpec spec(wanted.width, wanted.height, wanted.channels, type_);
    if (wanted.floats) {
      spec.channelnames = {"R", "G", "B", "A"};
      spec.alpha_channel = 3;
      if (wanted.channels == 5) spec.channelnames.emplace_back("Z"), spec.z_channel = 4;
      spec.attribute("oiio:ColorSpace", "Linear");
      spec.attribute("compression", "zip");
      spec.attribute("DateTime", "");  // else it is the time of writing, and the same picture gives other bytes a second later
    } else {
      spec.attribute("oiio:ColorSpace", "sRGB");
      if (wanted.channels == 4) spec.attribute("oiio:UnassociatedAlpha", 1);
      if (wanted.format == "jpeg") {
        spec.attribute("compression", "jpeg:" + std::to_string(wanted.quality));
        spec.attribute("jpeg:subsampling", "4:4:4");
      } else {
        spec.attribute("compression", "zip");
      }
    }
    output_ = OIIO::ImageOutput::create(wanted.format);
    if (!output_) throw std::runtime_error(OIIO::geterror());
    check(output_->open(wanted.path, spec));
  }

  void write(int count, const void* pixels, std::size_t stride) override {
    check(output_->write_scanlines(rows_, rows_ + count, 0, type_, pixels, static_cast<OIIO::stride_t>(stride)));
    rows_ += count;
  }
  void finish() override { check(output_->close()); }

 private:
  void check(bool done) {
    if (!done) throw std::runtime_error(output_->geterror());
  }

  OIIO::TypeDesc type_;
  std::unique_ptr<OIIO::ImageOutput> output_;
  int rows_ = 0;
};

std::string library() {
  const int version = OIIO::openimageio_version();  // 20413 is 2.4.13
  return "OpenImageIO " + std::to_string(version / 10000) + "." + std::to_string(version / 100 % 100) + "." +
         std::to_string(version % 100);
}

std::string missing(const char* format) { return OIIO::ImageOutput::create(format) ? "" : OIIO::geterror(); }

std::unique_ptr<PictureWriter> open(const PictureSpec& spec) { return std::make_unique<OiioWriter>(spec); }

}  // namespace
}  // namespace isostrata

extern "C" __attribute__((visibility("default"))) const isostrata::PictureModule* isostrata_picture_module() {
  static const isostrata::PictureModule module{isostrata::kPictureWriterAbi, isostrata::library, isostrata::missing,
                                               isostrata::open};
  return &module;
}
