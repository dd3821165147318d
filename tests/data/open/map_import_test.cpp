// What a hostile child could write, and what the door says to it.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <optional>

#include "data/files.h"
#include "data/open/import_door.h"

namespace isostrata {
namespace {

using test::Scratch;

template <class T>
std::string bytes_of(std::initializer_list<T> values) {
  std::string bytes;
  for (const T value : values) test::put(bytes, value);
  return bytes;
}

/// A directory with one good tetrahedron, and ways to spoil it.
class Unstructured {
 public:
  Unstructured() {
    write("points.bin", bytes_of<float>({0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1}));
    write("types.bin", bytes_of<std::uint8_t>({10}));
    write("offsets.bin", bytes_of<std::int64_t>({0, 4}));
    write("connectivity.bin", bytes_of<std::int64_t>({0, 1, 2, 3}));
    write("array_0.bin", bytes_of<float>({1, 2, 3, 4}));
    write("times.bin", bytes_of<double>({0}));
    write(
        "manifest.json",
        R"({"format":1,"grid":"unstructured","points":["float32",4],"cells":1,"connectivity":4,"hidden_cells":false,)"
        R"("axes":[{"name":"","unit":"mm","downward":false},{"name":"","unit":"mm","downward":false},{"name":"depth","unit":"m","downward":true}],)"
        R"("arrays":[{"name":"a","association":"point","components":1,"component":"","unit":"","type":"float32"}],"times":1,"step":0,"notes":[]})");
  }
  void write(const std::string& name, const std::string& bytes) { scratch_.write(name, bytes); }
  void replace(const std::string& from, const std::string& to) {
    std::string manifest = test::read_bytes(scratch_ / "manifest.json");
    const auto at = manifest.find(from);
    ASSERT_NE(at, std::string::npos) << from;
    write("manifest.json", manifest.replace(at, from.size(), to));
  }
  std::shared_ptr<const Dataset> map(const OpenOptions& options = {}) { return map_import(scratch_.path(), "t", options); }
  const Scratch& scratch() const { return scratch_; }

 private:
  Scratch scratch_;
};

TEST(MapImport, MapsWhatIsGoodAndLeavesNoFiles) {
  Unstructured good;
  const auto data = good.map();
  EXPECT_EQ(data->grid.cell_count(), 1);
  EXPECT_EQ(data->array("a").at(3), 4);
  EXPECT_EQ(axis_title(data->axes, 0), "x (mm)");
  EXPECT_EQ(axis_title(data->axes, 2), "depth (m)");
  EXPECT_TRUE(data->axes[2].downward);
  EXPECT_TRUE(std::filesystem::is_empty(good.scratch().path()));
}

TEST(MapImport, RefusesEveryInconsistency) {
  using Spoil = std::function<void(Unstructured&)>;
  const float nan = std::nanf("");
  const std::vector<std::pair<const char*, Spoil>> cases{
      {"point id too large",
       [](auto& u) {
         u.write("connectivity.bin", bytes_of<std::int64_t>({0, 1, 2, 4}));
       }},
      {"point id negative",
       [](auto& u) {
         u.write("connectivity.bin", bytes_of<std::int64_t>({0, -1, 2, 3}));
       }},
      {"point id huge",
       [](auto& u) {
         u.write("connectivity.bin", bytes_of<std::int64_t>({0, std::numeric_limits<std::int64_t>::max(), 2, 3}));
       }},
      {"unknown type", [](auto& u) { u.write("types.bin", bytes_of<std::uint8_t>({42})); }},
      {"type that needs more points", [](auto& u) { u.write("types.bin", bytes_of<std::uint8_t>({12})); }},
      {"offsets that begin late",
       [](auto& u) {
         u.write("offsets.bin", bytes_of<std::int64_t>({1, 4}));
       }},
      {"offsets beyond the connectivity",
       [](auto& u) {
         u.write("offsets.bin", bytes_of<std::int64_t>({0, 400}));
       }},
      {"offsets that fall",
       [](auto& u) {
         u.write("offsets.bin", bytes_of<std::int64_t>({0, -4}));
       }},
      {"points truncated",
       [](auto& u) {
         u.write("points.bin", bytes_of<float>({0, 0, 0}));
       }},
      {"points too many", [](auto& u) { u.write("points.bin", std::string(100, 'x')); }},
      {"points not finite",
       [&](auto& u) {
         u.write("points.bin", bytes_of<float>({0, 0, 0, 1, 0, 0, 0, nan, 0, 0, 0, 1}));
       }},
      {"array truncated",
       [](auto& u) {
         u.write("array_0.bin", bytes_of<float>({1, 2}));
       }},
      {"array missing", [](auto& u) { std::filesystem::remove(u.scratch() / "array_0.bin"); }},
      {"array a link",
       [](auto& u) {
         std::filesystem::remove(u.scratch() / "array_0.bin");
         std::filesystem::create_symlink("points.bin", u.scratch() / "array_0.bin");
       }},
      {"array a directory",
       [](auto& u) {
         std::filesystem::remove(u.scratch() / "array_0.bin");
         std::filesystem::create_directory(u.scratch() / "array_0.bin");
       }},
      {"array of an unknown type", [](auto& u) { u.replace(R"("type":"float32"})", R"("type":"float16"})"); }},
      {"array of another size", [](auto& u) { u.replace(R"("type":"float32"})", R"("type":"float64"})"); }},
      {"array without a name", [](auto& u) { u.replace(R"("name":"a")", R"("name":"")"); }},
      {"array with a long name", [](auto& u) { u.replace(R"("name":"a")", "\"name\":\"" + std::string(2000, 'a') + "\""); }},
      {"array on nothing", [](auto& u) { u.replace(R"("association":"point")", R"("association":"edge")"); }},
      {"no components", [](auto& u) { u.replace(R"("components":1)", R"("components":0)"); }},
      {"two arrays of one name",
       [](auto& u) {
         u.replace("\"arrays\":[",
                   R"("arrays":[{"name":"a","association":"point","components":1,"component":"","unit":"","type":"float32"},)");
         u.write("array_1.bin", bytes_of<float>({1, 2, 3, 4}));
       }},
      {"hidden cells missing", [](auto& u) { u.replace(R"("hidden_cells":false)", R"("hidden_cells":true)"); }},
      {"counts that overflow", [](auto& u) { u.replace(R"(["float32",4])", R"(["float32",4611686018427387904])"); }},
      {"negative count", [](auto& u) { u.replace(R"("cells":1)", R"("cells":-1)"); }},
      {"fractional count", [](auto& u) { u.replace(R"("cells":1)", R"("cells":1.5)"); }},
      {"count as text", [](auto& u) { u.replace(R"("cells":1)", R"("cells":"1")"); }},
      {"unknown grid", [](auto& u) { u.replace("unstructured", "polar"); }},
      {"another format", [](auto& u) { u.replace(R"("format":1)", R"("format":2)"); }},
      {"no times", [](auto& u) { u.replace(R"("times":1)", R"("times":0)"); }},
      {"time not finite", [&](auto& u) { u.write("times.bin", bytes_of<double>({static_cast<double>(nan)})); }},
      {"step outside", [](auto& u) { u.replace(R"("step":0)", R"("step":1)"); }},
      {"manifest missing", [](auto& u) { std::filesystem::remove(u.scratch() / "manifest.json"); }},
      {"manifest empty", [](auto& u) { u.write("manifest.json", ""); }},
      {"manifest cut", [](auto& u) { u.write("manifest.json", test::read_bytes(u.scratch() / "manifest.json").substr(0, 60)); }},
      {"manifest a list", [](auto& u) { u.write("manifest.json", "[1]"); }},
      {"manifest deep", [](auto& u) { u.write("manifest.json", std::string(100000, '[')); }},
      {"manifest not UTF-8", [](auto& u) { u.replace(R"("name":"a")", "\"name\":\"\xff\""); }},
      {"key missing", [](auto& u) { u.replace(R"("notes":[])", R"("remarks":[])"); }},
      {"axes missing", [](auto& u) { u.replace(R"("axes":)", R"("axis":)"); }},
      {"two axes", [](auto& u) { u.replace(R"({"name":"","unit":"mm","downward":false},)", ""); }},
      {"axis downward by a number", [](auto& u) { u.replace(R"("downward":true)", R"("downward":1)"); }},
      {"axis without a unit", [](auto& u) { u.replace(R"("unit":"m",)", ""); }},
      {"note no text", [](auto& u) { u.replace(R"("notes":[])", R"("notes":[1])"); }},
  };
  for (const auto& [what, spoil] : cases) {
    Unstructured directory;
    spoil(directory);
    try {
      directory.map();
      ADD_FAILURE() << what;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::bad_data) << what << ": " << error.what();
      EXPECT_TRUE(std::string(error.what()).starts_with("t: the reader")) << what << ": " << error.what();
    }
  }
}

TEST(MapImport, StaysWithinTheBudget) {
  Unstructured directory;
  OpenOptions options;
  options.max_bytes = 100;
  try {
    directory.map(options);
    ADD_FAILURE();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::too_large);
  }
}

ErrorCode structured(const std::string& grid, const std::string& dims,
                     const std::vector<std::pair<std::string, std::string>>& files) {
  const Scratch scratch;
  for (const auto& [name, bytes] : files) scratch.write(name, bytes);
  scratch.write("times.bin", bytes_of<double>({0}));
  scratch.write("manifest.json", "{\"format\":1,\"grid\":\"" + grid + "\",\"dims\":" + dims +
                                     R"(,"hidden_cells":false,"axes":[{"name":"","unit":"","downward":false},{"name":"","unit":"","downward":false},{"name":"","unit":"","downward":false}],)"
                                     "\"arrays\":[],\"times\":1,\"step\":0,\"notes\":[]}");
  try {
    map_import(scratch.path(), "t", {});
  } catch (const Error& error) {
    return error.code();
  }
  return ErrorCode::internal;  // it was accepted
}

TEST(MapImport, ChecksPlacementAxesAndDimensions) {
  const double infinity = std::numeric_limits<double>::infinity();
  constexpr auto kGood = ErrorCode::internal;
  const auto uniform = [&](const std::string& dims, std::initializer_list<double> placement) {
    return structured("uniform", dims, {{"placement.bin", bytes_of<double>(placement)}});
  };
  EXPECT_EQ(uniform("[2,3,4]", {0, 0, 0, 1, -1, 1}), kGood);
  EXPECT_EQ(uniform("[2,3,4]", {0, 0, 0, 1, 0, 1}), ErrorCode::bad_data);
  EXPECT_EQ(uniform("[2,3,4]", {0, infinity, 0, 1, 1, 1}), ErrorCode::bad_data);
  EXPECT_EQ(uniform("[2,3,4]", {0, 0, 0, 1, std::nan(""), 1}), ErrorCode::bad_data);
  EXPECT_EQ(uniform("[2,3,4]", {0, 0, 0, 1, 1}), ErrorCode::bad_data);
  EXPECT_EQ(uniform("[2,3,0]", {0, 0, 0, 1, 1, 1}), ErrorCode::bad_data);
  EXPECT_EQ(uniform("[2,3]", {0, 0, 0, 1, 1, 1}), ErrorCode::bad_data);
  EXPECT_EQ(uniform("[4294967296,4294967296,4294967296]", {0, 0, 0, 1, 1, 1}), ErrorCode::bad_data);
  const auto rectilinear = [&](std::initializer_list<double> x) {
    return structured(
        "rectilinear", "[3,1,2]",
        {{"axis_x.bin", bytes_of<double>(x)}, {"axis_y.bin", bytes_of<double>({0})}, {"axis_z.bin", bytes_of<double>({0, 1})}});
  };
  EXPECT_EQ(rectilinear({0, 1, 3}), kGood);
  EXPECT_EQ(rectilinear({3, 1, 0}), kGood);
  EXPECT_EQ(rectilinear({0, 1, 1}), ErrorCode::bad_data);
  EXPECT_EQ(rectilinear({0, 1, 0.5}), ErrorCode::bad_data);
  EXPECT_EQ(rectilinear({0, 1, infinity}), ErrorCode::bad_data);
  EXPECT_EQ(rectilinear({0, 1}), ErrorCode::bad_data);
}

/// What the child may name beside its own files: a place in the file that was asked for, or in one beside or below it.
TEST(MapImport, APlaceInAFileIsTakenOnlyWhereItIsBesideTheOneThatWasReadAndHoldsTheValues) {
  const Scratch data, elsewhere;
  const auto file = data.write("t.raw", "head" + bytes_of<float>({1, 2, 3, 4}));
  data.write("below/other.raw", bytes_of<float>({5, 6, 7, 8}));
  data.write("small.raw", bytes_of<float>({5, 6, 7}));
  elsewhere.write("secret.raw", bytes_of<float>({5, 6, 7, 8}));
  std::filesystem::create_symlink(elsewhere / "secret.raw", data / "link.raw");
  std::filesystem::create_directory_symlink(elsewhere.path(), data / "way");
  std::filesystem::create_directory(data / "folder");
  const auto value_at = [&](const std::string& in_file, const std::string& offset) -> std::optional<double> {
    Unstructured u;
    std::filesystem::remove(u.scratch() / "array_0.bin");
    u.replace(R"("type":"float32"}])", R"("type":"float32","in_file":)" + in_file + R"(,"offset":)" + offset + "}]");
    try {
      return map_import(u.scratch().path(), file, {})->array("a").at(0);
    } catch (const Error& error) {
      EXPECT_TRUE(error.code() == ErrorCode::bad_data || error.code() == ErrorCode::not_found) << error.what();
      return std::nullopt;
    }
  };
  EXPECT_EQ(value_at(R"("t.raw")", "4"), 1);
  EXPECT_EQ(value_at(R"("below/other.raw")", "0"), 5);
  for (const std::string& name : {"../" + elsewhere.path().filename().string() + "/secret.raw", (elsewhere / "secret.raw").string(), std::string("link.raw"),
                                 std::string("way/secret.raw"), std::string("folder"), std::string("nothing.raw"), std::string(), std::string("small.raw"),
                                 std::string("below/../t.raw")})
    EXPECT_FALSE(value_at("\"" + name + "\"", "0")) << name;
  for (const std::string offset : {"8", "2", "-4", "1e3", "9223372036854775804", "9223372036854775807", "18446744073709551615"})
    EXPECT_FALSE(value_at(R"("t.raw")", offset)) << offset;
  EXPECT_FALSE(value_at("7", "0"));
}

}  // namespace
}  // namespace isostrata
