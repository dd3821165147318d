// The one door to every codec: pictures in, a stream of frames out.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/image.h"
#include "encoding/codec.h"
#include "encoding/encode_image.h"

namespace isostrata {

/// What one frame is asked to be.
struct EncodeOrder {
  int quality = 90;         // JPEG only, 1..100
  int bitrate_kbps = 8000;  // video only: a frame gets about bitrate_kbps / frames_per_second kilobits, whenever it comes
  bool key = false;         // video only: can be decoded without those before it
  std::optional<int> quantizer;  // video only: every frame is about as good, 0..63, the lower the better, and takes what it takes; of a whole stream
};

struct EncodedFrame {
  Bytes bytes;
  bool key = true;  // always true of still pictures
};

/// One stream's encoder. One thread at a time, each frame on whichever thread; inside, the codec may use more.
class Encoder {
 public:
  virtual ~Encoder() = default;

  /// One picture in, its frame out: nothing is held back and nothing is dropped. The first frame, and the first of another size,
  /// is a key frame. Alpha is ignored by all but PNG. Throws what check_image throws, invalid_argument for an order out
  /// of range, too_large for a size that the codec cannot hold, unavailable if its library fails.
  virtual EncodedFrame encode(const Image& image, const EncodeOrder& order) = 0;
  virtual Codec codec() const = 0;
  /// Who does the work: "libvpx v1.12.0", "libjpeg-turbo".
  virtual const std::string& implementation() const = 0;
};

struct EncoderOptions {
  double frames_per_second = 30;  // that bit rates are meant at
  int threads = 0;                // that the codec itself may start; 0: by picture size and thread_count()
};

/// Throws unavailable if this build or this machine does not have the codec, saying what was tried.
std::unique_ptr<Encoder> make_encoder(Codec codec, const EncoderOptions& options = {});

/// Codecs for frames in motion that work here, the best first; JPEG is always the last. A video codec is tried on frames when
/// first asked (any thread); the answer stays.
const std::vector<Codec>& moving_codecs();

}  // namespace isostrata
