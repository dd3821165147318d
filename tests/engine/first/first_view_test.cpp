#include "engine/first/first_view.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <tuple>

#include "base/parallel.h"
#include "data/dataset/analytic.h"
#include "data/derived/series_ranges.h"
#include "engine/first/choose_array.h"
#include "engine/first/find_labels.h"
#include "engine/first/find_missing.h"
#include "engine/first/first_scene.h"
#include "scene/camera.h"
#include "support/field_dataset.h"

namespace isostrata {
namespace {

using testing::array_of;
using testing::field_dataset;

std::shared_ptr<const Dataset> analytic(const std::string& name, int step = 0) {
  OpenOptions options;
  options.step = step;
  return make_analytic(name, options, Task());
}

FirstView view_of_data(const Dataset& dataset, const std::string& array = "") { return first_view(dataset, {array, -1}, Task()); }

/// The part of the picture, half of it being 1, at which a point lies.
std::array<double, 2> on_picture(const Camera& camera, Vec3d p, double aspect) {
  const auto q = view_from_world(camera) * std::array<double, 4>{p.x, p.y, p.z, 1};
  const double reach = std::tan(camera.fov_deg / 2 * std::acos(-1.0) / 180);
  const double away = camera.orthographic ? length(camera.eye - camera.at) : -q[2];
  return {q[0] / away / reach / aspect, q[1] / away / reach};
}

void expect_sound(const FirstView& view, const Dataset& dataset) {
  ASSERT_FALSE(view.array.empty()) << view.array_reason;
  const PointArray& array = dataset.array(view.array);
  ASSERT_FALSE(view.layers.empty());
  EXPECT_LE(view.layers.size(), 9u);
  for (const FirstLayer& layer : view.layers) {
    EXPECT_LT(layer.lower, layer.upper);
    EXPECT_GE(layer.lower, array.lower);
    EXPECT_LE(layer.upper, array.upper);
    EXPECT_FALSE(layer.reason.empty());
    EXPECT_GT(layer.opacity, 0);
    EXPECT_LT(layer.opacity, 1);
  }
  for (const std::string* reason :
       {&view.array_reason, &view.step_reason, &view.kind_reason, &view.light_reason, &view.up_reason, &view.camera_reason})
    EXPECT_FALSE(reason->empty());
  for (const double aspect : {0.5, 1.0, 4.0 / 3, 3.0}) {
    const Camera camera = view.camera(aspect);
    EXPECT_NO_THROW(check(camera));
    double farthest = 0;
    for (const Vec3d& p : view.outline)
      for (const double at : on_picture(camera, p, aspect)) farthest = std::max(farthest, std::abs(at));
    EXPECT_LE(farthest, 0.96) << aspect;
    EXPECT_GE(farthest, 0.85) << aspect;
  }
}

const char* const kBuiltIn[] = {"torus:48",         "sphere:40", "marschner-lobb:48", "cylinder:24x24x12",
                                "implicit-flow:24", "tets:16",   "mixed:9",           "diamond:17"};

TEST(FirstView, OfEveryBuiltInFieldHasLayersInItsRangeReasonsAndACameraThatSeesThem) {
  for (const std::string name : kBuiltIn) {
    SCOPED_TRACE(name);
    const auto dataset = analytic(name);
    expect_sound(view_of_data(*dataset), *dataset);
  }
}

TEST(FirstView, TheCameraSeesEveryPointOfItsLayers) {
  for (const std::string name : kBuiltIn) {
    const auto dataset = analytic(name);
    const FirstView view = view_of_data(*dataset);
    const Camera camera = view.camera(4.0 / 3);
    const PointArray& array = dataset->array(view.array);
    for (std::int64_t id = 0; id < dataset->grid.point_count(); ++id) {
      const double value = array.at(static_cast<std::size_t>(id));
      for (const FirstLayer& layer : view.layers)
        if (value >= layer.lower && value <= layer.upper) {
          for (const double at : on_picture(camera, dataset->grid.point(id), 4.0 / 3))
            ASSERT_LE(std::abs(at), 1) << name << " point " << id;
        }
    }
  }
}

TEST(FirstView, IsTheSameForAnyNumberOfThreads) {
  for (const std::string name : {"cylinder:24x24x12", "tets:16", "torus:64"}) {
    const auto dataset = analytic(name);
    const FirstView many = view_of_data(*dataset);
    set_thread_count(1);
    const FirstView one = view_of_data(*dataset);
    set_thread_count(0);
    EXPECT_EQ(many.layers, one.layers) << name;
    EXPECT_EQ(many.camera(1), one.camera(1)) << name;
  }
}

TEST(FirstView, FollowsTheValuesUnit) {
  const auto field = [](Vec3d p) { return std::exp(-4 * dot(p, p)) + 0.2 * p.x - 2; };
  const auto plain = field_dataset<double>({40, 40, 40}, field);
  const FirstView view = view_of_data(*plain);
  for (const auto& [factor, shift] : {std::pair{1000.0, 0.0}, std::pair{1.0, 273.0}, std::pair{0.01, -7.0}}) {
    const auto other = field_dataset<double>({40, 40, 40}, [&, f = factor, s = shift](Vec3d p) { return f * field(p) + s; });
    const FirstView scaled = view_of_data(*other);
    ASSERT_EQ(scaled.layers.size(), view.layers.size()) << factor;
    EXPECT_EQ(scaled.kind, view.kind);
    EXPECT_EQ(scaled.camera(1), view.camera(1));
    for (std::size_t i = 0; i < view.layers.size(); ++i) {
      EXPECT_NEAR((scaled.layers[i].lower - shift) / factor, view.layers[i].lower, 0.003) << factor << " + " << shift;
      EXPECT_NEAR((scaled.layers[i].upper - shift) / factor, view.layers[i].upper, 0.003);
      EXPECT_EQ(scaled.layers[i].color, view.layers[i].color);
    }
  }
}

TEST(FirstView, FollowsThePlacesUnit) {
  const auto here = field_dataset({40, 30, 20}, [](Vec3d p) { return std::exp(-5 * dot(p, p)); });
  auto there = field_dataset({40, 30, 20}, [](Vec3d p) { return std::exp(-5 * dot(p, p)); });
  UniformGrid& grid = std::get<UniformGrid>(there->grid.shape);
  grid.origin = {1000, -500, 20};
  grid.spacing = grid.spacing * 1000.0;
  there->bounds = there->grid.bounds();
  const FirstView a = view_of_data(*here), b = view_of_data(*there);
  EXPECT_EQ(a.layers, b.layers);
  EXPECT_EQ(a.direction, b.direction);
}

TEST(FirstView, OfATorusIsARingInsideAShell) {
  const auto torus = analytic("torus:64");
  const FirstView view = view_of_data(*torus);
  ASSERT_EQ(view.layers.size(), 2u);
  EXPECT_EQ(view.layers[0].lower, torus->arrays[0].lower);
  EXPECT_LT(view.layers[1].upper, 0.4) << "not the corners of the box";
  EXPECT_TRUE(view.layers[0].surface.upper);
  EXPECT_GT(view.layers[0].opacity, view.layers[1].opacity);
}

TEST(FirstView, OfALargeGridHasThinLayersWithTheSameSurfaces) {
  const FirstView whole = view_of_data(*analytic("torus:64")), thin = view_of_data(*analytic("torus:200"));
  ASSERT_EQ(thin.layers.size(), 2u);
  EXPECT_EQ(whole.layers[0].upper, whole.layers[1].lower);
  EXPECT_NEAR(thin.layers[0].upper, whole.layers[0].upper, 0.01) << "the ring's surface";
  EXPECT_NEAR(thin.layers[1].upper, whole.layers[1].upper, 0.01) << "the shell's surface";
  EXPECT_GT(thin.layers[1].lower, thin.layers[0].upper);
  EXPECT_LT(thin.layers[1].upper - thin.layers[1].lower, 0.5 * (whole.layers[1].upper - whole.layers[1].lower));
}

TEST(FirstView, OfMarschnerLobbIsOneWallFromAbove) {
  const FirstView view = view_of_data(*analytic("marschner-lobb:128"));
  EXPECT_EQ(view.kind, "waves");
  ASSERT_EQ(view.layers.size(), 1u);
  EXPECT_NEAR(view.layers[0].lower, 0.5, 0.1);
}

TEST(FirstView, OfCtNumbersIsBoneInSkinWhateverTheirZero) {
  std::mt19937_64 random(5);
  std::normal_distribution<double> noise(0, 15);
  for (const double zero : {0.0, 1024.0}) {
    const auto head = field_dataset<std::int16_t>({60, 60, 60}, [&](Vec3d p) {
      const double r = length(p);
      const double air_floor = zero == 0 ? -1024 : 0;
      return std::max((r < 0.7 ? 40 : r < 0.8 ? 900 : r < 0.9 ? 40 : -1000) + zero + noise(random), air_floor);
    });
    const FirstView view = view_of_data(*head);
    ASSERT_EQ(view.layers.size(), 2u) << zero;
    EXPECT_EQ(view.layers[0].name, "skin");
    EXPECT_EQ(view.layers[1].name, "bone");
    EXPECT_NEAR(view.layers[1].lower, 170 + zero, 1);
    EXPECT_EQ(format_rgb(view.layers[1].color), "#f2e6c8");
  }
}

TEST(FirstView, OfLabelsCutsBetweenWholeNumbers) {
  const auto labels = field_dataset<std::uint8_t>({40, 40, 40}, [](Vec3d p) {
    return length(p) < 0.3 ? 5 : length(p - Vec3d{0.5, 0.5, 0}) < 0.3 ? 3 : length(p + Vec3d{0.5, 0.5, 0}) < 0.3 ? 1 : 0;
  });
  const FirstView view = view_of_data(*labels);
  expect_sound(view, *labels);
  for (const FirstLayer& layer : view.layers)
    EXPECT_TRUE(layer.lower == 0 || layer.lower == std::floor(layer.lower) + 0.5) << layer.lower;

  // Each label is a lit body in a colour of its own, whole, so that nothing lies between two of them.
  EXPECT_EQ(view.kind, "labels");
  EXPECT_EQ(view.values, FieldValues::whole);
  ASSERT_EQ(view.layers.size(), 3u);
  const double values[] = {1, 3, 5};
  for (std::size_t i = 0; i < 3; ++i) {
    const FirstLayer& layer = view.layers[i];
    EXPECT_EQ(layer.name, "label " + std::to_string(static_cast<int>(values[i])));
    EXPECT_LT(layer.lower, values[i]);
    EXPECT_GE(layer.upper, values[i]);
    EXPECT_TRUE(layer.surface.lower && layer.surface.upper && layer.surface.domain);
    for (std::size_t k = 0; k < i; ++k) {
      EXPECT_NE(layer.color, view.layers[k].color);
      EXPECT_GE(layer.lower, view.layers[k].upper);
    }
  }
}

TEST(FirstView, OfLabelsThatFillTheDomainShowsEachAndOfManyTheLargest) {
  const auto phases = field_dataset<std::uint8_t>({40, 40, 40}, [](Vec3d p) { return (p.x > 0 ? 1 : 0) + (p.y > 0 ? 2 : 0); });
  const FirstView all = view_of_data(*phases);
  expect_sound(all, *phases);
  EXPECT_EQ(all.layers.size(), 4u) << "no background";

  const auto slices = field_dataset<std::int16_t>({60, 40, 40}, [](Vec3d p) {
    return p.y * p.y + p.z * p.z > 0.3 ? 0 : std::min(std::floor((p.x + 1) * 6), 11.0) * 10 + 100;
  });
  const FirstView largest = view_of_data(*slices);
  EXPECT_EQ(largest.kind, "labels");
  EXPECT_EQ(largest.layers.size(), 8u) << "of twelve";
}

/// Grains around random points, numbered as those come.
std::function<double(Vec3d)> grains(int count) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> place(-1, 1);
  std::vector<Vec3d> middles;
  for (int i = 0; i < count; ++i) middles.push_back({place(random), place(random), place(random)});
  return [middles](Vec3d p) {
    const auto nearest = std::min_element(middles.begin(), middles.end(), [&](Vec3d a, Vec3d b) { return length(p - a) < length(p - b); });
    return static_cast<double>(nearest - middles.begin()) + 1;
  };
}

TEST(FirstView, OfManyGrainsShowsTheLargest) {
  const FirstView view = view_of_data(*field_dataset<std::int16_t>({64, 64, 64}, grains(60)));
  EXPECT_EQ(view.kind, "labels");
  EXPECT_EQ(view.layers.size(), 8u);
  const FirstView of_reals = view_of_data(*field_dataset<float>({64, 64, 64}, grains(60)));
  ASSERT_EQ(of_reals.layers.size(), 8u) << "many programs write labels as reals";
  for (std::size_t i = 0; i < 8; ++i) EXPECT_EQ(of_reals.layers[i].name, view.layers[i].name);
}

/// What is dark on a bright ground is as much an object as what is bright on a dark one: the layers of f and of -f are the same solids.
TEST(FirstView, OfAnObjectBelowItsBackgroundIsThatOfTheFieldTurnedOver) {
  std::mt19937_64 random(9);
  std::normal_distribution<double> noise(0, 20);
  std::vector<double> values;
  const auto object = [&](Vec3d p) { return (length(p) < 0.4 ? 3050 : length(p) < 0.7 ? 2650 : 0) + noise(random); };
  const auto bright = field_dataset({48, 48, 48}, [&](Vec3d p) { return values.emplace_back(object(p)); });
  std::size_t next = 0;
  const auto dark = field_dataset({48, 48, 48}, [&](Vec3d) { return -values[next++]; });
  const FirstView of_bright = view_of_data(*bright), of_dark = view_of_data(*dark);
  EXPECT_EQ(of_bright.kind, "image");
  EXPECT_EQ(of_dark.kind, "image");
  ASSERT_EQ(of_bright.layers.size(), 2u);
  ASSERT_EQ(of_dark.layers.size(), 2u);
  EXPECT_GT(of_bright.layers[0].lower, 100);
  for (std::size_t i = 0; i < 2; ++i) {
    const FirstLayer& turned = of_dark.layers[1 - i];  // layers rise
    EXPECT_NEAR(turned.upper, -of_bright.layers[i].lower, 20) << i;
    EXPECT_NEAR(turned.lower, -of_bright.layers[i].upper, 20) << i;
    EXPECT_EQ(turned.surface.opacity, of_bright.layers[i].surface.opacity) << i;
  }
  expect_sound(of_dark, *dark);
}

TEST(FirstView, OfLabelsInsideAnotherLooksThroughThatOne) {
  const auto nested = field_dataset<std::uint8_t>({40, 40, 40}, [](Vec3d p) { return length(p) > 0.9 ? 0 : length(p) > 0.7 ? 1 : length(p) > 0.5 ? 2 : p.x > 0 ? 3 : 7; });
  const FirstView view = view_of_data(*nested);
  ASSERT_EQ(view.layers.size(), 4u);
  EXPECT_EQ(view.layers[0].name, "label 1");
  for (const std::size_t outer : {0, 1}) EXPECT_LT(view.layers[outer].surface.opacity, 0.5) << outer;
  for (const std::size_t inner : {2, 3}) EXPECT_GT(view.layers[inner].surface.opacity, 0.9) << inner;
  const auto beside = field_dataset<std::uint8_t>({40, 40, 40}, [](Vec3d p) { return length(p) > 0.9 ? 0 : p.x > 0.3 ? 1 : p.x > -0.2 ? 3 : 7; });
  for (const FirstLayer& layer : view_of_data(*beside).layers) EXPECT_GT(layer.surface.opacity, 0.9) << layer.name;
}

TEST(FindLabels, AreFewWholeNumbersThatHoldTogether) {
  std::mt19937_64 random(7);
  const auto values = [](const auto& dataset) { return find_labels(dataset->arrays[0]); };
  EXPECT_EQ(values(field_dataset<std::uint8_t>({20, 20, 20}, [](Vec3d p) { return p.x < -0.5 ? 2 : p.x > 0.5 ? 9 : 4; })), (std::vector<double>{2, 4, 9}));
  EXPECT_TRUE(values(field_dataset<std::uint8_t>({20, 20, 20}, [&](Vec3d) { return random() % 4; })).empty()) << "noise";
  EXPECT_TRUE(values(field_dataset<std::uint8_t>({20, 20, 20}, [](Vec3d p) { return p.x > 0; })).empty()) << "a mask";
  EXPECT_EQ(values(field_dataset<float>({20, 20, 20}, [](Vec3d p) { return p.x < -0.5 ? 2 : p.x > 0.5 ? 9 : 4; })), (std::vector<double>{2, 4, 9})) << "whole, though not by type";
  EXPECT_TRUE(values(field_dataset<float>({20, 20, 20}, [](Vec3d p) { return p.x < -0.5 ? 2 : p.x > 0.5 ? 9 : 4.5; })).empty());
  EXPECT_TRUE(values(field_dataset<std::int16_t>({50, 20, 20}, [](Vec3d p) { return std::round(p.x * 100); })).empty()) << "many values";
  EXPECT_EQ(values(field_dataset<std::int16_t>({64, 64, 64}, grains(60))).size(), 60u);
  const auto atlas = [](Vec3d p) {  // along x three areas whose numbers follow each other, and then three with numbers far from these
    const auto at = [](double x, int n) { return std::clamp(static_cast<int>((x + 1) / 2 * n), 0, n - 1); };
    const int part = at(p.x, 12), group = part / 3;
    return length(p) > 1 ? 0 : 1 + 24 * (group % 2) + 12 * (group / 2) + 3 * at(p.y, 4) + part % 3;
  };
  EXPECT_EQ(values(field_dataset<std::uint8_t>({90, 90, 90}, atlas)).size(), 49u);
  const auto rounded = [](Vec3d p) { return std::round(120 * std::exp(-2 * dot(p, p)) + 40 * std::sin(3 * p.x)); };
  EXPECT_TRUE(values(field_dataset<std::int16_t>({200, 60, 60}, rounded)).empty()) << "a smooth quantity, of which most neighbours are alike";
  const auto in_nothing = [&](Vec3d p) { return length(p) < 0.5 ? rounded(p) : 0; };
  EXPECT_TRUE(values(field_dataset<std::uint8_t>({200, 60, 60}, in_nothing)).empty());
}

TEST(FirstView, OfASheetIsBandsFromItsBroadSide) {
  const auto sheet = field_dataset({80, 60, 3}, [](Vec3d p) { return std::exp(-3 * (p.x * p.x + p.y * p.y)); });
  const FirstView view = view_of_data(*sheet);
  EXPECT_EQ(view.kind, "sheet");
  EXPECT_EQ(view.layers.size(), 4u);
  EXPECT_GT(std::abs(view.direction.z), 0.7);
  expect_sound(view, *sheet);
}

TEST(FirstView, OfMetresOverDegreesIsAMap) {
  const auto ocean = field_dataset({72, 36, 12}, [](Vec3d p) { return p.x * p.x + p.y < -0.2 ? NAN : 30 * std::cos(1.5 * p.y) * std::exp(-3 * (p.z + 1)); });
  std::vector<double> levels, longitudes, latitudes;
  for (int i = 0; i < 12; ++i) levels.push_back(-40.0 * (11 - i) * (11 - i));
  for (int i = 0; i < 72; ++i) longitudes.push_back(5 * i);
  for (int i = 0; i < 36; ++i) latitudes.push_back(-87.5 + 5 * i);
  ocean->grid.shape = RectilinearGrid{{72, 36, 12}, {longitudes, latitudes, levels}};
  ocean->bounds = ocean->grid.bounds();
  const FirstView view = view_of_data(*ocean);
  expect_sound(view, *ocean);
  EXPECT_EQ(view.kind, "sheet");
  EXPECT_EQ(view.axis_scale, (Vec3d{1, 1, 0.005}));
  EXPECT_GT(view.direction.z, 0.7) << "from above";
  EXPECT_LT(view.direction.y, 0) << "and from the south";
  EXPECT_EQ(view.up, (Vec3d{0, 1, 0}));
  const Box3d drawn = scaled(ocean->bounds, view.axis_scale);
  for (const Vec3d& p : view.outline)
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_GE(p[axis], drawn.lower[axis] - 0.1 * drawn.diagonal());
      EXPECT_LE(p[axis], drawn.upper[axis] + 0.1 * drawn.diagonal());
    }

  auto points = std::make_shared<std::vector<Vec3f>>();
  for (std::int64_t id = 0; id < ocean->grid.point_count(); ++id) {
    const Vec3d p = ocean->grid.point(id);
    points->push_back({static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)});
  }
  Dataset curved = *ocean;
  curved.grid.shape = CurvilinearGrid{{72, 36, 12}, std::span<const Vec3f>(*points)};
  curved.grid.storage = points;
  const FirstView of_curved = view_of_data(curved);
  EXPECT_EQ(of_curved.direction, view.direction);
  EXPECT_EQ(of_curved.axis_scale, view.axis_scale);
}

TEST(FirstView, OfALongTunnelIsOfItsSide) {
  const auto tunnel = field_dataset({20, 20, 200}, [](Vec3d p) { return 1 - (p.x + 0.9) * (p.x + 0.9) - (p.y + 0.9) * (p.y + 0.9) + 0.01 * std::sin(9 * p.z); });
  EXPECT_EQ(view_of_data(*tunnel).axis_scale, kUnscaled);
}

TEST(FirstView, KeepsTheArrayThatIsAskedFor) {
  const auto dataset = analytic("cylinder:24x24x12");
  const FirstView view = view_of_data(*dataset, "Energy");
  EXPECT_EQ(view.array, "Energy");
  expect_sound(view, *dataset);
  EXPECT_THROW(view_of_data(*dataset, "energy of nothing"), Error);
}

TEST(FirstView, OfASeriesLooksAtFiveStepsAndTheLayersReachToTheEndsOfAll) {
  int opened = 0;
  const auto steps = [&](int step, const Task&) {
    ++opened;
    return analytic("cylinder:16x12x8x9", step);
  };
  const FirstView view = first_view(*analytic("cylinder:16x12x8x9"), steps, {}, Task());
  EXPECT_EQ(opened, 4) << "the first is there";
  EXPECT_EQ(view.step, 4);
  ValueRange range;
  for (const int step : {0, 2, 4, 6, 8}) {
    const auto dataset = analytic("cylinder:16x12x8x9", step);
    range = join(range, {dataset->array(view.array).lower, dataset->array(view.array).upper});
  }
  EXPECT_EQ(view.layers.front().lower, range.lower);
  EXPECT_EQ(view.layers.back().upper, range.upper);
}

TEST(FirstView, LeavesOutAnArrayThatIsConstantAtEveryStepAndTakesTheStepWhereTheValuesSpread) {
  const auto at = [](int step) {
    auto dataset = field_dataset({20, 20, 20}, [step](Vec3d p) { return step * std::exp(-3 * dot(p, p)); });
    dataset->arrays.insert(dataset->arrays.begin(), array_of("Density", std::vector<float>(8000, 2)));
    dataset->times = {0, 1, 2};
    dataset->step = step == 9 ? 2 : 0;
    return dataset;
  };
  const auto steps = [&](int step, const Task&) -> std::shared_ptr<const Dataset> {
    auto dataset = at(step == 2 ? 9 : 0);
    dataset->step = step;
    return dataset;
  };
  const FirstView view = first_view(*at(0), steps, {}, Task());
  EXPECT_EQ(view.array, "value");
  EXPECT_EQ(view.step, 2);
}

TEST(FirstView, OfASoundInTheAirIsThatOfTheSoundAlone) {
  const auto sound = [](Vec3d p) { return std::exp(-8 * dot(p, p)); };
  const FirstView alone = view_of_data(*field_dataset<double>({30, 30, 30}, sound));
  const FirstView in_air = view_of_data(*field_dataset<double>({30, 30, 30}, [&](Vec3d p) { return 101325 + 0.02 * sound(p); }));
  ASSERT_EQ(in_air.layers.size(), alone.layers.size());
  for (std::size_t i = 0; i < alone.layers.size(); ++i) EXPECT_NEAR((in_air.layers[i].lower - 101325) / 0.02, alone.layers[i].lower, 1e-3) << "a number with few digits";
  EXPECT_EQ(in_air.camera(1), alone.camera(1));
}

TEST(FirstView, OfBadDataSaysWhyThereIsNothing) {
  const auto nothing = [](const std::shared_ptr<Dataset>& dataset) {
    const FirstView view = view_of_data(*dataset);
    EXPECT_TRUE(view.array.empty());
    EXPECT_TRUE(view.layers.empty());
    return view.array_reason;
  };
  EXPECT_EQ(nothing(field_dataset({8, 8, 8}, [](Vec3d) { return 4; })), "every array has one value everywhere");
  const auto nearly = [](Vec3d p) { return 4 + 1e-12 * p.x; };
  EXPECT_EQ(nothing(field_dataset<double>({8, 8, 8}, nearly)), "every array has nearly one value everywhere: 'value' differs by less than one part in 1e+09");
  EXPECT_EQ(nothing(field_dataset({8, 8, 8}, [](Vec3d) { return NAN; })), "no array has a finite value");
  EXPECT_EQ(nothing(field_dataset({8, 1, 1}, [](Vec3d p) { return p.x; })),
            "the dataset has no cells: one point or one line of points has no inside");
  auto without = field_dataset({8, 8, 8}, [](Vec3d p) { return p.x; });
  without->arrays.clear();
  EXPECT_EQ(nothing(without), "the dataset has no array");
}

TEST(FirstView, OfOddDataIsSound) {
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> uniform(0, 1);
  const std::pair<const char*, std::shared_ptr<Dataset>> odd[] = {
      {"one cell", field_dataset({2, 2, 2}, [](Vec3d p) { return p.x + p.y * p.z; })},
      {"a plane", field_dataset({30, 20, 1}, [](Vec3d p) { return p.x * p.y; })},
      {"noise", field_dataset({40, 40, 40}, [&](Vec3d) { return uniform(random); })},
      {"nearly all in one bin", field_dataset<double>({40, 40, 40}, [](Vec3d p) { return p.x > 0.9 ? 1e9 * p.y : 1e-9 * p.z; })},
      {"tiny components", field_dataset({60, 60, 60}, [&](Vec3d) { return uniform(random) > 0.95 ? 1 : 0; })},
      {"one point alone differs", field_dataset({40, 40, 40},
                                                [](Vec3d p) {
                                                  return length(p - Vec3d{-1, -1, -1}) < 0.01 ? 1 : 0;
                                                })},
      {"half has no value", field_dataset({40, 40, 40}, [](Vec3d p) { return p.x > 0 ? NAN : p.y; })},
      {"whole doubles", field_dataset<double>({20, 20, 20}, [](Vec3d p) { return 1.7e308 * p.x; })},
      {"subnormal", field_dataset<double>({20, 20, 20}, [](Vec3d p) { return 1e-310 * p.x; })},
      {"two planes of points", field_dataset({2, 60, 60}, [](Vec3d p) { return p.y * p.z; })},
      {"a row of cells", field_dataset({60, 2, 2}, [](Vec3d p) { return p.x; })}};
  for (const auto& [name, dataset] : odd) {
    SCOPED_TRACE(name);
    expect_sound(view_of_data(*dataset), *dataset);
  }
}

TEST(FirstView, OfNoiseIsItsUpperHalfForEndsWouldBeDust) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> uniform(0, 1);
  const auto noise = field_dataset({30, 30, 30}, [&](Vec3d) { return uniform(random); });
  const FirstView view = view_of_data(*noise);
  EXPECT_EQ(view.kind, "noise");
  ASSERT_EQ(view.layers.size(), 1u);
  EXPECT_NEAR(view.layers[0].lower, 0.5, 0.05);
  EXPECT_EQ(view.layers[0].upper, noise->arrays[0].upper);
  EXPECT_TRUE(view.layers[0].surface.lower && view.layers[0].surface.domain);
}

TEST(FirstView, OfAnObjectInNoiseIsTheObject) {
  for (const bool bright : {true, false}) {
    std::mt19937_64 random(5);
    std::normal_distribution<double> normal(0, 12);
    const auto scan = field_dataset<std::uint8_t>({48, 48, 48}, [&](Vec3d p) {
      const double value = std::clamp((length(p) > 0.5 && length(p) < 0.7 ? 130.0 : 20.0) + normal(random), 0.0, 255.0);
      return bright ? value : 255 - value;
    });
    const FirstView view = view_of_data(*scan);
    EXPECT_EQ(view.kind, "image");
    ASSERT_EQ(view.layers.size(), 2u);
    double lower = view.layers[0].lower, upper = view.layers[1].upper;
    if (!bright) std::tie(lower, upper) = std::pair(255 - upper, 255 - lower);
    EXPECT_GT(lower, 30) << "most of the noise is not in it";
    EXPECT_LT(lower, 110) << "and the shell is";
    EXPECT_EQ(bright ? view.layers[1].upper : view.layers[0].lower, bright ? scan->arrays[0].upper : scan->arrays[0].lower);
  }
}

TEST(FirstView, LeavesOutWhatStandsForNoValue) {
  const auto field = [](Vec3d p) { return 15 + 8 * std::sin(3 * p.x) * std::cos(2 * p.y) + 4 * p.z; };
  for (const double missing : {-9999.0, 1e20, 9.969209968386869e36, -99999.0, -5e4}) {
    SCOPED_TRACE(missing);
    const auto holed = field_dataset({40, 40, 40}, [&](Vec3d p) { return p.x + p.y > 0.7 ? missing : field(p); });
    const auto found = find_missing(holed->arrays[0]);
    ASSERT_TRUE(found);
    EXPECT_EQ(found->value, static_cast<double>(static_cast<float>(missing)));
    EXPECT_GT(found->lower, 0);
    EXPECT_LT(found->upper, 30);
    const FirstView view = view_of_data(*holed);
    EXPECT_NE(view.array_reason.find("stands for no value"), std::string::npos) << view.array_reason;
    ASSERT_FALSE(view.layers.empty());
    for (const FirstLayer& layer : view.layers) {
      EXPECT_GE(layer.lower, found->lower);
      EXPECT_LE(layer.upper, found->upper);
    }
    // A layer at the end where the missing values are would line them.
    if (missing < 0)
      EXPECT_EQ(view.layers.back().upper, found->upper);
    else
      EXPECT_EQ(view.layers.front().lower, found->lower);
  }
}

TEST(FirstView, BesideALargeNumberThatStandsForNoValueIsNoDust) {
  const auto blob = field_dataset({24, 24, 24}, [](Vec3d p) {
    const double value = std::exp(-3 * dot(p, p));
    return value < 0.2 ? 1e30 : value;
  });
  const FirstView view = view_of_data(*blob);
  ASSERT_GE(view.layers.size(), 2u);
  for (const FirstLayer& layer : view.layers) EXPECT_GT(layer.upper - layer.lower, 0.005) << layer.reason;
}

TEST(FindMissing, IsFarFromAllOthersAndNoPhaseOfSomething) {
  const auto of = [](auto field) { return find_missing(field_dataset({20, 20, 20}, field)->arrays[0]); };
  const auto wave = [](Vec3d p) { return std::sin(5 * p.x) + p.y; };
  EXPECT_FALSE(of(wave));
  EXPECT_FALSE(of([&](Vec3d p) { return p.z > 0.5 ? 10.0 : wave(p); })) << "a body of another value";
  EXPECT_FALSE(of([&](Vec3d p) { return p.z > 0.5 ? -9999.0 : 1.0; })) << "two values alone";
  EXPECT_FALSE(of([&](Vec3d p) { return p.z > 0.5 ? 999.0 : 600 + 300 * wave(p); })) << "near the others";
  EXPECT_FALSE(of([&](Vec3d p) { return p.x * p.x + p.y * p.y + p.z * p.z < 1e-3 ? 1e5 : wave(p); })) << "a peak";
  EXPECT_FALSE(of([&](Vec3d p) { return p.z > 0.5 ? 1000.0 : 1.15862 + 1e-4 * wave(p); })) << "the density of water beside air";
  EXPECT_TRUE(of([&](Vec3d p) { return p.z > 0.5 ? 1e5 : wave(p); }));
}

TEST(FirstView, CutsNoLayerAtTheValueThatMostPlacesHave) {
  // A blast: at rest outside of the shock, but for the last digits.
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> digits(-1e-6, 1e-6);
  const auto blast = field_dataset({48, 48, 48}, [&](Vec3d p) {
    const double r = length(p);
    return r < 0.6 ? 0.1 + 3.6 * std::pow(r / 0.6, 6) : 1 + digits(random);
  });
  const FirstView view = view_of_data(*blast);
  ASSERT_EQ(view.layers.size(), 2u);
  for (const FirstLayer& layer : view.layers)
    for (const double end : {layer.lower, layer.upper}) EXPECT_GT(std::abs(end - 1), 0.01) << view.layers[0].reason;
}

TEST(FirstView, OfAFlowInAChannelIsItsCoreAndNoLiningOfTheWalls) {
  const auto channel = field_dataset({100, 40, 40}, [](Vec3d p) {
    const double y = (p.y + 1) / 0.8, z = (p.z + 1) / 0.8;  // the box is 2 x 0.79 x 0.79
    return std::sqrt(std::max(0.0, y * (1 - y) * z * (1 - z))) * (1 + 0.3 * std::sin(8 * p.x));
  });
  const FirstView view = view_of_data(*channel);
  for (const FirstLayer& layer : view.layers) EXPECT_GT(layer.lower, 0.1 * channel->arrays[0].upper) << view.kind_reason;
}

TEST(FirstView, BecomesASceneAsItIs) {
  const FirstView view = view_of_data(*analytic("torus:32"));
  const auto intervals = first_intervals(view);
  ASSERT_EQ(intervals.size(), view.layers.size());
  for (std::size_t i = 0; i < intervals.size(); ++i) {
    EXPECT_EQ(intervals[i].lower, view.layers[i].lower);
    EXPECT_EQ(intervals[i].color, view.layers[i].color);
    EXPECT_EQ(intervals[i].surface, view.layers[i].surface);
    EXPECT_EQ(intervals[i].number, i + 1);
  }
}

// ---- arrays ----

std::vector<std::string> ranked(const std::vector<std::string>& names) {
  auto dataset = field_dataset({12, 12, 12}, [](Vec3d p) { return p.x; });
  dataset->arrays.clear();
  for (const std::string& name : names) {
    std::vector<float> values;
    for (int i = 0; i < 12 * 12 * 12; ++i) values.push_back(static_cast<float>(i % 97));
    dataset->arrays.push_back(array_of(name, std::move(values)));
  }
  const Dataset* const step = dataset.get();
  std::vector<std::string> order;
  for (const ArrayChoice& choice : rank_arrays({&step, 1})) order.push_back(choice.name);
  return order;
}

TEST(RankArrays, BookkeepingComesLastHoweverItIsSpelled) {
  for (const std::string name : {"IBlank", "vtkGhostLevels", "GlobalNodeIds", "node_id", "ObjectId", "ids", "BlockI", "proc_id",
                                 "rank", "time", "error_estimate"})
    EXPECT_EQ(ranked({name, "humidity"}).front(), "humidity") << name;
  for (const std::string name : {"humidity", "avoid", "grids", "Residence", "rapid"})
    EXPECT_EQ(ranked({name, "zzz"}).front(), name) << name << " is a field";
}

TEST(RankArrays, WhatPeopleLookAtComesFirst) {
  EXPECT_EQ(ranked({"p", "U_x", "T", "vonMises"}), (std::vector<std::string>{"vonMises", "T", "p", "U_x"}));
  EXPECT_EQ(ranked({"humidity", "pressure"}).front(), "pressure");
}

}  // namespace
}  // namespace isostrata
