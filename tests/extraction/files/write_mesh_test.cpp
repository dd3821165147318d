#include "extraction/files/write_mesh.h"

#include <sys/resource.h>
#include <unistd.h>
#include <zlib.h>

#include <csignal>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "data/dataset/analytic.h"
#include "extraction/files/output_file.h"
#include "extraction/files/vtk_xml.h"
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

/// The appended bytes of the array with this name, by the rules of vtkZLibDataCompressor where the file names it.
std::string appended(const std::string& vtu, const std::string& name) {
  const auto line = vtu.find("Name=\"" + name + "\"");
  EXPECT_NE(line, std::string::npos) << name;
  const auto offset = std::stoull(vtu.substr(vtu.find("offset=\"", line) + 8));
  const auto base = vtu.find('_', vtu.find("<AppendedData")) + 1 + offset;
  const auto first = at<std::uint64_t>(vtu, base);
  if (vtu.find("vtkZLibDataCompressor") == std::string::npos) return vtu.substr(base + 8, first);
  const auto block = at<std::uint64_t>(vtu, base + 8), last = at<std::uint64_t>(vtu, base + 16);
  std::string out;
  std::size_t from = base + 24 + 8 * first;
  for (std::uint64_t b = 0; b < first; ++b) {
    const auto packed = at<std::uint64_t>(vtu, base + 24 + 8 * b);
    std::string plain(b + 1 == first && last > 0 ? last : block, 0);
    uLongf size = plain.size();
    EXPECT_EQ(
        uncompress(reinterpret_cast<Bytef*>(plain.data()), &size, reinterpret_cast<const Bytef*>(vtu.data() + from), packed),
        Z_OK);
    EXPECT_EQ(size, plain.size());
    out += plain;
    from += packed;
  }
  return out;
}

TEST_F(WriteMesh, VtuHoldsWhatTheMeshHoldsCompressedOrNot) {
  for (const int compression : {0, 1, 9}) {
    WriteOptions options;
    options.compression = compression;
    const std::string vtu = write("mesh.vtu", {{"other", std::vector<float>(mesh_.positions.size(), 2.5f)}}, options);
    const std::string points = appended(vtu, "Points"), connectivity = appended(vtu, "connectivity"),
                      interval = appended(vtu, "interval");
    ASSERT_EQ(points.size(), mesh_.positions.size() * 24);
    ASSERT_EQ(connectivity.size(), mesh_.tetrahedra.size() * 16);
    ASSERT_EQ(appended(vtu, "offsets").size(), mesh_.tetrahedra.size() * 4);
    ASSERT_EQ(at<std::int32_t>(appended(vtu, "offsets"), 4), 8);
    ASSERT_EQ(interval.size(), mesh_.tetrahedra.size() * 4);
    double volume[2] = {0, 0};
    for (std::size_t t = 0; t < mesh_.tetrahedra.size(); ++t) {
      std::array<Vec3d, 4> p;
      for (std::size_t i = 0; i < 4; ++i)
        p[i] = at<Vec3d>(points, 24 * static_cast<std::size_t>(at<std::int32_t>(connectivity, 16 * t + 4 * i)));
      volume[at<std::int32_t>(interval, 4 * t)] += orient3d(p[0], p[1], p[2], p[3]) / 6;
    }
    for (int i = 0; i < 2; ++i) EXPECT_NEAR(volume[i], mesh_.summaries[i].signed_volume, 1e-12);
    EXPECT_EQ(at<double>(appended(vtu, "upper"), 0), mesh_.summaries[mesh_.tetrahedron_interval[0]].interval.upper);
    EXPECT_EQ(at<float>(appended(vtu, "other"), 0), 2.5f);
    EXPECT_EQ(at<double>(appended(vtu, "a &lt;&quot;b&quot;&gt; &amp; c"), 0), mesh_.values[0]) << "names are escaped";
    EXPECT_EQ(files(), 1u) << "nothing is left beside the file";
  }
}

TEST_F(WriteMesh, TablesOfManyBlocksAndOfNone) {
  VtkArray array{"Int32", "n", 1, 0, 4, [](std::uint64_t first, std::uint64_t last, std::byte* to) {
                   for (std::uint64_t i = first; i < last; ++i, to += 4) {
                     const auto value = static_cast<std::int32_t>(i * 7);
                     std::memcpy(to, &value, 4);
                   }
                 }};
  for (const std::uint64_t count : {0ull, 1ull, 65535ull, 65536ull, 65537ull, 70ull * 65536}) {
    array.count = count;
    std::string text = "<VTKFile compressor=\"vtkZLibDataCompressor\"><DataArray Name=\"n\" offset=\"0\"/><AppendedData>_";
    {
      OutputFile out(folder_ / "blocks");
      out.text(text);
      write_appended(out, array, 1, Task());
      out.finish();
    }
    std::ifstream in(folder_ / "blocks", std::ios::binary);
    std::ostringstream bytes;
    bytes << in.rdbuf();
    const std::string plain = appended(bytes.str(), "n");
    ASSERT_EQ(plain.size(), 4 * count);
    for (std::uint64_t i = 0; i < count; i += 1 + count / 97)
      ASSERT_EQ(at<std::int32_t>(plain, 4 * i), static_cast<std::int32_t>(i * 7));
  }
}

TEST_F(WriteMesh, OffsetsPast4GiBAreWhole) {
  // Sizes are counted in 64 bits: a hole of 5 GiB stands for what a mesh would fill.
  OutputFile out(folder_ / "far");
  out.text("begin");
  const std::uint64_t far = 5ull << 30;
  const std::string mark = "end";
  out.patch(far, std::as_bytes(std::span(mark)));
  out.finish();
  EXPECT_EQ(std::filesystem::file_size(folder_ / "far"), far + 3);
}

TEST_F(WriteMesh, AFullDiskIsAnErrorAndLeavesNothing) {
  std::signal(SIGXFSZ, SIG_IGN);
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
  rlimit small = before;
  small.rlim_cur = 10000;
  for (const char* name : {"mesh.vtu", "mesh.ply", "mesh.stl"}) {
    ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
    std::string message;
    try {
      write(name);
    } catch (const Error& error) {
      message = error.what();
      EXPECT_EQ(error.code(), ErrorCode::unavailable);
    }
    ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &before), 0);
    EXPECT_NE(message.find(name), std::string::npos) << message;
    EXPECT_NE(message.find("cannot write: File too large"), std::string::npos) << message;
    EXPECT_EQ(files(), 0u) << name;
  }
}

TEST_F(WriteMesh, CancelLeavesNothing) {
  Task task;
  task.cancel();
  for (const char* name : {"mesh.vtu", "mesh.ply", "mesh.stl"}) {
    EXPECT_THROW(write_mesh(folder_ / name, mesh_, "f", {}, {}, task), Error) << name;
    EXPECT_EQ(files(), 0u) << name;
  }
}

TEST_F(WriteMesh, PlyAndStlHoldTheChosenFacetsOnly) {
  WriteOptions options;
  options.facets = {{FacetLabel::lower, {}}, {FacetLabel::upper, std::uint16_t{1}}};
  std::size_t chosen = 0;
  for (const BoundaryFacet& f : mesh_.facets)
    chosen += f.label == FacetLabel::lower || (f.label == FacetLabel::upper && f.interval == 1);
  ASSERT_GT(chosen, 0u);
  ASSERT_LT(chosen, mesh_.facets.size());
  EXPECT_EQ(at<std::uint32_t>(write("mesh.stl", {}, options), 80), chosen);
  const std::string ply = write("mesh.ply", {{"a b", std::vector<float>(mesh_.positions.size(), 1.5f)}}, options);
  EXPECT_NE(ply.find("element face " + std::to_string(chosen) + "\n"), std::string::npos);
  EXPECT_NE(ply.find("property float a_b\n"), std::string::npos);
  const auto vertices = std::stoull(ply.substr(ply.find("element vertex ") + 15));
  const auto body = ply.find("end_header\n") + 11;
  ASSERT_EQ(ply.size(), body + vertices * 36 + chosen * 16);
  EXPECT_EQ(at<float>(ply, body + 32), 1.5f);
  for (std::size_t f = 0; f < chosen; ++f) {
    const std::size_t face = body + vertices * 36 + 16 * f;
    const auto label = at<std::uint8_t>(ply, face + 15);
    const auto& interval = mesh_.summaries[at<std::uint16_t>(ply, face + 13)].interval;
    for (std::size_t k = 0; k < 3; ++k) {
      const auto v = at<std::uint32_t>(ply, face + 1 + 4 * k);
      ASSERT_LT(v, vertices);
      ASSERT_EQ(at<double>(ply, body + 36 * v + 24), label == 0 ? interval.lower : interval.upper);
    }
  }
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
