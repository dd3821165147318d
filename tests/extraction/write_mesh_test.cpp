#include "extraction/write_mesh.h"

#include <unistd.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "data/analytic.h"
#include "extraction/small_grids.h"

namespace isostrata {
namespace {

/// A folder of its own that goes away with the test.
class WriteMesh : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() / ("isostrata-write-mesh-" + std::to_string(::getpid()));
    std::filesystem::create_directories(folder_);
    const Task task;
    const auto dataset = make_analytic("torus:12", {}, task);
    mesh_ = extract(dataset->grid, dataset->arrays[0], {{0.2, 0.4}, {0.4, 0.7}});
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::string write(const std::string& name, const std::vector<MeshArray>& more = {}, WriteOptions options = {}) {
    write_mesh(folder_ / name, mesh_, "a <\"b\"> & c", more, options, Task());
    std::ifstream in(folder_ / name, std::ios::binary);
    std::ostringstream text;
    text << in.rdbuf();
    return text.str();
  }
  std::size_t files() const {
    return static_cast<std::size_t>(
        std::distance(std::filesystem::directory_iterator(folder_), std::filesystem::directory_iterator()));
  }

  std::filesystem::path folder_;
  IntervalMesh mesh_;
};

template <class T>
T at(const std::string& bytes, std::size_t offset) {
  T value;
  std::memcpy(&value, bytes.data() + offset, sizeof(T));
  return value;
}

/// The appended bytes of the array with this name.
std::string appended(const std::string& vtu, const std::string& name) {
  const auto line = vtu.find("Name=\"" + name + "\"");
  EXPECT_NE(line, std::string::npos) << name;
  const auto offset = std::stoull(vtu.substr(vtu.find("offset=\"", line) + 8));
  const auto base = vtu.find('_', vtu.find("<AppendedData")) + 1;
  return vtu.substr(base + offset + 8, at<std::uint64_t>(vtu, base + offset));
}

TEST_F(WriteMesh, VtuHoldsWhatTheMeshHolds) {
  const std::string vtu = write("mesh.vtu", {{"other", std::vector<float>(mesh_.positions.size(), 2.5f)}});
  const std::string points = appended(vtu, "Points"), connectivity = appended(vtu, "connectivity"),
                    interval = appended(vtu, "interval");
  ASSERT_EQ(points.size(), mesh_.positions.size() * 24);
  ASSERT_EQ(connectivity.size(), mesh_.tetrahedra.size() * 32);
  ASSERT_EQ(interval.size(), mesh_.tetrahedra.size() * 4);
  double volume[2] = {0, 0};
  for (std::size_t t = 0; t < mesh_.tetrahedra.size(); ++t) {
    std::array<Vec3d, 4> p;
    for (std::size_t i = 0; i < 4; ++i)
      p[i] = at<Vec3d>(points, 24 * static_cast<std::size_t>(at<std::int64_t>(connectivity, 32 * t + 8 * i)));
    volume[at<std::int32_t>(interval, 4 * t)] += orient3d(p[0], p[1], p[2], p[3]) / 6;
  }
  for (int i = 0; i < 2; ++i) EXPECT_NEAR(volume[i], mesh_.summaries[i].signed_volume, 1e-12);
  EXPECT_EQ(at<double>(appended(vtu, "upper"), 0), mesh_.summaries[mesh_.tetrahedron_interval[0]].interval.upper);
  EXPECT_EQ(at<float>(appended(vtu, "other"), 0), 2.5f);
  EXPECT_EQ(at<double>(appended(vtu, "a &lt;&quot;b&quot;&gt; &amp; c"), 0), mesh_.values[0]) << "names are escaped";
  EXPECT_EQ(files(), 1u) << "nothing is left beside the file";
}

TEST_F(WriteMesh, PlyHoldsTheLabelledBoundary) {
  const std::string ply = write("mesh.ply");
  EXPECT_EQ(ply.rfind("ply\nformat binary_little_endian 1.0\n", 0), 0u);
  EXPECT_NE(ply.find("element face " + std::to_string(mesh_.facets.size()) + "\n"), std::string::npos);
  const auto vertices = std::stoull(ply.substr(ply.find("element vertex ") + 15));
  const auto body = ply.find("end_header\n") + 11;
  EXPECT_EQ(ply.size(), body + vertices * 32 + mesh_.facets.size() * 16);
  EXPECT_EQ(at<std::uint8_t>(ply, body + vertices * 32 + 15), static_cast<std::uint8_t>(mesh_.facets[0].label));
}

TEST_F(WriteMesh, StlHoldsTheLabelledBoundary) {
  const std::string stl = write("mesh.stl");
  ASSERT_EQ(stl.size(), 84 + 50 * mesh_.facets.size());
  EXPECT_EQ(at<std::uint32_t>(stl, 80), mesh_.facets.size());
  EXPECT_EQ(at<std::uint16_t>(stl, 84 + 48), static_cast<std::uint16_t>(mesh_.facets[0].label));
}

TEST_F(WriteMesh, RefusesAnUnknownEndingAndAFolderThatIsNotThere) {
  try {
    write("mesh.obj");
    ADD_FAILURE();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::unsupported);
  }
  try {
    write("missing/mesh.vtu");
    ADD_FAILURE();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::unavailable);
  }
  EXPECT_EQ(files(), 0u);
}

}  // namespace
}  // namespace isostrata
