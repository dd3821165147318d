// What somebody meant who mistyped a name.
#pragma once

#include <span>
#include <string>
#include <string_view>

namespace isostrata {

/// " Did you mean 'NAME'?" with the name that takes the fewest edits (a letter more, less, another, two exchanged; upper and lower case are alike), the
/// first of several; empty if that is more than a third of the letters.
std::string did_you_mean(std::string_view typed, std::span<const std::string> names);

}  // namespace isostrata
