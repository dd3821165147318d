// Surfaces that fold within a facet: the normals at its corners are opposite, and what is left between them must not shine.
#include <gtest/gtest.h>

#include <algorithm>

#include "data/dataset/analytic.h"
#include "extraction/intervals/extract_intervals.h"
#include "extraction/surfaces/gradient_normals.h"
#include "support/pictures.h"

namespace isostrata::testing {
namespace {

/// Tubes of least density behind the cylinder, as the gallery's figure 7 shows them; yellow, so that blue is glint.
DrawInput tubes(const Dataset& dataset) {
  const PointArray& array = dataset.arrays[0];
  ExtractOptions options;
  options.facets = true;
  IntervalMesh mesh = extract_intervals(dataset.grid, array, std::vector<Interval>{{0.9885, 0.9945}}, options, Task{});
  DrawInput input;
  input.grid = &dataset.grid;
  input.bounds = dataset.bounds;
  input.normals = std::make_shared<const std::vector<Vec3f>>(gradient_normals(dataset.grid, array, mesh, Task{}));
  input.mesh = std::make_shared<const IntervalMesh>(std::move(mesh));
  input.styles.resize(1);
  IntervalStyle& style = input.styles[0];
  style.opacity = 0;
  style.surface.lower = style.surface.own_color = true;
  style.surface.color = {1, 0.8f, 0.1f};
  style.surface.specular = 0.8;
  style.surface.shininess = 40;
  input.camera.eye = {-6, -14, 20};
  input.camera.at = {3.9, 0.2, 2.9};
  input.camera.up = {0, 0, 1};
  input.camera.fov_deg = 29;
  input.width = 320;
  input.height = 240;
  return input;
}

TEST(SurfaceFolds, ShineNowhereMoreThanTheirFacetsDoNearby) {
  const auto dataset = make_analytic("cylinder:96x64x24", {}, Task{});
  const DrawInput smooth = tubes(*dataset);
  DrawInput flat = smooth;
  flat.normals = nullptr;
  for (const char* name : {"native", "raster"}) {
    const std::unique_ptr<Renderer> renderer = make_renderer({name, "auto"});
    const FloatImage image = draw_floats(smooth, *renderer), facets = draw_floats(flat, *renderer);
    int covered = 0, specks = 0;
    for (int y = 0; y < image.height; ++y)
      for (int x = 0; x < image.width; ++x) {
        if (pixel(image, x, y)[3] == 0) continue;
        ++covered;
        float most = 0;
        for (int v = std::max(y - 3, 0); v <= std::min(y + 3, image.height - 1); ++v)
          for (int u = std::max(x - 3, 0); u <= std::min(x + 3, image.width - 1); ++u) most = std::max(most, pixel(facets, u, v)[2]);
        specks += pixel(image, x, y)[2] > most + 0.15f;
      }
    EXPECT_GT(covered, 5000) << name;
    EXPECT_EQ(specks, 0) << name;
  }
}

}  // namespace
}  // namespace isostrata::testing
