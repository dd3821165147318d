// Colour maps that follow a value's logarithm.
#pragma once

#include <string>
#include <string_view>

namespace isostrata {

/// The name, for color_map and so for every renderer, of a map in a range over which the value grows `growth`-fold: it follows
/// the value's logarithm through `name`, from place `from` at the range's lower end to place `to` at its upper end. It has as
/// many samples as that bends, and is exact to 1/1000 of the map where the value grows up to a thousandfold. is_color_map says
/// no to it: it is not for people.
std::string log_map(std::string_view name, double from, double to, double growth);

}  // namespace isostrata
