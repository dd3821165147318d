#include "encoding/encode_image.h"

#include "encoding/encode_still.h"
#include "encoding/image_file.h"

#include <OpenImageIO/imageio.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <turbojpeg.h>
#include <zlib.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <fstream>
#include <iterator>
#include <limits>
#include <random>
#include <thread>
#include <type_traits>
#include <utility>

#include "base/error.h"
#include "support/temporary_folder.h"

namespace isostrata {
namespace {

using ::testing::HasSubstr;
using testing::TemporaryFolder;

/// What OpenImageIO, somebody else's decoder, reads: channels as floats in the file's own meaning.
struct ReadImage {
  int width = 0, height = 0, channels = 0;
  std::vector<float> values;
  std::vector<std::string> names;
};

ReadImage read(const std::filesystem::path& path) {
  OIIO::ImageSpec wanted;
  wanted.attribute("oiio:UnassociatedAlpha", 1);
  const auto input = OIIO::ImageInput::open(path.string(), &wanted);
  if (!input) throw std::runtime_error(OIIO::geterror());
  const OIIO::ImageSpec& spec = input->spec();
  ReadImage image{spec.width, spec.height, spec.nchannels, {}, spec.channelnames};
  image.values.resize(static_cast<std::size_t>(spec.width) * static_cast<std::size_t>(spec.height) *
                      static_cast<std::size_t>(spec.nchannels));
  if (!input->read_image(0, 0, 0, spec.nchannels, OIIO::TypeDesc::FLOAT, image.values.data()))
    throw std::runtime_error(input->geterror());
  return image;
}

Bytes bytes_of(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return Bytes(std::istreambuf_iterator<char>(file), {});
}

ReadImage read_png(const Bytes& bytes) {
  const TemporaryFolder folder;
  const auto path = folder / "a.png";
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  return read(path);
}

Image noise(int width, int height, bool opaque, unsigned seed) {
  Image image{width, height, std::vector<std::uint8_t>(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * 4)};
  std::mt19937 random(seed);
  for (std::size_t i = 0; i < image.rgba.size(); ++i)
    image.rgba[i] = opaque && i % 4 == 3 ? 255 : static_cast<std::uint8_t>(random());
  return image;
}

Image gradient(int width, int height) {
  Image image{width, height, {}};
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (const int v : {x * 255 / width, y * 255 / height, (x + y) & 255, 255})
        image.rgba.push_back(static_cast<std::uint8_t>(v));
  return image;
}

void expect_same(const Image& image, const ReadImage& back, const std::string& what) {
  ASSERT_EQ(back.width, image.width) << what;
  ASSERT_EQ(back.height, image.height) << what;
  const auto channels = static_cast<std::size_t>(back.channels);
  for (std::size_t p = 0; p < image.rgba.size() / 4; ++p)
    for (std::size_t c = 0; c < channels; ++c)
      ASSERT_EQ(static_cast<int>(std::lround(back.values[p * channels + c] * 255)), image.rgba[4 * p + c])
          << what << ", pixel " << p;
}

TEST(EncodePng, EveryPixelComesBack) {
  for (const auto& [width, height] : {std::pair{1, 1}, {2, 3}, {1, 700}, {3000, 1}, {257, 129}, {800, 600}, {1500, 400}}) {
    const std::string size = std::to_string(width) + "x" + std::to_string(height);
    const Image opaque = noise(width, height, true, 1), clear = noise(width, height, false, 2), smooth = gradient(width, height);
    const ReadImage back = read_png(encode_png(opaque));
    EXPECT_EQ(back.channels, 3) << size;
    expect_same(opaque, back, size + " opaque, seed 1");
    const ReadImage with_alpha = read_png(encode_png(clear));
    EXPECT_EQ(with_alpha.channels, 4) << size;
    expect_same(clear, with_alpha, size + " with alpha, seed 2");
    expect_same(smooth, read_png(encode_png(smooth)), size + " smooth");
  }
}

void append_chunk(Bytes& out, const std::string& type, const Bytes& data) {
  const auto put = [&out](std::uint32_t v) {
    for (int i = 3; i >= 0; --i) out.push_back(static_cast<std::uint8_t>(v >> (8 * i)));
  };
  put(static_cast<std::uint32_t>(data.size()));
  const std::size_t at = out.size();
  out.insert(out.end(), type.begin(), type.end());
  out.insert(out.end(), data.begin(), data.end());
  put(static_cast<std::uint32_t>(crc32(0, &out[at], static_cast<uInt>(out.size() - at))));
}

/// The pictures of an animated PNG as single ones, in the order of their sequence numbers.
std::vector<Bytes> frames_of(const Bytes& bytes) {
  std::vector<Bytes> frames;
  Bytes header;
  std::uint32_t expected = 0;
  const auto u32 = [&](std::size_t at) {
    return static_cast<std::uint32_t>(bytes[at]) << 24 | bytes[at + 1] << 16 | bytes[at + 2] << 8 | bytes[at + 3];
  };
  for (std::size_t at = 8; at + 12 <= bytes.size();) {
    const std::size_t size = u32(at);
    const std::string type(bytes.begin() + static_cast<std::ptrdiff_t>(at) + 4,
                           bytes.begin() + static_cast<std::ptrdiff_t>(at) + 8);
    const auto data = bytes.begin() + static_cast<std::ptrdiff_t>(at) + 8;
    const Bytes content(data, data + static_cast<std::ptrdiff_t>(size));
    if (type == "IHDR") header = content;
    if (type == "acTL") {
      EXPECT_EQ(u32(at + 12), 0u) << "again and again";
    }
    if (type == "fcTL" || type == "fdAT") {
      EXPECT_EQ(u32(at + 8), expected++);
    }
    if (type == "fcTL") {
      frames.push_back(Bytes(bytes.begin(), bytes.begin() + 8));
      append_chunk(frames.back(), "IHDR", header);
    }
    if (type == "IDAT") append_chunk(frames.back(), "IDAT", content);
    if (type == "fdAT") append_chunk(frames.back(), "IDAT", Bytes(content.begin() + 4, content.end()));
    at += 12 + size;
  }
  for (Bytes& frame : frames) append_chunk(frame, "IEND", {});
  return frames;
}

TEST(EncodePng, SmoothPicturesGetSmall) {
  const Image image = gradient(800, 600);
  EXPECT_LT(encode_png(image).size(), image.rgba.size() / 8);
}

struct Decoded {
  int subsampling = -1;
  Image image;
};

Decoded decode_jpeg(const Bytes& bytes) {
  Decoded out;
  const tjhandle handle = tjInitDecompress();
  int space = 0;
  EXPECT_EQ(
      tjDecompressHeader3(handle, bytes.data(), bytes.size(), &out.image.width, &out.image.height, &out.subsampling, &space), 0);
  out.image.rgba.resize(static_cast<std::size_t>(out.image.width) * static_cast<std::size_t>(out.image.height) * 4);
  EXPECT_EQ(tjDecompress2(handle, bytes.data(), bytes.size(), out.image.rgba.data(), out.image.width, 0, out.image.height,
                          TJPF_RGBA, 0),
            0);
  tjDestroy(handle);
  return out;
}

TEST(EncodeJpeg, KeepsColourAtFullResolution) {
  Image stripes{64, 64, {}};  // red and blue columns of equal brightness, one pixel wide: 4:2:0 would make them one violet
  for (int i = 0; i < 64 * 64; ++i)
    for (const int v : {i % 2 ? 255 : 0, 0, i % 2 ? 0 : 255, 255}) stripes.rgba.push_back(static_cast<std::uint8_t>(v));
  const Decoded back = decode_jpeg(encode_jpeg(stripes, 95));
  EXPECT_EQ(back.subsampling, TJSAMP_444);
  for (std::size_t i = 0; i < stripes.rgba.size(); ++i) ASSERT_NEAR(back.image.rgba[i], stripes.rgba[i], 24) << i;
}

TEST(EncodeJpeg, QualityBuysExactnessWithBytes) {
  const Image image = gradient(320, 200);
  EXPECT_LT(encode_jpeg(image, 20).size(), encode_jpeg(image, 95).size());
  for (const int quality : {1, 100}) EXPECT_EQ(decode_jpeg(encode_jpeg(image, quality)).image.width, 320);
  for (const int quality : {-1, 0, 101}) EXPECT_THROW(encode_jpeg(image, quality), Error);
}

TEST(Encode, RefusesPicturesWhosePixelsDoNotMatchTheirSize) {
  for (const Image& image : {Image{}, Image{2, 2, std::vector<std::uint8_t>(15)}, Image{-1, 4, std::vector<std::uint8_t>(16)},
                             Image{0, 0, {}}, Image{4, 4, std::vector<std::uint8_t>(16)}}) {
    EXPECT_THROW(encode_png(image), Error);
    EXPECT_THROW(encode_jpeg(image, 90), Error);
    EXPECT_THROW(write_image("a.tif", image), Error);
  }
}

TEST(WriteImage, LosslessFormatsKeepEveryPixelAndAlpha) {
  const TemporaryFolder folder;
  for (const char* name : {"a.png", "a.tif", "A.TIFF"}) {
    const Image image = noise(37, 21, false, 3);
    write_image(folder / name, image);
    expect_same(image, read(folder / name), std::string(name) + ", seed 3");
  }
}

TEST(WriteImage, WebpKeepsEveryPixelThatIsOpaque) {
  const TemporaryFolder folder;
  const Image image = noise(64, 48, true, 4);
  write_image(folder / "a.webp", image);
  expect_same(image, read(folder / "a.webp"), "webp, seed 4");
}

TEST(EncodeStill, WebpIsLosslessAndTheSameAsTheFile) {
  const TemporaryFolder folder;
  const Image image = noise(64, 48, false, 5);
  const Bytes bytes = encode_still(image, StillFormat::webp);
  EXPECT_EQ(bytes, encode_webp(image));
  std::ofstream(folder / "a.webp", std::ios::binary).write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  const ReadImage back = read(folder / "a.webp");
  EXPECT_EQ(back.values.size(), std::size_t{64} * 48 * back.names.size());
  EXPECT_EQ(bytes, encode_still(image, StillFormat::webp)) << "the same picture gives the same bytes";
}

TEST(EncodeStill, TheSamePictureGivesTheSameBytesInAnotherSecond) {
  const Image image = noise(40, 30, false, 5);
  const Bytes exr = encode_still(image, StillFormat::exr), png = encode_still(image, StillFormat::png);
  std::this_thread::sleep_for(std::chrono::milliseconds(1100));
  EXPECT_EQ(encode_still(image, StillFormat::exr), exr);
  EXPECT_EQ(encode_still(image, StillFormat::png), png);
}

TEST(WriteImage, ExrIsLinearPremultipliedAndHasDepth) {
  const TemporaryFolder folder;
  FloatImage image{2, 1, {0.25f, 0.1f, 0.0f, 0.5f, 0, 0, 0, 0}, {3.5f, std::numeric_limits<float>::infinity()}};
  write_image(folder / "a.exr", image);
  const ReadImage back = read(folder / "a.exr");
  ASSERT_EQ(back.names, (std::vector<std::string>{"R", "G", "B", "A", "Z"}));
  EXPECT_NEAR(back.values[0], 0.5 * std::pow((0.5 + 0.055) / 1.055, 2.4), 1e-6);  // 0.5 straight, in light, times alpha
  EXPECT_NEAR(back.values[1], 0.5 * std::pow((0.2 + 0.055) / 1.055, 2.4), 1e-6);
  EXPECT_EQ(back.values[3], 0.5f);
  EXPECT_EQ(back.values[4], 3.5f);
  EXPECT_EQ(back.values[8], 0.0f);
  EXPECT_TRUE(std::isinf(back.values[9]));
  image.depth.clear();
  write_image(folder / "b.exr", image);
  EXPECT_EQ(read(folder / "b.exr").channels, 4);
}

/// Rows [first, first + count) of a picture.
template <class AnyImage>
AnyImage rows_of(const AnyImage& image, int first, int count) {
  const auto row = 4 * static_cast<std::ptrdiff_t>(image.width);
  AnyImage part = image;
  part.height = count;
  part.rgba.assign(image.rgba.begin() + first * row, image.rgba.begin() + (first + count) * row);
  if constexpr (std::is_same_v<AnyImage, FloatImage>)
    if (!image.depth.empty())
      part.depth.assign(image.depth.begin() + first * row / 4, image.depth.begin() + (first + count) * row / 4);
  return part;
}

TEST(ImageFile, BandsMakeTheFileOfTheWhole) {
  const TemporaryFolder folder;
  const Image image = noise(67, 43, false, 6);
  for (const char* name : {"a.png", "a.tif", "a.webp", "a.jpg"}) {
    write_image(folder / (std::string("whole-") + name), image);
    ImageFile file(folder / name, 67, 43, {true, false});
    for (int y = 0; y < 43; y += 9) file.put(rows_of(image, y, std::min(9, 43 - y)));
    EXPECT_FALSE(std::filesystem::exists(folder / name)) << name;
    file.finish();
    const ReadImage a = read(folder / name), b = read(folder / (std::string("whole-") + name));
    EXPECT_EQ(a.values, b.values) << name;
    EXPECT_EQ(a.channels, std::string(name) == "a.jpg" ? 3 : 4);
  }
}

TEST(ImageFile, AnAnimationIsItsPicturesInTheirOrder) {
  const TemporaryFolder folder;
  const std::vector<Image> images{noise(300, 401, true, 1), noise(300, 401, false, 2), gradient(300, 401)};
  for (const int most : {401, 150}) {  // whole pictures, and rows as they come
    ImageFile file(folder / "a.png", 300, 401, {true, false}, {3, 0.25});
    for (const Image& image : images)
      for (int y = 0; y < 401; y += most) file.put(rows_of(image, y, std::min(most, 401 - y)));
    EXPECT_EQ(std::filesystem::exists(folder / "a.png"), most == 150);
    file.finish();
    const auto frames = frames_of(bytes_of(folder / "a.png"));
    ASSERT_EQ(frames.size(), 3u);
    for (std::size_t i = 0; i < 3; ++i) expect_same(images[i], read_png(frames[i]), "picture " + std::to_string(i));
    expect_same(images[0], read(folder / "a.png"), "without animation");
  }
}

TEST(ImageFile, AnAnimationIsRefusedIfPicturesAreMissingOrTooMany) {
  const TemporaryFolder folder;
  {
    ImageFile file(folder / "a.png", 5, 4, {true, false}, {2, 1});
    EXPECT_THROW(file.put(gradient(5, 5)), Error) << "rows of two pictures at once";
    file.put(gradient(5, 4));
    EXPECT_THROW(file.finish(), Error);
    file.put(gradient(5, 4));
    EXPECT_THROW(file.put(gradient(5, 1)), Error);
  }
  EXPECT_THROW(ImageFile(folder / "a.webp", 5, 4, {true, false}, {2, 1}), Error);
  EXPECT_TRUE(std::filesystem::is_empty(folder / "."));
}

TEST(ImageFile, BandsOfFloatsKeepAlphaAndDepth) {
  const TemporaryFolder folder;
  FloatImage image{5, 33, std::vector<float>(4 * 5 * 33), std::vector<float>(5 * 33)};
  for (std::size_t p = 0; p < image.depth.size(); ++p) {
    image.depth[p] = p % 7 ? static_cast<float>(p) : std::numeric_limits<float>::infinity();
    image.rgba[4 * p + 3] = static_cast<float>(p) / 165;
    image.rgba[4 * p] = 0.5f * image.rgba[4 * p + 3];
  }
  ImageFile file(folder / "a.exr", 5, 33, {true, true});
  for (int y = 0; y < 33; y += 10) file.put(rows_of(image, y, std::min(10, 33 - y)));
  file.finish();
  const ReadImage back = read(folder / "a.exr");
  ASSERT_EQ(back.names, (std::vector<std::string>{"R", "G", "B", "A", "Z"}));
  for (std::size_t p = 0; p < image.depth.size(); ++p) {
    EXPECT_EQ(back.values[5 * p + 3], image.rgba[4 * p + 3]);
    EXPECT_EQ(back.values[5 * p + 4], image.depth[p]);
    EXPECT_NEAR(back.values[5 * p], 0.21404 * image.rgba[4 * p + 3], 1e-5);
  }
}

TEST(ImageFile, LeavesNothingBehindWhereItIsNotFinished) {
  const TemporaryFolder folder;
  for (const char* name : {"a.png", "a.exr", "a.jpg"}) {
    { ImageFile(folder / name, 8, 8, {}).put(noise(8, 4, true, 7)); }
    ImageFile file(folder / name, 8, 8, {});
    file.put(noise(8, 4, true, 7));
    EXPECT_THROW(file.finish(), Error) << name;
    EXPECT_THROW(file.put(noise(8, 5, true, 7)), Error) << name;
    EXPECT_THROW(file.put(noise(7, 1, true, 7)), Error) << name;
  }
  EXPECT_TRUE(std::filesystem::is_empty(folder / "."));
}

TEST(ImageFile, KnowsWhatFormatsCannotHold) {
  EXPECT_THROW(check_image_file("a.webp", 16384, 10, false), Error);
  EXPECT_THROW(check_image_file("a.jpg", 10, 10, true), Error);
  check_image_file("a.webp", 16383, 16383, true);
  check_image_file("a.exr", 16384, 16384, true);
}

TEST(WriteImage, SaysWhatItCannotWrite) {
  const Image image = noise(2, 2, true, 5);
  const auto message = [&](const std::filesystem::path& path) -> std::string {
    try {
      write_image(path, image);
      return "";
    } catch (const Error& error) {
      return std::string(to_string(error.code())) + ": " + error.what();
    }
  };
  EXPECT_THAT(message("picture.gif"), AllOf(HasSubstr("invalid_argument"), HasSubstr("'.gif'"), HasSubstr(".webp")));
  EXPECT_THAT(message("picture"), HasSubstr("invalid_argument"));
  for (const char* path : {"/nonexistent-folder/a.png", "/nonexistent-folder/a.exr", "/nonexistent-folder/a.tif"})
    EXPECT_THAT(message(path), AllOf(HasSubstr("unavailable"), HasSubstr(path)));
  EXPECT_THROW(check_image_path("a.bmp"), Error);
  check_image_path("a.EXR");
}

TEST(ProbeCodecs, EveryCodecOfThisBuildWorks) {
  const auto probes = probe_codecs();
  EXPECT_GE(probes.size(), 5u);
  for (const CodecProbe& probe : probes) EXPECT_TRUE(probe.ok) << probe.name << ": " << probe.detail;
}

}  // namespace
}  // namespace isostrata
