// What a session shows of data that are hard to show, before a real server: a picture, or a sentence that says why there is none.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <functional>
#include <map>
#include <random>

#include "isostrata/client.h"
#include "support/served.h"

namespace isostrata::testing {
namespace {

using client::Client;

struct Place {
  double x = 0, y = 0, z = 0;  // from -1 to 1
};
double apart(const Place& a, const Place& b = {}) { return std::hypot(a.x - b.x, a.y - b.y, a.z - b.z); }

template <class T>
void put(std::string& to, T value) {
  to.append(reinterpret_cast<const char*>(&value), sizeof value);
}

/// A file of NumPy's, float64, z slowest.
void write_npy(const std::filesystem::path& path, const std::vector<int>& dims, const std::function<double(Place)>& field) {
  std::string shape;
  std::array<int, 3> n{1, 1, 1};  // x, y, z
  for (std::size_t i = 0; i < dims.size(); ++i) {
    shape += std::to_string(dims[i]) + ",";
    n[dims.size() - 1 - i] = dims[i];
  }
  std::string head = "{'descr': '<f8', 'fortran_order': False, 'shape': (" + shape + "), }";
  while ((10 + head.size() + 1) % 64 != 0) head += ' ';
  std::string bytes = std::string("\x93NUMPY\x01", 7) + '\0';
  put(bytes, static_cast<std::uint16_t>(head.size() + 1));
  bytes += head + '\n';
  const auto place = [](int i, int of) { return of > 1 ? 2.0 * i / (of - 1) - 1 : 0.0; };
  for (int k = 0; k < n[2]; ++k)
    for (int j = 0; j < n[1]; ++j)
      for (int i = 0; i < n[0]; ++i) put(bytes, field({place(i, n[0]), place(j, n[1]), place(k, n[2])}));
  std::ofstream(path, std::ios::binary) << bytes;
}

class FirstPictures : public ::testing::Test {
 protected:
  struct Seen {
    std::string why;  // nothing is to be seen
    int layers = 0;
    double drawn = 0;     // share of the picture that is not background
    std::string refused;  // by the server, who did not open it
  };
  /// What a new session shows of the file.
  static Seen look(const std::filesystem::path& file) {
    Served server{{file.string()}};
    if (server.url().empty()) return {"", 0, 0, server.process().err()};
    Client client({.url = server.url(), .width = 160, .height = 120});
    Seen seen;
    try {
      client.open_dataset(client.welcome().datasets(0).id());
    } catch (const client::ClientError& error) {
      seen.refused = error.what();
      return seen;
    }
    seen.why = client.dataset().nothing_to_show();
    seen.layers = client.state().intervals_size();
    const client::Picture picture = client::decode(client.still(160, 120));
    int drawn = 0;
    for (std::size_t p = 0; p < picture.rgb.size(); p += 3) {
      int most = 0;
      for (std::size_t c = 0; c < 3; ++c) most = std::max(most, std::abs(int{picture.rgb[p + c]} - int{picture.rgb[c]}));
      drawn += most > 12;
    }
    seen.drawn = 3.0 * drawn / static_cast<double>(picture.rgb.size());
    return seen;
  }
  Seen look(const std::vector<int>& dims, const std::function<double(Place)>& field) {
    write_npy(folder_ / "field.npy", dims, field);
    return look(folder_ / "field.npy");
  }
  void expect_picture(const Seen& seen) {
    EXPECT_EQ(seen.refused, "");
    EXPECT_EQ(seen.why, "");
    EXPECT_GT(seen.layers, 0);
    EXPECT_GT(seen.drawn, 0.02);
  }

  TemporaryFolder folder_;
  std::mt19937_64 random_{7};
};

TEST_F(FirstPictures, OfValuesThatAreAllTheSameASentenceSaysSo) {
  const Seen seen = look({8, 8, 8}, [](Place) { return 4.0; });
  EXPECT_EQ(seen.why, "every array has one value everywhere");
  EXPECT_EQ(seen.layers, 0);
}

TEST_F(FirstPictures, OfValuesThatAreNoNumbersASentenceSaysSo) {
  EXPECT_EQ(look({8, 8, 8}, [](Place) { return NAN; }).why, "no array has a finite value");
}

TEST_F(FirstPictures, OfALineOfPointsASentenceSaysThatItHasNoInside) {
  EXPECT_NE(look({16}, [](Place p) { return p.x; }).why.find("no cells"), std::string::npos);
}

TEST_F(FirstPictures, OfOneCellIsAPicture) {
  expect_picture(look({2, 2, 2}, [](Place p) { return p.x + 2 * p.y + 4 * p.z; }));
}

TEST_F(FirstPictures, OfAPlaneIsAPicture) {
  expect_picture(look({20, 30}, [](Place p) { return p.x * p.y; }));
}

TEST_F(FirstPictures, OfALabelFieldIsAPicture) {
  expect_picture(look({24, 24, 24}, [](Place p) {
    return apart(p) < 0.4 ? 5.0 : apart(p, {0.5, 0.5, 0}) < 0.3 ? 3.0 : apart(p, {-0.6, -0.5, 0}) < 0.3 ? 1.0 : 0.0;
  }));
}

TEST_F(FirstPictures, OfNoiseIsAPicture) {
  expect_picture(look({24, 24, 24}, [&](Place) { return std::uniform_real_distribution<double>(0, 1)(random_); }));
}

TEST_F(FirstPictures, OfValuesThatNearlyAllLieInOneBinIsAPicture) {
  expect_picture(look({24, 24, 24}, [](Place p) { return apart(p) < 0.5 ? 1e9 * (1 + p.x) : 1e-6 * p.y; }));
}

TEST_F(FirstPictures, OfAThousandSpecksIsAPicture) {
  expect_picture(
      look({32, 32, 32}, [&](Place) { return std::uniform_real_distribution<double>(0, 1)(random_) > 0.95 ? 1.0 : 0.0; }));
}

TEST_F(FirstPictures, OfValuesThatAreInfiniteIsAPictureOfTheOthers) {
  expect_picture(look({24, 24, 24}, [](Place p) { return p.x > 0.5 ? INFINITY : p.x < -0.5 ? -INFINITY : p.y; }));
}

TEST_F(FirstPictures, OfPointsThatAreNowhereASentenceSaysSo) {
  constexpr int kSide = 6, kPoints = kSide * kSide * kSide;  // PLOT3D, as C writes it
  std::string grid, solution;
  for (int a = 0; a < 3; ++a) put(grid, kSide), put(solution, kSide);
  for (const int stride : {1, kSide, kSide * kSide})
    for (int p = 0; p < kPoints; ++p) put(grid, p == kPoints - 1 ? INFINITY : static_cast<float>(p / stride % kSide));
  for (int i = 0; i < 4; ++i) put(solution, 1.0f);
  for (int i = 0; i < 5 * kPoints; ++i) put(solution, static_cast<float>(i % 17));
  folder_.write("far.q", solution);
  const Seen seen = look(folder_.write("far.xyz", grid));
  EXPECT_NE((seen.why + seen.refused).find("finite"), std::string::npos) << seen.why << seen.refused;
}

}  // namespace
}  // namespace isostrata::testing
