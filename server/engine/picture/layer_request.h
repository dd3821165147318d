// What a scene asks of extraction: pure functions of the scene.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "extraction/layers/extract_layers.h"
#include "scene/scene.h"

namespace isostrata {

/// What the scene asks of extraction: its intervals, visible or not, with the terms, the time and the triangulation; the array
/// that colours run over if an interval or a term has a colour map or an opacity that runs, then the array of the textures
/// if a surface has one and it is another; facets if a surface is drawn or all colours are constant (drawing needs them,
/// and extraction finds them for next to nothing). Arrays that the scene leaves open are empty here too. Of a smear: what is
/// asked of its first step or time.
LayerRequest layer_request(const Scene& scene);
/// The same of a scene whose layers are those of `array`, which stands for the arrays that it leaves open.
LayerRequest layer_request(const Scene& scene, const std::string& array);

/// Over which arrays colours and textures run.
struct ArrayNames {
  std::string color_by, texture;
};
/// Of a scene whose layers are those of `array`.
ArrayNames array_names(const Scene& scene, const std::string& array);

/// Whether colours or opacities of any interval or term run with an array.
bool uses_color_values(const Scene& scene);
bool uses_texture(const Scene& scene);

/// Whether any boundary surface of the scene's intervals or terms is drawn.
bool draws_surfaces(const Scene& scene);

/// Whether its surfaces may be lit along the field's gradient, which takes a pass over the mesh: true wherever lit_along_gradient is of what is drawn.
bool lights_along_gradient(const Scene& scene);

/// Whether its interiors are shaded along the field's gradient. Whole values have none.
bool shades_bodies(const Scene& scene);

/// Whether the term brings layers of its own in.
bool brings_in(const SceneTerm& term);

/// What one part of a smear shows: a step, or a time.
struct SmearMoment {
  int step = 0;
  std::optional<double> time;

  bool operator==(const SmearMoment&) const = default;
};
/// Of SceneMode::smear; empty in any other mode.
std::vector<SmearMoment> smear_moments(const Scene& scene);

/// The scene at one time: of a smear its first.
Scene one_moment(const Scene& scene);

/// Whether the extraction made for one scene serves the other: same dataset, axis scale, layer_request and moments of a smear, lit and shaded alike.
bool same_extraction(const Scene& a, const Scene& b);

}  // namespace isostrata
