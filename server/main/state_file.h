// A session's state, as GET api/v1/sessions/ID/state gives it and the page saves it, as the scene of a picture.
#pragma once

#include <string>

#include "data/dataset/dataset.h"
#include "scene/scene.h"

namespace isostrata {

/// What the page shows with that state; `dataset` stands for the one that the state names, whatever its name is. Throws
/// not_found, bad_data (not a state), and what a server refuses of it, each with the file's name.
Scene read_state_file(const std::string& path, const Dataset& dataset, double aspect);

}  // namespace isostrata
