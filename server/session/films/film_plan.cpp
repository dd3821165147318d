#include "session/films/film_plan.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "scene/axis_scale.h"
#include "session/commands/command_checks.h"
#include "session/wire/wire.h"

namespace isostrata {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kDefaultSeconds = 6, kDefaultRate = 30, kSecondsOfStep = 0.1;

int side(std::uint32_t wanted, int otherwise, int most, const char* field) {
  if (wanted > static_cast<std::uint32_t>(most))
    refuse("invalid_argument", std::string(field) + " is " + std::to_string(wanted) + "; expected at most " + std::to_string(most), field);
  return wanted == 0 ? otherwise : static_cast<int>(wanted);
}

int step_of(std::uint32_t step, std::size_t steps, const char* field) {
  if (step >= steps)
    refuse("invalid_argument", std::string(field) + " is " + std::to_string(step) + "; the dataset has the steps 0.." + std::to_string(steps - 1), field);
  return static_cast<int>(step);
}

std::vector<int> steps_of(const v1::NewFilm& wanted, std::size_t steps) {
  if (!wanted.has_first_step() && !wanted.has_last_step()) {
    if (wanted.step_stride() > 0) refuse("invalid_argument", "step_stride without first_step or last_step", "step_stride");
    return {};
  }
  const int first = wanted.has_first_step() ? step_of(wanted.first_step(), steps, "first_step") : 0;
  const int last = wanted.has_last_step() ? step_of(wanted.last_step(), steps, "last_step") : static_cast<int>(steps) - 1;
  const std::int64_t stride = std::max<std::int64_t>(wanted.step_stride(), 1);
  std::vector<int> all;
  for (std::int64_t at = 0; at <= std::abs(last - first); at += stride) all.push_back(static_cast<int>(first < last ? first + at : first - at));
  return all;
}

/// Zero is `otherwise`.
double positive(double value, double otherwise, double most, const char* field) {
  if (value == 0) return otherwise;
  return within(value, 1e-3, most, field);
}

FilmPlan planned(const v1::NewFilm& wanted, const Scene& scene, const DatasetFacts& dataset) {
  FilmPlan plan;
  plan.scene = scene;
  plan.width = side(wanted.width(), plan.width, kMaxFilmWidth, "width");
  plan.height = side(wanted.height(), plan.height, kMaxFilmHeight, "height");
  plan.samples = side(wanted.samples(), plan.samples, kMaxFilmSamples, "samples");
  if (wanted.has_annotations()) plan.annotations = annotations_of(wanted.annotations());
  plan.turn_deg = within(wanted.turn_deg(), -kMaxFilmTurn, kMaxFilmTurn, "turn_deg");
  plan.steps = steps_of(wanted, dataset.times.size());
  const bool turns = plan.turn_deg != 0;
  if (!turns && plan.steps.empty())
    refuse("invalid_argument", "nothing moves in this film; expected turn_deg, or first_step and last_step of a dataset of several steps", "turn_deg");
  const auto steps = static_cast<double>(plan.steps.size());
  plan.seconds = positive(wanted.seconds(), turns ? kDefaultSeconds : steps * kSecondsOfStep, kMaxFilmSeconds, "seconds");
  const double rate = positive(wanted.frames_per_second(), kDefaultRate, kMaxFilmRate, "frames_per_second");
  const double pictures = std::max(steps, turns ? std::max(1.0, std::round(plan.seconds * rate)) : 0);
  if (pictures > kMaxFilmPictures)
    refuse("too_large", number_text(pictures) + " pictures; expected at most " + std::to_string(kMaxFilmPictures) + ": a shorter film, or fewer a second",
           "seconds");
  if (pictures / plan.seconds > kMaxFilmRate + 1e-6)
    refuse("invalid_argument",
           number_text(pictures) + " pictures in " + number_text(plan.seconds) + " seconds; expected at most " + number_text(kMaxFilmRate) +
               " a second: a longer film, or a larger step_stride",
           "seconds");
  plan.pictures = static_cast<int>(pictures);
  if (turns && !scene.camera)
    plan.scene.camera = view_of(scaled(dataset.bounds, scene.axis_scale), "reset", static_cast<double>(plan.width) / plan.height);
  return plan;
}

}  // namespace

std::optional<v1::Error> plan_film(const v1::NewFilm& wanted, const Scene& scene, const DatasetFacts& dataset, FilmPlan& plan) {
  try {
    plan = planned(wanted, scene, dataset);
  } catch (Refused& refused) {
    return std::move(refused.error);
  }
  return std::nullopt;
}

Camera turned(const Camera& camera, double degrees) {
  const Vec3d axis = normalized(camera.up), arm = camera.eye - camera.at;
  const double angle = degrees * kPi / 180, c = std::cos(angle), s = std::sin(angle);
  Camera to = camera;
  to.eye = camera.at + arm * c + cross(axis, arm) * s + axis * (dot(axis, arm) * (1 - c));  // Rodrigues
  return to;
}

Scene FilmPlan::scene_of(int picture) const {
  Scene of = scene;
  of.revision = static_cast<std::uint64_t>(picture) + 1;
  if (turn_deg != 0 && of.camera) of.camera = turned(*of.camera, turn_deg * picture / pictures);
  if (!steps.empty()) {
    of.step = steps[static_cast<std::size_t>(static_cast<std::int64_t>(picture) * static_cast<std::int64_t>(steps.size()) / pictures)];
    of.time.reset();
  }
  return of;
}

std::int64_t FilmPlan::begins_ms(int picture) const { return std::llround(seconds * 1000 * picture / pictures); }

}  // namespace isostrata
