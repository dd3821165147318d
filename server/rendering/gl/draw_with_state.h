// Drawing with a state that lives in an OpenGL context, and what a failure leaves behind.
#pragma once

#include <memory>
#include <new>
#include <string>

#include "base/error.h"
#include "rendering/gl/gl_context.h"
#include "rendering/picture/check_draw_input.h"

namespace isostrata {

/// Whether the state can draw again: its meshes and pictures are gone, and no error of theirs is left for the next one to be blamed for.
template <class State>
bool give_back(State& state) {
  state.give_back();
  for (int i = 0; i < 8; ++i)  // a context has a few flags; one that is lost says so again and again
    if (state.context().gl().GetError() == GL_NO_ERROR) return true;
  return false;
}

/// Draws input by state->draw, after checking it; `open` makes the state if there is none. What is too large for the device leaves the context and
/// its programs, and nothing else (state->give_back). After any other failure, whatever state the context is in, the next draw starts from a fresh
/// one. Throws as Renderer::draw does.
template <class State, class Open>
DrawResult draw_with_state(std::unique_ptr<State>& state, const Open& open, const DrawInput& input) {
  check(input);
  if (!input.cut_intervals.empty())
    throw Error(ErrorCode::unavailable, "picture: intervals that the renderer cuts are drawn by the native renderer only");
  try {
    if (!state) state = open();
    return state->draw(input);
  } catch (const Error& error) {
    if (error.code() != ErrorCode::too_large || !state || !give_back(*state)) state.reset();
    throw;
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
