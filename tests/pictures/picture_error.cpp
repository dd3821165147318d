// isostrata-picture-error: how far each renderer's pictures are from the oracle's, as a table in Markdown.
//
//   cmake --build --preset release --target isostrata-picture-error && build/release/bin/isostrata-picture-error
//   [NAME|FILE[:ARRAY]...]
//
// Without arguments: one dataset of each kind of grid; those of the shared test data are left out if it is absent. Each row is
// the worst of three cameras: perspective, orthographic, inside.
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include "base/error.h"
#include "data/dataset/analytic.h"
#include "rendering/order/draw_groups.h"
#include "support/order_errors.h"
#include "support/picture_cases.h"
#include "support/picture_error.h"
#include "support/shared_data.h"

namespace isostrata::testing {
namespace {

constexpr int kWidth = 128, kHeight = 96;

struct Source {
  std::string kind, name, array;  // an empty array: the first
};

std::vector<Source> default_sources() {
  std::vector<Source> sources{{"uniform", "torus:24", ""},
                              {"curvilinear O-grid", "cylinder:32x24x12", ""},
                              {"tetrahedra", "tets:14", ""},
                              {"all four cell types", "mixed:12", ""}};
  const std::filesystem::path data = shared_data();
  for (const Source& source : {Source{"rectilinear", "vtk_rectgrid/RectGrid2.vtk", ""},
                               Source{"curvilinear", "plot3d_bluntfin/bluntfinxyz.bin", "Density"},
                               Source{"tetrahedra, not convex", "ug_post_tets/post.vtk", ""},
                               Source{"tetrahedra and wedges", "ug_aneurysm_fem/output_fem.vtu", ""}})
    if (std::filesystem::exists(data / source.name))
      sources.push_back({source.kind, (data / source.name).string(), source.array});
  return sources;
}

/// The worst of the shots.
struct Row {
  PictureError error{0, 0, 0, 1, 1, 0, 0};
  bool drawn = false;
  std::string trouble;
  void add(const PictureError& e) {
    drawn = true;
    error.max = std::max(error.max, e.max);
    error.mean = std::max(error.mean, e.mean);
    error.above_half_step = std::max(error.above_half_step, e.above_half_step);
    error.ssim = std::min(error.ssim, e.ssim);
    error.covered = std::min(error.covered, e.covered);
    error.max_depth = std::max(error.max_depth, e.max_depth);
    error.depth_missing = std::max(error.depth_missing, e.depth_missing);
  }
};

void print_pictures(const Source& source, const Dataset& dataset, const PointArray& array,
                    const std::vector<std::pair<std::string, std::unique_ptr<Renderer>>>& renderers) {
  for (const Look look : kLooks) {
    DrawInput input = picture_of(dataset, array, look);
    input.width = kWidth;
    input.height = kHeight;
    std::vector<Row> rows(renderers.size());
    for (const Shot shot : kShots) {
      input.camera = camera_of(dataset.bounds, shot);
      const OracleImage expected = oracle_image(input);
      for (std::size_t r = 0; r < renderers.size(); ++r) try {
          DrawInput floats = input;
          floats.float_image = true;
          rows[r].add(
              picture_error(expected, std::get<FloatImage>(renderers[r].second->draw(floats).image), input.bounds.diagonal()));
        } catch (const Error& error) {
          rows[r].trouble = error.what();
        }
    }
    for (std::size_t r = 0; r < renderers.size(); ++r) {
      const Row& row = rows[r];
      std::printf("| %s | %s | %s | ", source.kind.c_str(), look_name(look), renderers[r].first.c_str());
      if (row.drawn && row.trouble.empty())
        std::printf("%.2g | %.2g | %.3f %% | %.5f | %.1e |\n", row.error.max, row.error.mean, 100 * row.error.above_half_step,
                    row.error.ssim, row.error.max_depth);
      else
        std::printf("– | – | – | – | %s |\n", row.trouble.c_str());
    }
    std::fflush(stdout);
  }
}

void print_orders(const Source& source, const Dataset& dataset, const PointArray& array) {
  DrawInput input = picture_of(dataset, array, Look::mapped);
  input.width = kWidth;
  input.height = kHeight;
  for (IntervalStyle& style : input.styles) use_map(style, "gray", {0, 1});  // the order of every pair matters
  for (const Shot shot : kShots) {
    input.camera = camera_of(dataset.bounds, shot);
    const VisibilityOrder order = order_groups(input);
    const OrderErrors errors = order_errors(input, order.tetrahedra);
    const std::vector<std::uint8_t> drawn(input.styles.size(), 1), mixed(input.styles.size(), 0);
    const double by_centroids = order_errors(input, centroid_order(*input.mesh, {drawn, mixed}, input.camera).tetrahedra).share();
    constexpr const char* kNames[] = {"perspective", "orthographic", "inside"};
    std::printf("| %s | %s | %zu | %s | %lld | %lld | %.4f %% | %lld | %.2f %% |\n", source.kind.c_str(),
                kNames[static_cast<int>(shot)], order.tetrahedra.size(), order.method.c_str(),
                static_cast<long long>(errors.fragments), static_cast<long long>(errors.wrong), 100 * errors.share(),
                static_cast<long long>(errors.overlapping), 100 * by_centroids);
    std::fflush(stdout);
  }
}

int run(const std::vector<Source>& sources) {
  std::vector<std::pair<std::string, std::unique_ptr<Renderer>>> renderers;
  for (const char* name : {"native", "raster", "compute"}) try {
      renderers.emplace_back(name, make_renderer({name, "auto"}));
    } catch (const Error& error) {
      std::fprintf(stderr, "%s: %s\n", name, error.what());
    }
  std::vector<std::shared_ptr<const Dataset>> datasets;
  for (const Source& source : sources) datasets.push_back(open_dataset(source.name, {}, Task{}));
  const auto array_of = [&](std::size_t s) -> const PointArray& {
    return sources[s].array.empty() ? datasets[s]->arrays.at(0) : datasets[s]->array(sources[s].array);
  };
  std::printf(
      "Order of the tetrahedra: of the fragments whose order matters, those drawn before one that lies behind them, %dx%d.\n\n",
      kWidth, kHeight);
  std::printf(
      "| grid | camera | tetrahedra | order | fragments | wrong | share | overlapping pairs "
      "| by centroids |\n|---|---|---|---|---|---|---|---|---|\n");
  for (std::size_t s = 0; s < sources.size(); ++s) print_orders(sources[s], *datasets[s], array_of(s));
  std::printf("\nPictures against the oracle, %dx%d, the worst of three cameras; depth in diagonals of the grid.\n\n", kWidth,
              kHeight);
  std::printf(
      "| grid | look | renderer | max | mean | above half an 8-bit step | SSIM | depth |\n|---|---|---|---|---|---|---|---|\n");
  for (std::size_t s = 0; s < sources.size(); ++s) print_pictures(sources[s], *datasets[s], array_of(s), renderers);
  return 0;
}

std::vector<Source> named_sources(int argc, char** argv) {
  std::vector<Source> sources;
  for (int a = 1; a < argc; ++a) {
    const std::string word = argv[a];
    const auto colon = is_analytic(word) ? std::string::npos : word.rfind(':');
    const std::string name = word.substr(0, colon);
    sources.push_back(
        {std::filesystem::path(name).filename().string(), name, colon == std::string::npos ? "" : word.substr(colon + 1)});
  }
  return sources;
}

}  // namespace

int picture_error_main(int argc, char** argv) {
  try {
    return run(argc > 1 ? named_sources(argc, argv) : default_sources());
  } catch (const Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}

}  // namespace isostrata::testing

int main(int argc, char** argv) { return isostrata::testing::picture_error_main(argc, argv); }
