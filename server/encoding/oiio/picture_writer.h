// Between the program and the module that writes picture files with OpenImageIO. Both are of one build: whoever changes this
// changes kPictureWriterAbi.
//
// A module, because OpenImageIO brings some 240 libraries: in the program itself they cost each process 80 MiB of memory and each
// start a third of a second, for files that few ask for. PNG and WebP, which are written often, are not its work.
#pragma once

#include <cstddef>
#include <memory>
#include <string>

namespace isostrata {

inline constexpr int kPictureWriterAbi = 1;

struct PictureSpec {
  std::string path;    // of the file that is written
  std::string format;  // "tiff", "openexr", "jpeg"
  int width = 0, height = 0;
  int channels = 4;     // R G B, A, Z
  bool floats = false;  // linear light, colours multiplied by alpha; else bytes of sRGB, colours as they are
  int quality = 0;      // of JPEG
};

/// One file. Not thread-safe. Everything throws std::runtime_error with the library's words.
class PictureWriter {
 public:
  virtual ~PictureWriter() = default;
  /// The next rows from the top: `pixels` are bytes or floats, `stride` bytes from one to the next.
  virtual void write(int count, const void* pixels, std::size_t stride) = 0;
  /// Nothing may be written after this; without it the file is not a picture.
  virtual void finish() = 0;
};

struct PictureModule {
  int abi = kPictureWriterAbi;
  std::string (*library)();                    // "OpenImageIO 2.4.7"
  std::string (*missing)(const char* format);  // why it cannot be written; empty: it can
  std::unique_ptr<PictureWriter> (*open)(const PictureSpec& spec);
};

}  // namespace isostrata

extern "C" const isostrata::PictureModule* isostrata_picture_module();
