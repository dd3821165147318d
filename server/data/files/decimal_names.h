// Decimal numbers in the names of a series, "U_0.05.vtk", beside dots that only keep two numbers apart: "re100.0001.vtk", "part_1.0001.vtk".
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "data/files/file_series.h"

namespace isostrata {

/// A number as it stands in a name.
struct WrittenNumber {
  std::string whole, fraction;  // digits, also with a minus in front and an exponent behind; a whole number has no fraction
  bool behind_letter = false;   // "re100.5", not "re_100.5"
  double value() const;
};

WrittenNumber written_number(const std::string& text, bool behind_letter);
bool has_sign_or_exponent(const WrittenNumber& number);

/// Whether the numbers at one place of some names, of which some have a dot, are decimals rather than two counters. They are if a program would have written them so, by %g or
/// with a fixed number of places ("1.10" beside "1.1" is neither), unless the dot keeps series apart: each whole part has the same few fractions, or fractions that count in equal steps
/// where the decimals are not evenly spaced (1.5, 1.15, 1.25), or there is but one whole part that is not 0.
/// Of numbers of which one has a sign or an exponent all are.
bool are_decimals(const std::vector<WrittenNumber>& numbers);

/// The text at the only star of a pattern, or at its only "*.*", in the name of each of its files; empty if the pattern has others.
std::vector<WrittenNumber> numbers_at_star(std::string_view pattern, const std::vector<SeriesFile>& files);

/// The values of decimals at the only star or "*.*", of each file in its name; empty if there are none.
std::vector<double> decimals_in_names(std::string_view pattern, const std::vector<SeriesFile>& files);

/// Where the last star of a pattern, "*" or "*.*", may stand for one decimal number: a dot before it or a number behind it speak against it. npos else.
std::size_t decimal_star(std::string_view pattern);

/// Whether a name has a number with a minus or an exponent at the only star of a pattern: "phi_-0.5.vtu", "t_1e-3.vtu".
bool is_signed_at_star(std::string_view name, std::string_view pattern);

/// The pattern with "*.*" for its only star, if that may stand for one decimal; else nothing.
std::string with_dot(const std::string& pattern);

/// By the values of decimals_in_names, if there are any; as they are else.
void sort_decimals(const std::string& pattern, std::vector<SeriesFile>& files);

}  // namespace isostrata
