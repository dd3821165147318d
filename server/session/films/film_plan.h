// Which pictures a film is made of, and when each is shown.
#pragma once

#include <optional>
#include <vector>

#include "engine/data/dataset_facts.h"
#include "isostrata/v1/isostrata.pb.h"
#include "scene/scene.h"

namespace isostrata {

constexpr int kMaxFilmWidth = 3840, kMaxFilmHeight = 2160;
constexpr int kMaxFilmPictures = 10'000;
constexpr int kMaxFilmSamples = 4;           // each way
constexpr double kMaxFilmSeconds = 3600, kMaxFilmRate = 60, kMaxFilmTurn = 36'000;

/// A film without a turn has a picture for each step. One with a turn has as many as its rate and its length ask for, and at least one for each step:
/// steps share them evenly, and the last picture is one before the turn's end, so that a whole turn begins again without a halt.
struct FilmPlan {
  Scene scene;  // as the engine is told it, at its first picture
  int width = 1280, height = 720;
  int samples = 2;
  std::optional<Annotations> annotations;  // in place of the scene's
  double turn_deg = 0;
  double seconds = 6;
  std::vector<int> steps;  // in the order they are shown; empty: what the scene shows
  int pictures = 0;

  /// Of one picture, from 0. Its revision is its number from 1.
  Scene scene_of(int picture) const;
  /// When a picture is shown, in milliseconds from the beginning; of `pictures`: the end.
  std::int64_t begins_ms(int picture) const;
};

/// What is wanted of a scene of an open dataset, or why it cannot be a film. scene: as the engine is told it.
std::optional<v1::Error> plan_film(const v1::NewFilm& wanted, const Scene& scene, const DatasetFacts& dataset, FilmPlan& plan);

/// The camera, turned about what it looks at and its up direction as the right hand does.
Camera turned(const Camera& camera, double degrees);

}  // namespace isostrata
