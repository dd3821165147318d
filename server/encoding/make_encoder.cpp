
#include "base/error.h"
#include "encoding/encode_vp9.h"
#include "encoding/encoder.h"

namespace isostrata {
namespace {

/// Codecs that know nothing of the picture before.
class StillEncoder final : public Encoder {
 public:
  explicit StillEncoder(Codec codec)
      : codec_(codec), implementation_(codec == Codec::jpeg ? "libjpeg-turbo" : std::string(name_of(codec))) {}
  EncodedFrame encode(const Image& image, const EncodeOrder& order) override {
    return {codec_ == Codec::jpeg ? encode_jpeg(image, order.quality) : encode_png(image), true};
  }
  Codec codec() const override { return codec_; }
  const std::string& implementation() const override { return implementation_; }

 private:
  const Codec codec_;
  const std::string implementation_;
};

bool works(Codec codec) {
  try {
    const auto encoder = make_encoder(codec);
    const Image grey{320, 240, std::vector<std::uint8_t>(320 * 240 * 4, 128)};
    return encoder->encode(grey, {}).key && !encoder->encode(grey, {}).bytes.empty();
  } catch (const Error&) {
    return false;
  }
}

}  // namespace

std::unique_ptr<Encoder> make_encoder(Codec codec, const EncoderOptions& options) {
  switch (codec) {
    case Codec::png:
    case Codec::jpeg:
      return std::make_unique<StillEncoder>(codec);
    case Codec::vp9_444:
      return make_vp9_encoder(options);
  }
  throw Error(ErrorCode::internal, "no such codec");
}

const std::vector<Codec>& moving_codecs() {
  static const std::vector<Codec> codecs = [] {
    return works(Codec::vp9_444) ? std::vector{Codec::vp9_444, Codec::jpeg} : std::vector{Codec::jpeg};
  }();
  return codecs;
}

}  // namespace isostrata
