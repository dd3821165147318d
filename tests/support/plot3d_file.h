// PLOT3D files for tests, in every dialect: P. Walatka, P. Buning, L. Pierce, P. Elson, "PLOT3D User's Manual", NASA TM 101067, 1990.
#pragma once

#include <array>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <functional>
#include <string>
#include <vector>

#include "base/vec.h"

namespace isostrata::testing {

/// Appends a value's bytes, last byte first if `reversed`.
template <class T>
void put(std::string& to, T value, bool reversed = false) {
  std::string bytes(sizeof value, '\0');
  std::memcpy(bytes.data(), &value, sizeof value);
  to += reversed ? std::string(bytes.rbegin(), bytes.rend()) : bytes;
}

struct Plot3dDialect {
  bool text = false, big = false, doubles = false, multi = false, blanking = false;
  int marker = 0;      // bytes of Fortran's record marks: 0, 4 or 8
  int dimensions = 3;  // or 2: then blocks are one point thick

  std::string name() const {
    return std::string(text ? "text" : big ? "big" : "little") + (doubles ? "_f64" : "_f32") + (multi ? "_multi" : "_single") +
           (blanking ? "_iblank" : "") + (marker ? "_records" + std::to_string(marker) : "") + (dimensions == 2 ? "_2d" : "");
  }
};

struct Plot3dPart {
  std::array<int, 3> dims{1, 1, 1};
  std::vector<Vec3d> points;                   // [dims[2]][dims[1]][dims[0]]
  std::vector<int> blanking;                   // [points], if the dialect has it
  std::vector<std::vector<double>> variables;  // [variables][points]
};

/// A block over points(i, j, k), with these variables at each point.
inline Plot3dPart plot3d_part(std::array<int, 3> dims, const std::function<Vec3d(int, int, int)>& position,
                              const std::vector<std::function<double(const Vec3d&)>>& fields) {
  Plot3dPart part{dims, {}, {}, std::vector<std::vector<double>>(fields.size())};
  for (int k = 0; k < dims[2]; ++k)
    for (int j = 0; j < dims[1]; ++j)
      for (int i = 0; i < dims[0]; ++i) {
        part.points.push_back(position(i, j, k));
        for (std::size_t v = 0; v < fields.size(); ++v) part.variables[v].push_back(fields[v](part.points.back()));
      }
  return part;
}

/// Writes as Fortran would.
class Plot3dWriter {
 public:
  explicit Plot3dWriter(const Plot3dDialect& dialect) : dialect_(dialect) {}
  void integer(int value) {
    if (dialect_.text)
      record_ += " " + std::to_string(value);
    else
      put(record_, static_cast<std::int32_t>(value), dialect_.big);
  }
  void real(double value) {
    if (dialect_.text) {
      char word[40];
      std::snprintf(word, sizeof word, " %.17g", value);
      record_ += word;
    } else if (dialect_.doubles) {
      put(record_, value, dialect_.big);
    } else {
      put(record_, static_cast<float>(value), dialect_.big);
    }
  }
  void end_record() {
    const auto mark = [&] {
      if (dialect_.text) return;
      if (dialect_.marker == 4) put(bytes, static_cast<std::uint32_t>(record_.size()), dialect_.big);
      if (dialect_.marker == 8) put(bytes, static_cast<std::uint64_t>(record_.size()), dialect_.big);
    };
    mark();
    bytes += record_;
    mark();
    if (dialect_.text) bytes += "\n";
    record_.clear();
  }
  /// The count of blocks, if the dialect has it, and the size of each; `after_each` and `after_all` stand where their files have more.
  void header(const std::vector<Plot3dPart>& parts, const std::vector<int>& after_each = {}, const std::vector<int>& after_all = {}) {
    if (dialect_.multi) {
      integer(static_cast<int>(parts.size()));
      end_record();
    }
    for (const Plot3dPart& part : parts) {
      for (int a = 0; a < dialect_.dimensions; ++a) integer(part.dims[static_cast<std::size_t>(a)]);
      for (const int n : after_each) integer(n);
    }
    for (const int n : after_all) integer(n);
    end_record();
  }
  void variables(const Plot3dPart& part) {
    for (const auto& variable : part.variables)
      for (const double value : variable) real(value);
    end_record();
  }
  std::string bytes;

 private:
  Plot3dDialect dialect_;
  std::string record_;
};

inline std::string plot3d_grid(const Plot3dDialect& dialect, const std::vector<Plot3dPart>& parts) {
  Plot3dWriter writer(dialect);
  writer.header(parts);
  for (const Plot3dPart& part : parts) {
    for (int axis = 0; axis < dialect.dimensions; ++axis)
      for (const Vec3d& p : part.points) writer.real(p[axis]);
    if (dialect.blanking)
      for (const int blank : part.blanking) writer.integer(blank);
    writer.end_record();
  }
  return writer.bytes;
}

/// The file of density, momentum and energy: five variables, four in 2-D.
inline std::string plot3d_solution(const Plot3dDialect& dialect, const std::vector<Plot3dPart>& parts) {
  Plot3dWriter writer(dialect);
  writer.header(parts);
  for (const Plot3dPart& part : parts) {
    for (const double constant : {0.8, 1.5, 1e6, 2.25}) writer.real(constant);  // Mach number, angle, Reynolds number, time
    writer.end_record();
    writer.variables(part);
  }
  return writer.bytes;
}

/// OVERFLOW's solution, which has more variables than five and says how many; only in dialects with record marks.
inline std::string plot3d_overflow(const Plot3dDialect& dialect, const std::vector<Plot3dPart>& parts, int species) {
  Plot3dWriter writer(dialect);
  writer.header(parts, {}, {static_cast<int>(parts.front().variables.size()), species});
  for (const Plot3dPart& part : parts) {
    for (int i = 0; i < 16 + species; ++i) writer.real(0.5 * i);  // reference quantities
    writer.end_record();
    writer.variables(part);
  }
  return writer.bytes;
}

/// A function file: any variables.
inline std::string plot3d_functions(const Plot3dDialect& dialect, const std::vector<Plot3dPart>& parts) {
  Plot3dWriter writer(dialect);
  writer.header(parts, {static_cast<int>(parts.front().variables.size())});
  for (const Plot3dPart& part : parts) writer.variables(part);
  return writer.bytes;
}

}  // namespace isostrata::testing
