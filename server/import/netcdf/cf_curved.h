// Points whose longitude and latitude are each said by a variable over two axes, and whose depth or height may be by one over three: grids of oceans and regions.
//
// CF conventions, section 5.2 (two-dimensional coordinates) and appendix D (dimensionless vertical coordinates: ocean_sigma_coordinate, ocean_s_coordinate, _g1 and _g2).
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "import/netcdf/cf_axes.h"

namespace isostrata {

/// Variables by their names, as the coordinates of a field.
class CfVariables {
 public:
  virtual ~CfVariables() = default;
  /// Of those that may be coordinates.
  virtual std::vector<std::string> names() const = 0;
  /// Nothing if there is no such variable of numbers.
  virtual std::optional<std::vector<int>> dimensions(const std::string& name) const = 0;
  virtual std::size_t length(int dimension) const = 0;
  virtual CfAxis axis(int dimension) const = 0;
  virtual std::string text(const std::string& name, const char* attribute) const = 0;
  /// As they are meant, NaN for no value. Throws what readers throw.
  virtual std::vector<double> values(const std::string& name, const std::vector<std::size_t>& from, const std::vector<std::size_t>& count) const = 0;
};

/// Where along the axis of time a field is read.
struct CfMoment {
  std::optional<int> dimension;
  std::size_t place = 0;
};

/// Gives the block such points, if the variables have them for the field `name` over these two or three axes of space (x usually last), and says what its axes are; else it changes nothing. Cells at
/// points without a place are hidden.
std::optional<Axes> place_on_curves(Block& block, const CfVariables& variables, const std::string& name, const std::vector<int>& space, const CfMoment& moment, std::vector<std::string>& notes);

}  // namespace isostrata
