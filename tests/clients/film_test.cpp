#include "film.h"

#include <gtest/gtest.h>
#include <vpx/vp8dx.h>
#include <vpx/vpx_decoder.h>
#include <zlib.h>

#include <bit>
#include <cmath>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "isostrata/client.h"
#include "support/run_isostrata.h"
#include "support/temporary_folder.h"
#include "support/webm_elements.h"
#include "yuv444.h"

namespace isostrata::client {
namespace {

using isostrata::testing::number;
using isostrata::testing::read_text;
using isostrata::testing::walk;
using Element = isostrata::testing::WebmElement;

// A picture that moves: a coloured disc before a ramp.
Picture scene(int width, int height, int frame) {
  Picture picture{width, height, {}};
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const bool inside = std::hypot(x - 20 - 2 * frame, y - height / 2) < 12;
      const auto ramp = static_cast<std::uint8_t>(60 + 100 * x / width);
      for (const std::uint8_t c :
           {inside ? std::uint8_t{230} : ramp, inside ? std::uint8_t{60} : ramp, inside ? std::uint8_t{40} : std::uint8_t{90}})
        picture.rgb.push_back(c);
    }
  return picture;
}

std::string big_endian(std::uint32_t value) {
  return {static_cast<char>(value >> 24), static_cast<char>(value >> 16), static_cast<char>(value >> 8),
          static_cast<char>(value)};
}
std::string chunk(const std::string& type, const std::string& body) {
  const std::string checked = type + body;
  return big_endian(static_cast<std::uint32_t>(body.size())) + checked +
         big_endian(static_cast<std::uint32_t>(
             crc32(0, reinterpret_cast<const Bytef*>(checked.data()), static_cast<uInt>(checked.size()))));
}
std::string png_of(const Picture& picture) {
  std::string lines;
  const auto row = static_cast<std::size_t>(picture.width) * 3;
  for (int y = 0; y < picture.height; ++y)
    lines += '\0' + std::string(reinterpret_cast<const char*>(&picture.rgb[static_cast<std::size_t>(y) * row]), row);
  std::string packed(compressBound(lines.size()), '\0');
  uLongf size = packed.size();
  compress(reinterpret_cast<Bytef*>(packed.data()), &size, reinterpret_cast<const Bytef*>(lines.data()), lines.size());
  packed.resize(size);
  return "\x89PNG\r\n\x1a\n" +
         chunk("IHDR", big_endian(static_cast<std::uint32_t>(picture.width)) +
                           big_endian(static_cast<std::uint32_t>(picture.height)) + std::string("\x08\x02\0\0\0", 5)) +
         chunk("IDAT", packed) + chunk("IEND", "");
}

// Y, U and V as they were encoded, and the mean square error against a picture's.
double error_of(const vpx_image_t& image, const Picture& picture) {
  const auto wanted = to_yuv444(picture, Matrix::bt709);
  double sum = 0;
  std::size_t at = 0;
  for (int p = 0; p < 3; ++p)
    for (unsigned y = 0; y < image.d_h; ++y)
      for (unsigned x = 0; x < image.d_w; ++x, ++at) {
        const double d = image.planes[p][y * static_cast<unsigned>(image.stride[p]) + x] - wanted[at];
        sum += d * d;
      }
  return sum / static_cast<double>(at);
}

void write_film(const std::string& path, int frames, int quality) {
  const auto film = open_film(path, {.width = 101, .height = 67, .fps = 25, .quality = quality});
  for (int i = 0; i < frames; ++i) film->add(png_of(scene(101, 67, i)));
  film->finish();
}

/// The film at `path` is these pictures, each shown for as long, within an error of `most`.
void check_film(const std::string& path, int frames, std::uint64_t frame_ms, double most, const std::function<Picture(int)>& picture) {
  const std::string file = read_text(path);
  std::vector<Element> elements;
  ASSERT_NO_FATAL_FAILURE(walk(file, 0, file.size(), elements));
  vpx_codec_ctx_t decoder{};
  ASSERT_EQ(vpx_codec_dec_init(&decoder, vpx_codec_vp9_dx(), nullptr, 0), VPX_CODEC_OK);
  int frame = 0;
  std::uint64_t cluster = 0;
  for (const Element& element : elements) {
    if (element.id == 0xE7) cluster = number(element.content);
    if (element.id != 0xA3) continue;
    EXPECT_EQ(cluster + number(element.content.substr(1, 2)), static_cast<std::uint64_t>(frame) * frame_ms);
    ASSERT_EQ(vpx_codec_decode(&decoder, reinterpret_cast<const std::uint8_t*>(element.content.data()) + 4,
                               static_cast<unsigned>(element.content.size() - 4), nullptr, 0),
              VPX_CODEC_OK);
    vpx_codec_iter_t at = nullptr;
    const vpx_image_t* image = vpx_codec_get_frame(&decoder, &at);
    ASSERT_NE(image, nullptr) << "frame " << frame;
    EXPECT_EQ(image->fmt, VPX_IMG_FMT_I444);
    EXPECT_LE(error_of(*image, picture(frame)), most) << "frame " << frame;
    ++frame;
  }
  vpx_codec_destroy(&decoder);
  EXPECT_EQ(frame, frames);
}

TEST(WebM, HoldsEveryFrameAtItsTimeAndDecodesToThePictures) {
  const isostrata::testing::TemporaryFolder folder;
  const std::string path = (folder / "a.webm").string();
  for (const int quality : {0, 20}) {
    write_film(path, 31, quality);
    check_film(path, 31, 40, quality == 0 ? 0 : 12, [](int frame) { return scene(101, 67, frame); });  // 12: 37 dB
  }
}

TEST(WebM, OfRenderIsThePicturesOfItsSteps) {
  const isostrata::testing::TemporaryFolder folder;
  const std::string film = (folder / "a.webm").string(), picture = (folder / "p.png").string();
  const std::string render = "render cylinder:16x12x8x5 --array Density --interval 0.98:0.99 --camera +z --device native --size 97x64 ";
  const auto done = isostrata::testing::run_isostrata(render + "--steps 0:4:2 --seconds 0.5 --out '" + film + "'");
  ASSERT_EQ(done.status, 0) << done.err;
  check_film(film, 3, 500, 12, [&](int frame) {
    EXPECT_EQ(isostrata::testing::run_isostrata(render + "--step " + std::to_string(2 * frame) + " --out '" + picture + "'").status, 0);
    return decode(read_text(picture));
  });
  for (const char* wrong : {"--out a.webm", "--steps 0:1 --out a-%02d.webm", "--steps 0:1 --background transparent --out a.webm", "--steps 0:1 --out /no/such/a.webm"}) {
    const auto refused = isostrata::testing::run_isostrata(render + wrong);
    EXPECT_EQ(refused.status, 1) << wrong;
    EXPECT_NE(refused.err.find("webm: "), std::string::npos) << refused.err;
  }
  EXPECT_EQ(std::filesystem::exists("a.webm"), false);
}

TEST(WebM, ItsHeadKnowsTheLengthAndWhereTheCuesAre) {
  const isostrata::testing::TemporaryFolder folder;
  const std::string path = (folder / "a.webm").string();
  write_film(path, 130, 40);  // more than one key frame
  const std::string file = read_text(path);
  std::vector<Element> elements;
  ASSERT_NO_FATAL_FAILURE(walk(file, 0, file.size(), elements));
  std::size_t segment = 0, cues = 0;
  std::vector<std::size_t> clusters, cued;
  std::uint64_t seek = 0;
  double duration = 0;
  for (const Element& e : elements) {
    if (e.id == 0x18538067) segment = static_cast<std::size_t>(e.content.data() - file.data());
    if (e.id == 0x1C53BB6B) cues = e.at;
    if (e.id == 0x1F43B675) clusters.push_back(e.at);
    if (e.id == 0xF1) cued.push_back(number(e.content) + segment);
    if (e.id == 0x53AC) seek = number(e.content);
    if (e.id == 0x4489) duration = std::bit_cast<double>(number(e.content));
  }
  EXPECT_EQ(duration, 130 * 40);
  EXPECT_EQ(seek + segment, cues);
  EXPECT_GE(clusters.size(), 2u);
  EXPECT_EQ(cued, clusters);
}

TEST(Y4m, HasAHeadAndWholeFrames) {
  const isostrata::testing::TemporaryFolder folder;
  write_film((folder / "a.y4m").string(), 3, 0);
  const std::string file = read_text(folder / "a.y4m");
  const auto head = file.find('\n') + 1;
  EXPECT_EQ(file.substr(0, head), "YUV4MPEG2 W101 H67 F25000:1000 Ip A1:1 C444 XCOLORRANGE=LIMITED\n");
  ASSERT_EQ(file.size(), head + 3 * (6 + 3 * 101 * 67));
  const auto planes = to_yuv444(scene(101, 67, 1), Matrix::bt601);
  EXPECT_EQ(file.substr(head + 6 + 3 * 101 * 67, 6), "FRAME\n");
  EXPECT_EQ(file.substr(head + 12 + 3 * 101 * 67, planes.size()), std::string(planes.begin(), planes.end()));
}

// The ends of the range, and a primary, as the recommendations' own examples have them.
TEST(Yuv, IsThatOfTheRecommendations) {
  const Picture picture{3, 1, {0, 0, 0, 255, 255, 255, 255, 0, 0}};
  EXPECT_EQ(to_yuv444(picture, Matrix::bt601), (std::vector<std::uint8_t>{16, 235, 81, 128, 128, 90, 128, 128, 240}));
  EXPECT_EQ(to_yuv444(picture, Matrix::bt709), (std::vector<std::uint8_t>{16, 235, 63, 128, 128, 102, 128, 128, 240}));
}

TEST(Films, NameNothingThatIsNotComplete) {
  const isostrata::testing::TemporaryFolder folder;
  for (const char* name : {"a.webm", "a.y4m"}) {
    { open_film((folder / name).string(), {.width = 101, .height = 67})->add(png_of(scene(101, 67, 0))); }
    EXPECT_TRUE(std::filesystem::is_empty(folder.path())) << name;
  }
  const auto pictures = open_film((folder / "p-%03d.png").string(), {});
  pictures->add("one");
  pictures->add("two");
  EXPECT_EQ(read_text(folder / "p-001.png"), "two");
}

TEST(Films, RefuseNamesAndSizesThatAreWrong) {
  for (const char* name : {"a.gif", "a.png", "a-%s.png", "a-%d-%d.png", "a-%99999d.png", "%.png"})
    EXPECT_THROW(open_film(name, {.width = 8, .height = 8}), ClientError) << name;
  EXPECT_THROW(open_film("/no/such/folder/a.y4m", {.width = 8, .height = 8}), ClientError);
  const isostrata::testing::TemporaryFolder folder;
  const auto film = open_film((folder / "a.y4m").string(), {.width = 8, .height = 8});
  EXPECT_THROW(film->add(png_of(scene(9, 8, 0))), ClientError);
}

}  // namespace
}  // namespace isostrata::client
