// Laws of light and of painting, drawn by llvmpipe and compared with the oracle or with themselves.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "data/dataset/analytic.h"
#include "extraction/intervals/extract_intervals.h"
#include "support/oracle.h"
#include "support/pictures.h"

namespace isostrata {
namespace {

using namespace testing;

DrawInput extracted_input(const char* data, const std::vector<Interval>& intervals, double opacity) {
  static std::vector<std::shared_ptr<const Dataset>> alive;
  alive.push_back(make_analytic(data, {}, Task{}));
  const Dataset& dataset = *alive.back();
  IntervalMesh mesh = extract_intervals(dataset.grid, dataset.arrays[0], intervals, {}, Task{});
  std::vector<float> values(mesh.values.begin(), mesh.values.end());
  DrawInput input = input_of(std::move(mesh), opacity);
  input.grid = &dataset.grid;
  input.color_values = std::make_shared<const std::vector<float>>(std::move(values));
  return input;
}

double largest_difference(const FloatImage& a, const FloatImage& b) {
  double largest = 0;
  for (std::size_t i = 0; i < a.rgba.size(); ++i)
    largest = std::max(largest, static_cast<double>(std::abs(a.rgba[i] - b.rgba[i])));
  return largest;
}

void use_map(DrawInput& input, const char* map, double lower, double upper) {
  for (IntervalStyle& style : input.styles) {
    style.color_map = map;
    style.color_lower = lower;
    style.color_upper = upper;
  }
}

// The oracle decides per pixel what the rasterizer decides on a grid of 1/256 pixel, so single pixels on silhouettes of big
// tetrahedra may differ by what a sliver of 1/256 pixel lets through; 2e-3 is that for these pictures, and the mean shows that
// they are few.
constexpr double kSilhouette = 2e-3;
constexpr double kMean = 5e-6;

TEST(Light, MeetsTheOracleOnExtractedIntervals) {
  for (const Vec3d eye : {Vec3d{3, 2.2, 4}, Vec3d{-4, 0.3, 0.2}, Vec3d{0.1, 0.2, 4}}) {
    DrawInput input = extracted_input("torus:12", {{0.1, 0.3}, {0.3, 0.5}, {0.7, 0.9}}, 0.6);
    input.camera.eye = eye;
    const OracleError error = compare_with_oracle(input, draw_floats(input));
    RecordProperty("max", std::to_string(error.max));
    RecordProperty("mean", std::to_string(error.mean));
    EXPECT_GT(error.covered, 0.1);
    EXPECT_LT(error.max, for_triangles(kSilhouette, 10)) << error.max_x << "," << error.max_y << " seen from " << eye.x << "," << eye.y << ","
                                      << eye.z;
    EXPECT_LT(error.mean, for_triangles(kMean, 20));
  }
}

/// A grid of boxes in two intervals with a scalar of its own at every point.
DrawInput random_scalars(unsigned seed) {
  static const RectilinearGrid shape = even_grid(4, 4, 4, {-1, -1, -1}, {1, 1, 1});
  static const Grid grid{shape, {}, {}};
  DrawInput input = input_of(box_mesh(shape, [](auto i, auto j, auto k) { return static_cast<int>((i + j + k) % 2); }), 0.5);
  input.grid = &grid;
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> number(0, 1);
  std::vector<float> values(input.mesh->positions.size());
  for (float& v : values) v = number(random);
  input.color_values = std::make_shared<const std::vector<float>>(std::move(values));
  return input;
}

// viridis: the shader takes the map's colour at the ends of the segment and runs straight between them; the oracle follows the
// map.
TEST(Light, ColourLinearAlongTheRayMeetsTheOracle) {
  for (const char* map : {"gray", "viridis"})
    for (const double unit : {0.05, 0.3, 3.0}) {
      DrawInput input = random_scalars(20);
      use_map(input, map, -0.1, 1.2);
      input.unit_distance = unit;
      const OracleError error = compare_with_oracle(input, draw_floats(input));
      EXPECT_GT(error.covered, 0.1);
      const bool straight = std::string_view(map) == "gray";
      EXPECT_LT(error.max, straight ? for_triangles(kSilhouette, 10) : 0.1)
          << map << ", unit distance " << unit << " at " << error.max_x << "," << error.max_y << ", seed 20";
      EXPECT_LT(error.mean, straight ? for_triangles(kMean, 20) : 1e-3) << map << ", unit distance " << unit << ", seed 20";
    }
}

// Some cells hold inverted tetrahedra, which overlap their neighbours: there the oracle too has no exact order, and pixels may
// differ.
TEST(Light, ColourMapsOnExtractedIntervalsStayNearTheOracle) {
  DrawInput input = extracted_input("marschner-lobb:10", {{0.2, 0.5}, {0.5, 0.8}}, 0.5);
  use_map(input, "viridis", 0.1, 0.9);
  input.unit_distance = 0.05;
  const OracleError error = compare_with_oracle(input, draw_floats(input));
  EXPECT_LT(error.max, 0.05) << error.max_x << "," << error.max_y;
  EXPECT_LT(error.mean, 3e-4);
}

TEST(Light, AConstantColourAndAFlatMapOfItAreTheSamePicture) {
  DrawInput input = extracted_input("torus:12", {{0.1, 0.3}, {0.3, 0.5}}, 0.6);
  for (IntervalStyle& style : input.styles) style.color = {0, 0, 0};
  const FloatImage constant = draw_floats(input);
  use_map(input, "gray", 10, 20);  // all values lie below the range: black everywhere
  EXPECT_LT(largest_difference(constant, draw_floats(input)), 1e-5);
}

TEST(Light, SplittingAnIntervalChangesNothing) {
  for (const char* data : {"torus:14", "tets:8", "mixed:7", "cylinder:12x10x6"}) {
    const auto dataset = make_analytic(data, {}, Task{});
    const double low = dataset->arrays[0].lower, span = dataset->arrays[0].upper - low;
    const double a = low + 0.2 * span, b = low + 0.47 * span, c = low + 0.7 * span;
    DrawInput whole = extracted_input(data, {{a, c}}, 0.5);
    DrawInput split = extracted_input(data, {{a, b}, {b, c}}, 0.5);
    split.styles[1].color = split.styles[0].color;
    split.bounds = whole.bounds;
    split.camera = whole.camera;
    EXPECT_GT(split.mesh->summaries[1].tetrahedra, 0) << data;
    const FloatImage one = draw_floats(whole), two = draw_floats(split);
    double mean = 0;
    for (std::size_t i = 0; i < one.rgba.size(); ++i) mean += std::abs(one.rgba[i] - two.rgba[i]);
    // Not bit for bit where cells are not boxes: inside a cell the two triangulations are different piecewise linear solids.
    EXPECT_LT(mean / static_cast<double>(one.rgba.size()), 2e-4) << data;
  }
}

TEST(Light, CuttingTetrahedraInTwoChangesNothing) {
  DrawInput whole = extracted_input("torus:12", {{0.1, 0.4}}, 0.5);
  IntervalMesh cut = *whole.mesh;
  const std::size_t n = cut.tetrahedra.size();
  for (std::size_t t = 0; t < n; ++t) {  // across the edge 0-1
    const auto p = cut.tetrahedra[t];
    const auto middle = add_point(cut, lerp(cut.positions[p[0]], cut.positions[p[1]], 0.37));
    cut.tetrahedra[t] = {p[0], middle, p[2], p[3]};
    add_tetrahedron(cut, {middle, p[1], p[2], p[3]}, cut.tetrahedron_interval[t]);
  }
  DrawInput input = whole;
  input.mesh = std::make_shared<const IntervalMesh>(cut);
  input.color_values = nullptr;
  const FloatImage a = draw_floats(whole), b = draw_floats(input);
  EXPECT_LT(largest_difference(a, b), for_triangles(1e-4, 30));
  const Image a8 = draw_bytes(whole), b8 = draw_bytes(input);
  int worst = 0;
  for (std::size_t i = 0; i < a8.rgba.size(); ++i) worst = std::max(worst, std::abs(a8.rgba[i] - b8.rgba[i]));
  EXPECT_LE(worst, 1);
}

TEST(Light, ATetrahedronLooksTheSameWhateverTheOrderOfItsVertices) {
  std::mt19937 random(21);
  std::uniform_real_distribution<double> number(-1, 1);
  for (int trial = 0; trial < 40; ++trial) {
    IntervalMesh mesh;
    for (int v = 0; v < 4; ++v) add_point(mesh, {number(random), number(random), number(random)});
    add_tetrahedron(mesh, {0, 1, 2, 3}, 0);
    DrawInput input = input_of(mesh, 0.8);
    const FloatImage first = draw_floats(input);
    EXPECT_LT(compare_with_oracle(input, first).mean, 2e-5) << "trial " << trial << ", seed 21";
    std::array<std::uint32_t, 4> order{0, 1, 2, 3};
    while (std::next_permutation(order.begin(), order.end())) {
      mesh.tetrahedra[0] = order;
      input.mesh = std::make_shared<const IntervalMesh>(mesh);
      ASSERT_LT(largest_difference(first, draw_floats(input)), 1e-4) << "trial " << trial << ", seed 21";
    }
  }
}

TEST(Light, SliversAndDegenerateTetrahedraNeverShineOut) {
  std::mt19937 random(22);
  std::uniform_real_distribution<double> number(-1, 1);
  for (int trial = 0; trial < 120; ++trial) {
    IntervalMesh mesh;
    const double thickness = std::pow(10.0, -trial % 18);  // down to flat in double precision
    for (int v = 0; v < 3; ++v) add_point(mesh, {number(random), number(random), number(random)});
    const double s = number(random), t = number(random);
    const Vec3d in_plane =
        mesh.positions[0] + (mesh.positions[1] - mesh.positions[0]) * s + (mesh.positions[2] - mesh.positions[0]) * t;
    add_point(mesh, in_plane + Vec3d{number(random), number(random), number(random)} * thickness);
    add_tetrahedron(mesh, {0, 1, 2, 3}, 0);
    double longest = 0;
    for (const Vec3d& a : mesh.positions)
      for (const Vec3d& b : mesh.positions) longest = std::max(longest, length(a - b));
    DrawInput input = input_of(mesh, 0.5);
    input.bounds = Box3d{{-2, -2, -2}, {2, 2, 2}};
    input.unit_distance = 1;
    input.camera = {{number(random) * 2, number(random) * 2, 5}, mesh.positions[0], {0, 1, 0}, 30};
    const FloatImage image = draw_floats(input);
    const double most = 1 - std::exp(-extinction(0.5, 1) * longest) + 1e-5;
    for (const float v : image.rgba)
      ASSERT_TRUE(v >= 0 && v <= most) << v << " above " << most << ", trial " << trial << ", seed 22";
    EXPECT_LT(compare_with_oracle(input, image).mean, 1e-4) << "trial " << trial << ", seed 22";
  }
}

TEST(Light, AnEyeInsideSeesWhatIsInFrontOfIt) {
  std::mt19937 random(23);
  std::uniform_real_distribution<double> number(-0.8, 0.8);
  const RectilinearGrid shape = even_grid(4, 4, 4, {-1, -1, -1}, {1, 1, 1});
  const Grid grid{shape, {}, {}};
  for (int trial = 0; trial < 12; ++trial) {
    DrawInput input = input_of(box_mesh(shape, [](auto i, auto j, auto k) { return static_cast<int>((i + j + k) % 4); }), 0.5);
    input.grid = &grid;
    input.camera = {
        {number(random), number(random), number(random)}, {number(random), number(random), number(random)}, {0.1, 1, 0.3}, 70};
    const OracleError error = compare_with_oracle(input, draw_floats(input));
    EXPECT_EQ(error.covered, 1.0);
    // What is nearer than the near plane is missing: about 1e-4 everywhere. Single pixels may differ by one whole tetrahedron
    // seen through a crack of 1/256 pixel, where a tetrahedron that was sliced meets one that was not.
    EXPECT_LT(error.mean, 3e-4) << "trial " << trial << ", seed 23";
    EXPECT_LT(error.above_a_percent, 2e-3) << "trial " << trial << ", seed 23, at " << error.max_x << "," << error.max_y;
  }
}

TEST(Light, NothingBehindTheEyeIsSeen) {
  DrawInput input = extracted_input("torus:12", {{0.1, 0.5}}, 0.9);
  input.camera = {{0, 0, 5}, {0, 0, 9}, {0, 1, 0}, 60};
  for (const float v : draw_floats(input).rgba) ASSERT_EQ(v, 0.0f);
}

TEST(Light, ANearerOpaqueIntervalHidesAFartherOneFromAllSides) {
  for (int dx = -1; dx <= 1; ++dx)
    for (int dy = -1; dy <= 1; ++dy)
      for (int dz = -1; dz <= 1; ++dz) {
        if (dx == 0 && dy == 0 && dz == 0) continue;
        const RectilinearGrid shape = even_grid(8, 8, 8, {-1, -1, -1}, {1, 1, 1});
        const Grid grid{shape, {}, {}};
        // A shell of one cell, red, around a blue core.
        IntervalMesh mesh = box_mesh(shape, [](auto i, auto j, auto k) {
          const auto rim = [](std::int64_t n) { return n == 0 || n == 6; };
          return rim(i) || rim(j) || rim(k) ? 0 : 1;
        });
        DrawInput input = input_of(std::move(mesh), 1.0);
        input.styles[0].color = {1, 0, 0};
        input.styles[1].color = {0, 0, 1};
        input.grid = &grid;
        input.unit_distance = 0.01;
        const Vec3d direction{static_cast<double>(dx), static_cast<double>(dy), static_cast<double>(dz)};
        input.camera = {normalized(direction) * 6.0, {0, 0, 0}, dx == 0 && dz == 0 ? Vec3d{0, 0, 1} : Vec3d{0, 1, 0}, 40};
        const DrawResult result = test_renderer().draw(input);
        EXPECT_TRUE(result.facts.order_exact) << result.facts.order;
        const Image& image = std::get<Image>(result.image);
        int red = 0, blue = 0;
        for (int y = 0; y < image.height; ++y)
          for (int x = 0; x < image.width; ++x) {
            red += pixel(image, x, y)[0] > 200;
            blue += pixel(image, x, y)[2] > 1;
          }
        EXPECT_GT(red, 200) << dx << dy << dz;
        EXPECT_EQ(blue, 0) << dx << dy << dz;
      }
}

TEST(Priority, HigherOnesArePaintedOverLowerOnes) {
  const RectilinearGrid shape = even_grid(2, 2, 3, {-1, -1, -1}, {1, 1, 1});
  DrawInput input = input_of(box_mesh(shape, [](auto, auto, auto k) { return static_cast<int>(k); }), 1.0);
  input.camera = view_of(input.bounds, "+z");  // interval 1 is the nearer
  input.unit_distance = 0.05;
  input.mode = RenderMode::prioritized;
  input.styles[0].priority = 5;
  input.styles[1].priority = 1;
  const Image over = draw_bytes(input);
  EXPECT_NEAR(pixel(over, 32, 24)[0], 229.5, 0.6);  // interval 0's red, though it lies behind
  input.styles[0].priority = 0;
  EXPECT_EQ(pixel(draw_bytes(input), 32, 24)[1], 191);  // interval 1's green
}

TEST(Priority, OfConstantColoursNeedsNoOrderInside) {
  DrawInput input = extracted_input("torus:14", {{0.1, 0.3}, {0.3, 0.6}}, 0.5);
  input.mode = RenderMode::prioritized;
  input.styles[0].priority = 1;
  const DrawResult first = test_renderer().draw(input);
  EXPECT_EQ(first.facts.order, "priority (none needed)");
  EXPECT_TRUE(first.facts.order_exact);
  const FloatImage reference = draw_floats(input);
  std::mt19937 random(24);
  for (int trial = 0; trial < 5; ++trial) {
    IntervalMesh mesh = *input.mesh;
    for (std::size_t i = mesh.tetrahedra.size() - 1; i > 0; --i) {
      const std::size_t j = random() % (i + 1);
      std::swap(mesh.tetrahedra[i], mesh.tetrahedra[j]);
      std::swap(mesh.tetrahedron_interval[i], mesh.tetrahedron_interval[j]);
    }
    DrawInput shuffled = input;
    shuffled.mesh = std::make_shared<const IntervalMesh>(std::move(mesh));
    EXPECT_LT(largest_difference(reference, draw_floats(shuffled)), 2e-5) << "trial " << trial << ", seed 24";
  }
}

TEST(Priority, ColourMapsAreSortedInside) {
  DrawInput input = extracted_input("torus:10", {{0.1, 0.3}, {0.3, 0.6}}, 0.5);
  use_map(input, "viridis", 0, 1);
  input.mode = RenderMode::prioritized;
  input.styles[1].priority = 1;
  EXPECT_EQ(test_renderer().draw(input).facts.order.substr(0, 30), "priority, then index distance ");
}

}  // namespace
}  // namespace isostrata
