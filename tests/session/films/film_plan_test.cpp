#include "session/films/film_plan.h"

#include <gtest/gtest.h>

#include <limits>
#include <map>

#include "support/fin_facts.h"

namespace isostrata {
namespace {

constexpr double kTiny = 1e-12;

v1::NewFilm film(double turn_deg, double seconds = 0, double rate = 0) {
  v1::NewFilm wanted;
  wanted.set_turn_deg(turn_deg);
  wanted.set_seconds(seconds);
  wanted.set_frames_per_second(rate);
  return wanted;
}
v1::NewFilm of_steps(std::uint32_t first, std::uint32_t last, std::uint32_t stride = 0) {
  v1::NewFilm wanted;
  wanted.set_first_step(first);
  wanted.set_last_step(last);
  wanted.set_step_stride(stride);
  return wanted;
}
FilmPlan planned(const v1::NewFilm& wanted, const Scene& scene = {}, const DatasetFacts& facts = fin_facts()) {
  FilmPlan plan;
  const auto error = plan_film(wanted, scene, facts, plan);
  EXPECT_FALSE(error) << error->message();
  return plan;
}
std::vector<int> steps_of(const FilmPlan& plan) {
  std::vector<int> steps;
  for (int i = 0; i < plan.pictures; ++i) steps.push_back(plan.scene_of(i).step);
  return steps;
}
Scene looking(Vec3d eye, Vec3d up) {
  Scene scene;
  scene.camera = Camera{eye, {1, 2, 3}, up, 30, false};
  return scene;
}

TEST(FilmPlan, ACameraTurnsOnACircleAsTheRightHandDoes) {
  const Camera camera{{5, 0, 1}, {1, 0, 0}, {0, 0, 2}, 30, true};
  const Camera quarter = turned(camera, 90);
  EXPECT_LT(length(quarter.eye - Vec3d{1, 4, 1}), kTiny);
  EXPECT_EQ(quarter.up, camera.up);
  EXPECT_EQ(quarter.at, camera.at);
  EXPECT_TRUE(quarter.orthographic);
  for (const double angle : {-200.0, 10.0, 77.7})
    for (const double more : {-33.0, 180.0}) EXPECT_LT(length(turned(turned(camera, angle), more).eye - turned(camera, angle + more).eye), 1e-11);
  EXPECT_LT(length(turned(camera, 360).eye - camera.eye), 1e-11);
}

TEST(FilmPlan, AWholeTurnBeginsAgainWithoutAHalt) {
  const FilmPlan plan = planned(film(360, 2, 25), looking({4, 5, 6}, {0, 1, 1}));
  EXPECT_EQ(plan.pictures, 50);
  const Camera first = *plan.scene_of(0).camera;
  EXPECT_EQ(first, *plan.scene.camera);
  const double step = length(plan.scene_of(1).camera->eye - first.eye);
  for (int i = 0; i < plan.pictures; ++i) {
    const Camera camera = *plan.scene_of(i).camera;
    EXPECT_NEAR(length(camera.eye - camera.at), length(first.eye - first.at), 1e-11);
    EXPECT_NEAR(length(turned(camera, 360.0 / 50).eye - camera.eye), step, 1e-11);
    EXPECT_EQ(plan.scene_of(i).revision, static_cast<std::uint64_t>(i) + 1);
  }
  EXPECT_NEAR(length(plan.scene_of(49).camera->eye - first.eye), step, 1e-11);
  EXPECT_EQ(plan.begins_ms(0), 0);
  EXPECT_EQ(plan.begins_ms(1), 40);
  EXPECT_EQ(plan.begins_ms(50), 2000);
}

TEST(FilmPlan, WithoutACameraTheWholeBoxTurns) {
  const FilmPlan plan = planned(film(90));
  EXPECT_EQ(plan.pictures, 180);
  EXPECT_EQ(plan.seconds, 6);
  EXPECT_EQ(*plan.scene_of(0).camera, view_of(fin_facts().bounds, "reset", 1280.0 / 720));
}

TEST(FilmPlan, EachStepIsOnePictureIfTheCameraStandsStill) {
  DatasetFacts facts = fin_facts();
  facts.times.assign(10, 0);
  Scene scene;
  scene.time = 1.5;
  const FilmPlan all = planned(of_steps(0, 9), scene, facts);
  EXPECT_EQ(steps_of(all), (std::vector{0, 1, 2, 3, 4, 5, 6, 7, 8, 9}));
  EXPECT_FALSE(all.scene_of(3).time);
  EXPECT_NEAR(all.seconds, 1, kTiny);
  EXPECT_EQ(all.begins_ms(7), 700);
  EXPECT_FALSE(all.scene_of(3).camera);
  EXPECT_EQ(steps_of(planned(of_steps(8, 1, 3), scene, facts)), (std::vector{8, 5, 2}));
  EXPECT_EQ(steps_of(planned(of_steps(4, 4), scene, facts)), std::vector{4});
  v1::NewFilm from;
  from.set_first_step(7);
  EXPECT_EQ(steps_of(planned(from, scene, facts)), (std::vector{7, 8, 9}));
}

TEST(FilmPlan, StepsShareATurnEvenlyAndNoneIsLeftOut) {
  DatasetFacts facts = fin_facts();
  facts.times.assign(7, 0);
  v1::NewFilm wanted = of_steps(0, 6);
  wanted.set_turn_deg(-90);
  wanted.set_seconds(1);
  for (const double rate : {2.0, 7.0, 10.0, 60.0}) {
    wanted.set_frames_per_second(rate);
    const FilmPlan plan = planned(wanted, looking({4, 5, 6}, {0, 1, 0}), facts);
    EXPECT_EQ(plan.pictures, std::max(7, static_cast<int>(rate)));
    std::map<int, int> shown;
    for (const int step : steps_of(plan)) ++shown[step];
    EXPECT_EQ(shown.size(), 7u);
    for (const auto& [step, times] : shown) EXPECT_NEAR(times, plan.pictures / 7.0, 1) << step;
  }
}

TEST(FilmPlan, WhatIsNoFilmIsRefusedByTheFieldThatIsWrong) {
  const auto with = [](const auto& change) {
    v1::NewFilm wanted = film(360);
    change(wanted);
    return wanted;
  };
  const std::vector<std::pair<v1::NewFilm, std::string>> wrong = {
      {v1::NewFilm(), "turn_deg"},
      {film(0, 5), "turn_deg"},
      {film(40'000), "turn_deg"},
      {film(std::numeric_limits<double>::quiet_NaN()), "turn_deg"},
      {film(360, -1), "seconds"},
      {film(360, 3601), "seconds"},
      {film(360, std::numeric_limits<double>::infinity()), "seconds"},
      {film(360, 6, 61), "frames_per_second"},
      {film(360, 3600, 60), "seconds"},
      {with([](auto& f) { f.set_width(3841); }), "width"},
      {with([](auto& f) { f.set_height(2161); }), "height"},
      {with([](auto& f) { f.set_samples(5); }), "samples"},
      {with([](auto& f) { f.set_step_stride(2); }), "step_stride"},
      {of_steps(3, 0), "first_step"},
      {of_steps(0, 3), "last_step"},
      {of_steps(0, 4'000'000'000u), "last_step"},
      {with([](auto& f) {
         f = of_steps(0, 2);
         f.set_seconds(0.01);
       }),
       "seconds"},
  };
  for (const auto& [wanted, field] : wrong) {
    FilmPlan plan;
    const auto error = plan_film(wanted, {}, fin_facts(), plan);
    ASSERT_TRUE(error) << wanted.ShortDebugString();
    EXPECT_EQ(error->field(), field) << wanted.ShortDebugString() << error->message();
  }
}

}  // namespace
}  // namespace isostrata
