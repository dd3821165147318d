#include "main/render_pictures.h"

#include <algorithm>
#include <cstddef>

#include "base/error.h"
#include "encoding/encode_image.h"
#include "encoding/image_file.h"
#include "engine/picture/scene_styles.h"
#include "main/mode_arguments.h"

namespace isostrata {
namespace {

bool is_film(const RenderArguments& arguments) { return !arguments.modes.steps.empty() && arguments.modes.mode != "smear"; }

bool is_webm(const RenderArguments& arguments) { return arguments.out.ends_with(".webm"); }

}  // namespace

std::vector<RenderPicture> pictures_of(const RenderArguments& arguments, const Scene& wanted) {
  const auto path = [&](std::size_t number) { return is_numbered(arguments.out) ? numbered_path(arguments.out, number) : arguments.out; };
  if (is_film(arguments)) {
    std::vector<RenderPicture> film;
    for (const int step : parse_steps(arguments.modes.steps)) film.push_back({wanted.cycle.phase, step, path(static_cast<std::size_t>(step))});
    return film;
  }
  // A state has a phase: it is one picture.
  if (wanted.mode != SceneMode::cycled || arguments.modes.phase || !arguments.state.empty()) return {{wanted.cycle.phase, wanted.step, arguments.out}};
  std::vector<RenderPicture> pictures;
  for (std::size_t i = 0; i < std::max<std::size_t>(cycle_length(wanted), 1); ++i)
    pictures.push_back({static_cast<double>(i), wanted.step, path(i)});
  return pictures;
}

bool in_one_file(const std::vector<RenderPicture>& pictures, const RenderArguments& arguments) {
  return is_webm(arguments) || (pictures.size() > 1 && pictures.front().out == arguments.out);
}

void check_out(const RenderArguments& arguments, int width, int height) {
  if (!is_webm(arguments)) check_image_path(arguments.out);
  const bool film = is_film(arguments), cycle = arguments.modes.mode == "cycled" && !arguments.modes.phase && arguments.state.empty();
  if (is_webm(arguments)) {
    if (!film && !cycle) throw Error(ErrorCode::invalid_argument, arguments.out + ": a film is of several pictures; expected --steps or --mode cycled");
    if (is_numbered(arguments.out)) throw Error(ErrorCode::invalid_argument, arguments.out + ": one film holds all pictures; expected a name without %");
    if (arguments.background == "transparent") throw Error(ErrorCode::invalid_argument, arguments.out + ": a film is not transparent; expected a colour for --background");
  } else if (film || cycle) {
    if (is_numbered(arguments.out)) numbered_path(arguments.out, 0);
    else if (!arguments.out.ends_with(".png"))
      throw Error(ErrorCode::invalid_argument, arguments.out + (film ? ": --steps are several pictures, and only .png and .webm hold them in one file; expected one of these, or %04d in the name"
                                                                     : ": a cycle is several pictures, and only .png and .webm hold them in one file; expected one of these, %02d in the name, or --phase"));
  }
  if (film && arguments.layers.time) throw Error(ErrorCode::invalid_argument, "--steps and --time: expected one of them");
  if (!is_webm(arguments)) check_image_file(arguments.out, width, height, arguments.background == "transparent");
}

}  // namespace isostrata
