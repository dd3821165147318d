#include "data/derived/coarse_error.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <type_traits>

#include "data/dataset/analytic.h"
#include "data/derived/sampled_mesh.h"
#include "data/parts/region.h"

namespace isostrata {
namespace {

const std::vector<std::string> kArrays{"f"};

/// A grid of boxes with one array of values that nothing smooths.
template <class T>
std::shared_ptr<Dataset> noise(std::array<std::int64_t, 3> dims, unsigned seed) {
  auto whole = std::make_shared<Dataset>();
  whole->name = "noise";
  whole->grid.shape = UniformGrid{dims, {}, {1, 1, 1}};
  whole->bounds = whole->grid.bounds();
  std::mt19937 random(seed);
  const auto values = std::make_shared<std::vector<T>>(static_cast<std::size_t>(whole->grid.point_count()));
  for (T& value : *values) value = static_cast<T>(random() % 200);
  PointArray array;
  array.name = "f";
  array.type = std::is_same_v<T, float> ? ScalarType::float32 : ScalarType::uint8;
  array.values = std::span<const T>(*values);
  array.storage = values;
  measure_range(array);
  whole->arrays = {array};
  return whole;
}

/// The field at a place in index space, trilinear in every box of `stride` points; the textbook's sum of eight.
double trilinear(const Dataset& whole, const std::array<std::int64_t, 3>& stride, Vec3d p) {
  const auto dims = whole.grid.dims();
  double sum = 0;
  for (int corner = 0; corner < 8; ++corner) {
    std::int64_t id = 0, jump = 1;
    double weight = 1;
    for (int a = 0; a < 3; ++a) {
      const auto axis = static_cast<std::size_t>(a);
      const std::int64_t kept = (dims[axis] - 1) / stride[axis] + 1;
      const double at = p[a] / static_cast<double>(stride[axis]);
      const auto below = std::min(static_cast<std::int64_t>(at), std::max<std::int64_t>(kept - 2, 0));
      const bool above = (corner >> a & 1) != 0;
      weight *= above ? at - static_cast<double>(below) : 1 - (at - static_cast<double>(below));
      id += jump * std::min((below + above) * stride[axis], dims[axis] - 1);
      jump *= dims[axis];
    }
    if (weight != 0) sum += weight * whole.arrays[0].at(static_cast<std::size_t>(id));
  }
  return sum;
}

template <class T>
void expect_law(std::array<std::int64_t, 3> dims, std::array<std::int64_t, 3> stride, unsigned seed) {
  const auto whole = noise<T>(dims, seed);
  const auto coarse = coarser(*whole, stride, kArrays, Task{});
  const CoarseError error = coarse_error(*whole, *coarse, stride, "f", Task{});
  double largest = 0, sum = 0;
  std::int64_t points = 0;
  std::array<std::int64_t, 3> end{};
  for (std::size_t a = 0; a < 3; ++a) end[a] = (dims[a] - 1) / stride[a] * stride[a];
  for (std::int64_t k = 0; k <= end[2]; ++k)
    for (std::int64_t j = 0; j <= end[1]; ++j)
      for (std::int64_t i = 0; i <= end[0]; ++i, ++points) {
        const auto id = static_cast<std::size_t>((k * dims[1] + j) * dims[0] + i);
        const Vec3d p{static_cast<double>(i), static_cast<double>(j), static_cast<double>(k)};
        const double difference = std::abs(whole->arrays[0].at(id) - trilinear(*whole, stride, p));
        largest = std::max(largest, difference);
        sum += difference;
      }
  EXPECT_EQ(error.points, points);
  EXPECT_NEAR(error.largest, largest, 1e-9);
  EXPECT_NEAR(error.mean, sum / static_cast<double>(points), 1e-9);
  // And no place between the points is farther off.
  std::mt19937 random(seed + 1);
  for (int n = 0; n < 2000; ++n) {
    Vec3d p;
    for (int a = 0; a < 3; ++a) p[a] = std::uniform_real_distribution<double>(0, static_cast<double>(end[static_cast<std::size_t>(a)]))(random);
    EXPECT_LE(std::abs(trilinear(*whole, {1, 1, 1}, p) - trilinear(*whole, stride, p)), error.largest + 1e-9);
  }
}

TEST(CoarseError, IsTheLargestAndTheMeanOverAllPointsAndNoPlaceBetweenIsFartherOff) {
  const unsigned seed = std::random_device{}();
  SCOPED_TRACE(seed);
  expect_law<float>({13, 10, 9}, {3, 2, 1}, seed);
  expect_law<float>({14, 11, 8}, {2, 2, 2}, seed);
  expect_law<std::uint8_t>({17, 9, 12}, {4, 3, 5}, seed);
  expect_law<float>({9, 7, 1}, {2, 3, 1}, seed);
  expect_law<float>({5, 5, 5}, {1, 1, 1}, seed);
}

TEST(CoarseError, LeavesOutWhatIsNoNumberAndKeepsTheRest) {
  const auto whole = noise<float>({9, 9, 9}, 3);
  const auto values = std::make_shared<std::vector<float>>(729, 1.0f);
  (*values)[4 * 81 + 4 * 9 + 4] = std::numeric_limits<float>::quiet_NaN();  // a kept point
  (*values)[1] = 3;                                                          // one that is not kept
  whole->arrays[0].values = std::span<const float>(*values);
  whole->arrays[0].storage = values;
  measure_range(whole->arrays[0]);
  const auto coarse = coarser(*whole, {2, 2, 2}, kArrays, Task{});
  const CoarseError error = coarse_error(*whole, *coarse, {2, 2, 2}, "f", Task{});
  EXPECT_EQ(error.largest, 2);
  EXPECT_EQ(error.points, 729 - 27) << "the kept one and what lies between it and its neighbours";
  EXPECT_NEAR(error.mean, 2.0 / 702, 1e-12);
}

TEST(CoarseError, OfSamplesIsThatAtTheMeshsPoints) {
  const auto mesh = make_analytic("tets:12", {}, Task{});
  const std::vector<std::string> names{mesh->arrays[0].name};
  double last = std::numeric_limits<double>::infinity();
  for (const std::int64_t most : {300, 3'000, 300'000}) {
    const auto samples = sampled(*mesh, most, names, Task{});
    const CoarseError error = sampled_error(*mesh, *samples, names[0], Task{});
    EXPECT_EQ(error.points, mesh->grid.point_count()) << "the mesh fills its box";
    EXPECT_GT(error.largest, error.mean);
    EXPECT_LT(error.mean, last) << "more samples are closer";
    last = error.mean;
  }
}

TEST(CoarseError, CanBeGivenUp) {
  const auto whole = noise<float>({9, 9, 9}, 3);
  const auto coarse = coarser(*whole, {2, 2, 2}, kArrays, Task{});
  Task task;
  task.cancel();
  EXPECT_THROW(coarse_error(*whole, *coarse, {2, 2, 2}, "f", task), Error);
}

}  // namespace
}  // namespace isostrata
