// Grids of tetrahedra that are drawn without being split, against the split ones, from the scene to the picture.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "data/dataset/analytic.h"
#include "engine/picture/draw_input.h"
#include "engine/picture/extract_scene.h"
#include "engine/picture/interval_facts.h"
#include "extraction/unstructured/ordered_memory.h"
#include "rendering/choice/native_renderer.h"

namespace isostrata {
namespace {

constexpr int kWidth = 120, kHeight = 90;

SceneInterval interval(double lower, double upper, std::string map = "") {
  SceneInterval one;
  one.lower = lower;
  one.upper = upper;
  one.color_map = std::move(map);
  return one;
}

class CutScene : public ::testing::Test {
 protected:
  Scene scene(std::vector<SceneInterval> intervals) const {
    Scene scene;
    scene.array = dataset_->arrays[0].name;
    for (std::size_t i = 0; i < intervals.size(); ++i) intervals[i].color = default_interval_color(i);
    scene.intervals = std::move(intervals);
    return scene;
  }
  std::shared_ptr<const ExtractedScene> extract(const Scene& scene, TetrahedraWay way,
                                                const std::shared_ptr<const ExtractedScene>& previous = nullptr) {
    SceneAids aids;
    aids.tetrahedra = way;
    aids.bases = &bases_;
    aids.ordered = &ordered_;
    return extract_scene([this](int, const Task&) { return dataset_; }, scene, previous, Task{}, aids);
  }
  Image draw(const ExtractedScene& extracted, const Scene& scene) {
    return std::get<Image>(renderer_->draw(draw_input(extracted, scene, kWidth, kHeight)).image);
  }
  /// At most a step of 8 bits apart, but for single pixels on edges that a ray just meets or misses.
  void expect_same_picture(const Scene& of, const std::string& what) {
    const auto split = extract(of, TetrahedraWay::split), cut = extract(of, TetrahedraWay::cut);
    ASSERT_TRUE(cut->base) << what;
    ASSERT_FALSE(split->base) << what;
    const Image a = draw(*split, of), b = draw(*cut, of);
    int apart = 0, shown = 0;
    for (std::size_t p = 0; p < a.rgba.size(); p += 4) {
      bool far = false;
      for (std::size_t c = 0; c < 4; ++c) far = far || std::abs(int{a.rgba[p + c]} - int{b.rgba[p + c]}) > 1;
      apart += far;
      shown += a.rgba[p] != a.rgba[0] || a.rgba[p + 1] != a.rgba[1] || a.rgba[p + 2] != a.rgba[2];
    }
    EXPECT_LE(apart, 3) << what;
    EXPECT_GT(shown, 300) << what;
  }

  std::shared_ptr<const Dataset> dataset_ = make_analytic("tets:14", {}, Task{});
  BaseMeshes bases_{std::uint64_t{1} << 30};
  OrderedMemory ordered_{std::uint64_t{1} << 30};
  std::unique_ptr<Renderer> renderer_ = make_native_renderer();
};

TEST_F(CutScene, ThePictureIsThatOfTheSplitMesh) {
  const std::vector<std::vector<SceneInterval>> layers = {
      {interval(0.2, 0.3)},
      {interval(0.1, 0.25), interval(0.25, 0.4)},
      {interval(0.05, 0.15), interval(0.3, 0.35), interval(0.6, 0.8)},
      {interval(-10, 10)},
  };
  for (std::size_t i = 0; i < layers.size(); ++i)
    for (const std::string map : {"", "viridis"})
      for (const bool orthographic : {false, true})
        for (const bool clipped : {false, true}) {
          Scene of = scene(layers[i]);
          for (SceneInterval& one : of.intervals) one.color_map = map;
          of.camera = view_of(dataset_->bounds, orthographic ? "+x" : "reset", double{kWidth} / kHeight);
          of.camera->orthographic = orthographic;
          of.camera->eye = of.camera->eye + Vec3d{0.11, 0.23, 0.31};  // not along the grid
          if (clipped) of.clip_planes = {{{1, 0.2, 0.1}, 0.05}, {{0, -1, 0.3}, -0.4}};
          expect_same_picture(
              of, "layers " + std::to_string(i) + map + (orthographic ? " orthographic" : "") + (clipped ? " clipped" : ""));
        }
}

TEST_F(CutScene, LooksAreThoseOfTheSplitMesh) {
  Scene of = scene({interval(0.1, 0.25, "viridis"), interval(0.25, 0.4), interval(0.45, 0.7, "plasma")});
  expect_same_picture(of, "constant and linear");
  of.intervals[0].own_range = true;
  of.intervals[1].opacity_upper = 0.9;
  expect_same_picture(of, "own range, opacity that runs");
  of.mode = SceneMode::prioritized;
  of.intervals[2].priority = 2;
  expect_same_picture(of, "prioritized");
  of.mode = SceneMode::cycled;
  of.cycle.phase = 1;
  expect_same_picture(of, "cycled");
  of.mode = SceneMode::sorted;
  of.camera = view_of(dataset_->bounds, "reset", double{kWidth} / kHeight);
  of.camera->eye = {0.3, 0.2, 0.1};
  expect_same_picture(of, "from inside");
  for (SceneInterval& one : of.intervals) one.color_map.clear(), one.opacity_upper.reset();
  of.intervals[1].color = of.intervals[0].color;
  expect_same_picture(of, "constant from inside");
}

TEST_F(CutScene, MovingAnEndKeepsTheMeshAndTellsWhatExtractionTells) {
  Scene of = scene({interval(0.1, 0.25, "viridis"), interval(0.25, 0.4)});
  const auto first = extract(of, TetrahedraWay::cut);
  of.intervals[1].upper = 0.45;
  const auto second = extract(of, TetrahedraWay::cut, first);
  EXPECT_EQ(second->mesh, first->mesh);
  EXPECT_EQ(draw_input(*second, of, 8, 8).cut_intervals, (std::vector<Interval>{{0.1, 0.25}, {0.25, 0.45}}));
  const auto split = extract(of, TetrahedraWay::split);
  const auto cut_sums = interval_summaries(*second, of), split_sums = interval_summaries(*split, of);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(cut_sums[i].active_cells, split_sums[i].active_cells);
    EXPECT_NEAR(cut_sums[i].volume, split_sums[i].volume, 1e-6);
  }
  of.intervals[0].opacity = 0.9;
  const auto third = extract(of, TetrahedraWay::cut, second);
  EXPECT_EQ(third->extract_ms, 0);
  EXPECT_EQ(extract(of, TetrahedraWay::cut, third), third);
}

TEST_F(CutScene, LitSurfacesLookAsThoseOfTheSplitMesh) {
  Scene of = scene({interval(0.1, 0.22), interval(0.22, 0.3), interval(0.4, 0.6)});
  for (std::size_t i = 0; i < of.intervals.size(); ++i) {
    SurfaceStyle& surface = of.intervals[i].surface;
    surface.lower = i != 1, surface.upper = i != 0;
    surface.opacity = i == 1 ? 0.9 : 0.4;
    surface.specular = 0.5;
    of.intervals[i].opacity = 0.1;
  }
  expect_same_picture(of, "ends");
  of.intervals[2].surface.domain = true;
  of.intervals[0].surface.silhouette = 0.7;
  expect_same_picture(of, "with the grid's boundary");
  of.intervals[1].visible = false;
  expect_same_picture(of, "one hidden");
  // What is lit after it was not, and cut between other ends.
  const auto cut = extract(of, TetrahedraWay::cut);
  Scene plain = of;
  for (SceneInterval& one : plain.intervals) one.surface = {};
  draw(*cut, plain);
  const Image lit = draw(*cut, of), again = draw(*extract(of, TetrahedraWay::cut), of);
  EXPECT_EQ(lit.rgba, again.rgba);
  of.intervals[0].surface.texture = "stripes";
  EXPECT_FALSE(extract(of, TetrahedraWay::cut)->base) << "a texture needs values at the mesh's points";
}

TEST_F(CutScene, WhatCannotBeCutIsSplit) {
  const Scene good = scene({interval(0.1, 0.25, "viridis")});
  EXPECT_TRUE(extract(good, TetrahedraWay::cut)->base);
  const auto is_cut = [&](const auto& change) {
    Scene of = good;
    change(of);
    const auto previous = extract(good, TetrahedraWay::cut);
    return extract(of, TetrahedraWay::cut, previous)->base != nullptr;
  };
  EXPECT_FALSE(is_cut([](Scene& of) { of.intervals[0].surface.upper = true; }));
  EXPECT_FALSE(is_cut([](Scene& of) { of.terms.push_back({{RangeOperator::intersect, of.array, {0.1, 0.2}}, {}, {}, {}, {}}); }));
  EXPECT_FALSE(is_cut([](Scene& of) { of.intervals[0].upper = of.intervals[0].lower + 1e-9; }));
  EXPECT_FALSE(is_cut([](Scene& of) { of.intervals.clear(); }));
  EXPECT_FALSE(is_cut([](Scene& of) { of.intervals.push_back(interval(0.2, 0.5)); }));
  EXPECT_TRUE(is_cut([](Scene& of) { of.intervals.push_back(interval(0.25, 0.5)); }));
  EXPECT_TRUE(is_cut([](Scene& of) { of.intervals[0].upper = 0.3; }));
  EXPECT_FALSE(extract(good, TetrahedraWay::split, extract(good, TetrahedraWay::cut))->base);
  dataset_ = make_analytic("mixed:6", {}, Task{});
  EXPECT_FALSE(extract(good, TetrahedraWay::cut)->base);
}

TEST_F(CutScene, AutomaticWaitsForAMoveAndForTheMesh) {
  Scene of = scene({interval(0.1, 0.25, "viridis")});
  const auto first = extract(of, TetrahedraWay::automatic);
  EXPECT_FALSE(first->base);
  of.intervals[0].upper = 0.26;
  const auto second = extract(of, TetrahedraWay::automatic, first);
  EXPECT_FALSE(second->base);
  bases_.make(dataset_, of.array, Task{});
  EXPECT_FALSE(extract(of, TetrahedraWay::automatic, second)->base);
  of.intervals[0].upper = 0.27;
  EXPECT_TRUE(extract(of, TetrahedraWay::automatic, second)->base);
}

/// Surfaces, combined ranges and colours of the mesh's points go with extraction; a layout of the tetrahedra only numbers anew.
TEST_F(CutScene, ALayoutOfTheTetrahedraChangesNoPicture) {
  for (int kind = 0; kind < 3; ++kind) {
    Scene of = scene({interval(0.1, 0.25, "viridis"), interval(0.25, 0.4)});
    of.intervals[0].surface.upper = kind == 0;
    if (kind == 1) of.terms.push_back({{RangeOperator::subtract, of.array, {0.2, 0.3}}, {}, {}, {}, {}});
    of.camera = view_of(dataset_->bounds, "reset", double{kWidth} / kHeight);
    const auto plain = extract(of, TetrahedraWay::split);
    ordered_.make(dataset_->grid, Task{});
    const auto ordered = extract(of, TetrahedraWay::split);
    const auto in_order_of_the_grid = [](const ExtractedScene& made) {
      return std::is_sorted(made.mesh->cell_runs.begin(), made.mesh->cell_runs.end(),
                            [](const CellRun& a, const CellRun& b) { return a.cell < b.cell; });
    };
    EXPECT_TRUE(in_order_of_the_grid(*plain)) << kind;
    EXPECT_EQ(in_order_of_the_grid(*ordered), kind == 1) << kind;  // combined ranges are extracted from a grid of their own
    ASSERT_EQ(plain->summaries().size(), ordered->summaries().size());
    for (std::size_t i = 0; i < plain->summaries().size(); ++i) {
      EXPECT_EQ(plain->summaries()[i].active_cells, ordered->summaries()[i].active_cells);
      EXPECT_EQ(plain->summaries()[i].tetrahedra, ordered->summaries()[i].tetrahedra);
      EXPECT_NEAR(plain->summaries()[i].volume, ordered->summaries()[i].volume, 1e-9);
    }
    EXPECT_EQ(plain->mesh->facets.size(), ordered->mesh->facets.size());
    const Image a = draw(*plain, of), b = draw(*ordered, of);
    int apart = 0;
    for (std::size_t c = 0; c < a.rgba.size(); ++c) apart += std::abs(int{a.rgba[c]} - int{b.rgba[c]}) > 1;
    EXPECT_LE(apart, 12) << kind;  // at edges of facets, which come in another order
    dataset_ = make_analytic("tets:14", {}, Task{});  // without a layout
  }
}

TEST_F(CutScene, BasesAreMadeOnceAndGoWithTheirDataset) {
  const auto made = bases_.make(dataset_, "distance", Task{});
  EXPECT_EQ(bases_.make(dataset_, "distance", Task{}), made);
  EXPECT_EQ(bases_.find(dataset_, "distance"), made);
  EXPECT_EQ(bases_.held_bytes(), made->bytes());
  dataset_ = make_analytic("tets:6", {}, Task{});
  EXPECT_EQ(bases_.find(dataset_, "distance"), nullptr);
  const auto other = bases_.make(dataset_, "distance", Task{});
  EXPECT_EQ(bases_.held_bytes(), other->bytes());
  BaseMeshes small(1000);
  EXPECT_EQ(small.make(dataset_, "distance", Task{}), nullptr);
  EXPECT_THROW(bases_.make(dataset_, "nosuch", Task{}), Error);
}

}  // namespace
}  // namespace isostrata
