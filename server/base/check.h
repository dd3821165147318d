// What must hold between our own rooms. ISOSTRATA_CHECK(a == b) throws internal with the place, the words and both values if it does not:
//
//   check_draw_input.cpp:55: expected input.mesh->tetrahedron_interval.size() == input.mesh->tetrahedra.size(), but 11 and 12
//
// The frame or the command fails with these words, and the program goes on. For comparisons that cost nothing beside the work that they guard; what comes
// from outside is checked where it comes in, with words for the person who sent it. Any thread. The operands are values once: no side effects.
#pragma once

#include <sstream>
#include <string_view>

#include "base/error.h"

namespace isostrata {

/// What the macro is made of: `Comparison{place, words} << a == b` is (Comparison << a) == b.
class Comparison {
 public:
  Comparison(const char* file, int line, const char* words) : file_(file), line_(line), words_(words) {}

  template <class A>
  struct Left {
    const Comparison& of;
    const A& a;

    template <class B>
    void operator==(const B& b) const {
      if (!(a == b)) of.fail(a, b);
    }
    template <class B>
    void operator<=(const B& b) const {
      if (!(a <= b)) of.fail(a, b);
    }
    template <class B>
    void operator<(const B& b) const {
      if (!(a < b)) of.fail(a, b);
    }
  };

  template <class A>
  Left<A> operator<<(const A& a) const {
    return {*this, a};
  }

 private:
  template <class A, class B>
  [[noreturn]] void fail(const A& a, const B& b) const {
    const std::string_view path = file_;
    std::ostringstream text;
    text << path.substr(path.rfind('/') + 1) << ':' << line_ << ": expected " << words_ << ", but " << a << " and " << b;
    throw Error(ErrorCode::internal, text.str());
  }

  const char* const file_;
  const int line_;
  const char* const words_;
};

}  // namespace isostrata

/// Of two values that a stream can print, with ==, < or <= between them.
#define ISOSTRATA_CHECK(comparison) (::isostrata::Comparison(__FILE__, __LINE__, #comparison) << comparison)
