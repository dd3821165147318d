// Drawing with a state that lives in an OpenGL context, and what a failure leaves behind.
#pragma once

#include <memory>
#include <new>
#include <string>

#include "base/error.h"
#include "rendering/picture/check_draw_input.h"

namespace isostrata {

/// Draws input by state->draw, after checking it; `open` makes the state where there is none. Whatever state the context is in
/// after a failure, the next draw starts from a fresh one. Throws as Renderer::draw does.
template <class State, class Open>
DrawResult draw_with_state(std::unique_ptr<State>& state, const Open& open, const DrawInput& input) {
  check(input);
  if (!input.cut_intervals.empty())
    throw Error(ErrorCode::unavailable, "picture: intervals that the renderer cuts are drawn by the native renderer only");
  try {
    if (!state) state = open();
    return state->draw(input);
  } catch (const std::bad_alloc&) {
    state.reset();
    throw Error(ErrorCode::too_large,
                "picture of " + std::to_string(input.width) + "x" + std::to_string(input.height) + ": out of memory");
  } catch (...) {
    state.reset();
    throw;
  }
}

}  // namespace isostrata
