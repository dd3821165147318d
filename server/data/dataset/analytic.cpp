#include "data/dataset/analytic.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "base/parallel.h"
#include "data/dataset/cell_lattice.h"
#include "data/dataset/cylinder_flow.h"
#include "data/dataset/implicit_flow.h"

namespace isostrata {
namespace {

struct Request {
  std::string_view name;            // whole, for messages
  std::string_view kind;            // before ':'
  std::vector<std::int64_t> sizes;  // between 'x' after ':', empty if there is no ':'
};

[[noreturn]] void refuse(const Request& request, const std::string& expected) {
  throw Error(ErrorCode::invalid_argument, std::string(request.name) + ": expected " + expected);
}

Request parse(std::string_view name, const char* expected) {
  Request request{name, name.substr(0, name.find(':')), {}};
  if (request.kind.size() == name.size()) return request;
  std::string_view rest = name.substr(request.kind.size() + 1);
  for (;;) {
    const auto part = rest.substr(0, rest.find('x'));
    std::int64_t value = 0;
    const auto [end, error] = std::from_chars(part.data(), part.data() + part.size(), value);
    if (error == std::errc::result_out_of_range)
      throw Error(ErrorCode::too_large, std::string(name) + ": size " + std::string(part) + " is above every limit; expected " + expected);
    if (error != std::errc{} || end != part.data() + part.size()) refuse(request, expected);
    request.sizes.push_back(value);
    if (part.size() == rest.size()) return request;
    rest.remove_prefix(part.size() + 1);
  }
}

/// The one size of a request, within [least, most].
std::int64_t side(const Request& request, std::int64_t fallback, std::int64_t least, std::int64_t most) {
  const std::string expected =
      std::string(request.kind) + "[:N] with N from " + std::to_string(least) + " to " + std::to_string(most);
  if (request.sizes.empty()) return fallback;
  if (request.sizes.size() != 1 || request.sizes[0] < least) refuse(request, expected);
  if (request.sizes[0] > most)
    throw Error(ErrorCode::too_large, std::string(request.name) + ": N is above the limit; expected " + expected);
  return request.sizes[0];
}

void check_budget(const Request& request, std::uint64_t bytes, const OpenOptions& options) {
  if (bytes > options.max_bytes)
    throw Error(ErrorCode::too_large, std::string(request.name) + ": needs " + std::to_string(bytes) + " bytes, the limit is " +
                                          std::to_string(options.max_bytes));
}

/// N^3 points on [-1,1]^3 with one float array; with one layer N^2 points of the plane z = 0.
void fill_volume(Dataset& dataset, std::int64_t n, std::int64_t layers, const char* array_name, double (*field)(Vec3d), const Task& task) {
  UniformGrid grid;
  const double step = 2.0 / static_cast<double>(n - 1);
  grid.dims = {n, n, layers};
  grid.origin = {-1, -1, layers == 1 ? 0.0 : -1.0};
  grid.spacing = {step, step, step};
  dataset.grid.shape = grid;

  const auto count = static_cast<std::size_t>(n * n * layers);
  const auto values = std::make_shared_for_overwrite<float[]>(count);
  // Coordinates by -1 + 2i/(n-1): symmetric points get the same value to the last bit, and the last point is exactly 1.
  const auto at = [n](std::int64_t i) { return static_cast<double>(2 * i - (n - 1)) / static_cast<double>(n - 1); };
  parallel_for(n * layers, std::max<std::int64_t>(1, 4096 / n), [&](std::int64_t begin, std::int64_t end) {
    task.check();
    for (std::int64_t row = begin; row < end; ++row)
      for (std::int64_t i = 0; i < n; ++i)
        values[static_cast<std::size_t>(row * n + i)] = static_cast<float>(field({at(i), at(row % n), layers == 1 ? 0 : at(row / n)}));
  });
  PointArray array;
  array.name = array_name;
  array.values = std::span<const float>(values.get(), count);
  array.storage = values;
  dataset.arrays.push_back(std::move(array));
}

}  // namespace

double torus_distance(Vec3d p) {
  constexpr double kRadius = 0.6;
  return std::hypot(std::hypot(p.x, p.y) - kRadius, p.z);
}

double sphere_distance(Vec3d p) { return std::hypot(p.x, p.y, p.z); }

double diamond(Vec3d p) { return std::abs(p.x) + std::abs(p.y); }

double marschner_lobb(Vec3d p) {
  constexpr double kAlpha = 0.25, kFrequency = 6;
  constexpr double pi = std::numbers::pi;
  const double ring = std::cos(2 * pi * kFrequency * std::cos(pi * std::hypot(p.x, p.y) / 2));
  return (1 - std::sin(pi * p.z / 2) + kAlpha * (1 + ring)) / (2 * (1 + kAlpha));
}

std::span<const std::string_view> analytic_names() {
  static constexpr std::array<std::string_view, 8> kNames{"torus", "sphere", "marschner-lobb", "cylinder", "implicit-flow", "tets", "mixed", "diamond"};
  return kNames;
}

bool is_analytic(std::string_view name) {
  const auto names = analytic_names();
  return std::find(names.begin(), names.end(), name.substr(0, name.find(':'))) != names.end();
}

std::shared_ptr<const Dataset> make_analytic(std::string_view name, const OpenOptions& options, const Task& task) {
  const Request request = parse(name, "NAME[:N], or cylinder[:NIxNJxNK[xNT]]");
  task.report(0, "computing");
  auto dataset = std::make_shared<Dataset>();
  dataset->name = name;

  constexpr std::int64_t kMostVolume = 4096, kMostLattice = 1024, kMostAround = 4096, kMostSteps = 100000;
  if (request.kind == "torus" || request.kind == "sphere" || request.kind == "marschner-lobb") {
    const std::int64_t n = side(request, request.kind == "marschner-lobb" ? 64 : 256, 2, kMostVolume);
    check_budget(request, static_cast<std::uint64_t>(n * n * n) * sizeof(float), options);
    if (request.kind == "torus") fill_volume(*dataset, n, n, "distance", torus_distance, task);
    if (request.kind == "sphere") fill_volume(*dataset, n, n, "distance", sphere_distance, task);
    if (request.kind == "marschner-lobb") fill_volume(*dataset, n, n, "rho", marschner_lobb, task);
  } else if (request.kind == "implicit-flow") {
    const std::int64_t n = side(request, 64, 2, kMostLattice);
    check_budget(request, implicit_flow_bytes(n), options);
    fill_implicit_flow(*dataset, n, task);
  } else if (request.kind == "tets") {
    const std::int64_t n = side(request, 32, 2, kMostLattice);
    check_budget(request, tets_bytes(n), options);
    fill_tets(*dataset, n, torus_distance, task);
  } else if (request.kind == "mixed") {
    const std::int64_t n = side(request, 17, 5, kMostLattice);
    check_budget(request, mixed_bytes(n), options);
    fill_mixed(*dataset, n, torus_distance, task);
  } else if (request.kind == "diamond") {
    const std::int64_t n = side(request, 9, 2, 1 << 14);
    check_budget(request, static_cast<std::uint64_t>(n * n) * sizeof(float), options);
    fill_volume(*dataset, n, 1, "value", diamond, task);
  } else if (request.kind == "cylinder") {
    CylinderSize size;
    const std::string expected = "cylinder[:NIxNJxNK[xNT]] with NI from 4 to " + std::to_string(kMostAround) +
                                 ", NJ and NK from 2 to " + std::to_string(kMostAround) + ", NT from 1 to " +
                                 std::to_string(kMostSteps);
    if (!request.sizes.empty()) {
      const auto& s = request.sizes;
      if (s.size() < 3 || s.size() > 4 || s[0] < 4 || s[1] < 2 || s[2] < 2 || (s.size() == 4 && s[3] < 1))
        refuse(request, expected);
      if (s[0] > kMostAround || s[1] > kMostAround || s[2] > kMostAround || (s.size() == 4 && s[3] > kMostSteps))
        throw Error(ErrorCode::too_large, std::string(name) + ": a size is above the limit; expected " + expected);
      size = {s[0], s[1], s[2], s.size() == 4 ? s[3] : 1};
    }
    check_budget(request, cylinder_bytes(size), options);
    if (options.step < 0 || options.step >= size.steps)
      throw Error(ErrorCode::not_found, std::string(name) + ": no step " + std::to_string(options.step) + "; it has steps 0 to " +
                                            std::to_string(size.steps - 1));
    fill_cylinder(*dataset, size, options.step, task);
  } else {
    throw Error(ErrorCode::not_found, std::string(name) + ": no analytic data of that name");
  }
  if (options.step != 0 && dataset->times.size() == 1)
    throw Error(ErrorCode::not_found, std::string(name) + ": no step " + std::to_string(options.step) + "; it has one, step 0");

  for (PointArray& array : dataset->arrays) measure_range(array);
  dataset->step = options.step;
  dataset->bounds = dataset->grid.bounds();
  dataset->cell_types = count_cell_types(dataset->grid);
  task.report(1, "computing");
  return dataset;
}

}  // namespace isostrata
