#include "import/meshes/plot3d_layout.h"

#include <limits>

namespace isostrata {
namespace {

constexpr std::int64_t kMostBlocks = 65536;
constexpr std::int64_t kMostPoints = std::int64_t{1} << 40;

std::vector<Plot3dFormat> formats(const Plot3dContents& contents) {
  if (contents.text) return {{false, 0, 8}};
  std::vector<Plot3dFormat> all;
  for (const int marker : {0, 4, 8})
    for (const bool big : {false, true})
      for (const int real : {4, 8}) all.push_back({big, marker, real});
  return all;
}

/// The header: how many blocks, and `per_block` integers of each. What comes after must be checked against the file's length.
std::optional<std::vector<std::vector<std::int64_t>>> read_header(Plot3dCursor& cursor, bool multi, int per_block,
                                                                  int extra = 0) {
  std::int64_t blocks = 1;
  if (multi) {
    if (!cursor.open_record(4)) return std::nullopt;
    const auto count = cursor.integer();
    if (!count || *count < 1 || *count > kMostBlocks || !cursor.close_record()) return std::nullopt;
    blocks = *count;
  }
  if (!cursor.open_record(static_cast<std::size_t>(blocks * per_block + extra) * 4)) return std::nullopt;
  std::vector<std::vector<std::int64_t>> header;
  for (std::int64_t b = 0; b < blocks + (extra ? 1 : 0); ++b) {
    auto& numbers = header.emplace_back();
    const int count = b < blocks ? per_block : extra;
    for (int i = 0; i < count; ++i) {
      const auto value = cursor.integer();
      if (!value) return std::nullopt;
      numbers.push_back(*value);
    }
  }
  if (!cursor.close_record()) return std::nullopt;
  return header;
}

std::optional<std::array<std::int64_t, 3>> sane_dims(const std::vector<std::int64_t>& numbers, int dimensions) {
  std::array<std::int64_t, 3> dims{1, 1, 1};
  std::int64_t points = 1;
  for (int a = 0; a < dimensions; ++a) {
    const std::int64_t n = numbers[static_cast<std::size_t>(a)];
    if (n < 1 || n > kMostPoints / points) return std::nullopt;
    points *= n;
    dims[static_cast<std::size_t>(a)] = n;
  }
  return dims;
}

/// The best failure so far, to explain a file that fits nothing.
struct Near {
  std::size_t missing = std::numeric_limits<std::size_t>::max();
  std::string what;

  void consider(const Plot3dCursor& cursor, const std::string& declared) {
    if (cursor.missing() == 0 || cursor.missing() >= missing) return;
    missing = cursor.missing();
    what = declared;
  }
};

std::string size_text(const Plot3dContents& contents) {
  return contents.text ? std::to_string(contents.numbers.size()) + " numbers" : std::to_string(contents.bytes.size()) + " bytes";
}

std::string dims_text(const std::array<std::int64_t, 3>& d) {
  return std::to_string(d[0]) + "x" + std::to_string(d[1]) + "x" + std::to_string(d[2]);
}

std::optional<Plot3dGridLayout> try_grid(const Plot3dContents& contents, const Plot3dFormat& format, bool multi, int dimensions,
                                         bool blanked, bool padding, Near& near) {
  Plot3dCursor cursor(contents, format);
  const auto header = read_header(cursor, multi, dimensions);
  if (!header) return std::nullopt;
  Plot3dGridLayout layout{format, dimensions, {}};
  for (const auto& numbers : *header) {
    const auto dims = sane_dims(numbers, dimensions);
    if (!dims) return std::nullopt;
    layout.blocks.push_back({*dims, 0, std::nullopt});
  }
  const auto real = static_cast<std::size_t>(format.real_bytes);
  for (Plot3dBlock& block : layout.blocks) {
    const auto points = static_cast<std::size_t>(block.points()), reals = points * static_cast<std::size_t>(dimensions);
    if (!cursor.open_record(reals * real + (blanked ? points * 4 : 0))) return std::nullopt;
    const auto coordinates = cursor.skip(reals, real);
    const auto blanking = coordinates && blanked ? cursor.skip(points, 4) : std::nullopt;
    if (!coordinates || (blanked && !blanking)) {
      near.consider(cursor, std::to_string(layout.blocks.size()) +
                                (layout.blocks.size() == 1 ? " block of " : " blocks, one of ") + dims_text(block.dims) +
                                " points declared (" + format.describe(contents.text) + ")");
      return std::nullopt;
    }
    if (!cursor.close_record()) return std::nullopt;
    block.coordinates = *coordinates;
    block.blanking = blanking;
  }
  if (!cursor.at_end(padding)) return std::nullopt;
  return layout;
}

bool same_dims(const Plot3dGridLayout& grid, const std::vector<std::vector<std::int64_t>>& header) {
  for (std::size_t b = 0; b < grid.blocks.size(); ++b)
    for (std::size_t a = 0; a < static_cast<std::size_t>(grid.dimensions); ++a)
      if (header[b][a] != grid.blocks[b].dims[a]) return false;
  return true;
}

std::optional<Plot3dSolutionLayout> try_solution(const Plot3dContents& contents, const Plot3dGridLayout& grid,
                                                 const Plot3dFormat& format, bool multi, bool overflow, bool padding,
                                                 Near& near) {
  Plot3dCursor cursor(contents, format);
  const auto header = read_header(cursor, multi, grid.dimensions, overflow ? 2 : 0);
  if (!header || header->size() != grid.blocks.size() + (overflow ? 1 : 0)) return std::nullopt;
  if (!same_dims(grid, *header)) return std::nullopt;
  Plot3dSolutionLayout layout{format, grid.dimensions + 2, 0, {}};
  if (overflow) {
    const std::int64_t variables = header->back()[0], species = header->back()[1];
    if (variables < layout.variables || variables > 1000 || species < 0 || species > variables - layout.variables)
      return std::nullopt;
    layout.variables = static_cast<int>(variables);
    layout.species = static_cast<int>(species);
  }
  const auto real = static_cast<std::size_t>(format.real_bytes);
  for (const Plot3dBlock& block : grid.blocks) {
    if (overflow) {  // reference quantities, as many as that version of OVERFLOW writes
      const auto length = cursor.open_any_record();
      if (!length || !cursor.skip(*length, 1) || !cursor.close_record()) return std::nullopt;
    } else {  // Mach number, angle of attack, Reynolds number, time
      if (!cursor.open_record(4 * real) || !cursor.skip(4, real) || !cursor.close_record()) return std::nullopt;
    }
    const std::size_t reals = static_cast<std::size_t>(block.points()) * static_cast<std::size_t>(layout.variables);
    if (!cursor.open_record(reals * real)) return std::nullopt;
    const auto values = cursor.skip(reals, real);
    if (!values) {
      near.consider(cursor, dims_text(block.dims) + " points with " + std::to_string(layout.variables) +
                                " values each declared (" + format.describe(contents.text) + ")");
      return std::nullopt;
    }
    if (!cursor.close_record()) return std::nullopt;
    layout.blocks.push_back(*values);
  }
  if (!cursor.at_end(padding)) return std::nullopt;
  return layout;
}

std::optional<Plot3dSolutionLayout> try_functions(const Plot3dContents& contents, const Plot3dGridLayout& grid,
                                                  const Plot3dFormat& format, bool multi, bool padding, Near& near) {
  Plot3dCursor cursor(contents, format);
  const auto header = read_header(cursor, multi, grid.dimensions + 1);
  if (!header || header->size() != grid.blocks.size() || !same_dims(grid, *header)) return std::nullopt;
  const std::int64_t functions = header->front().back();
  Plot3dSolutionLayout layout{format, static_cast<int>(functions), 0, {}};
  const auto real = static_cast<std::size_t>(format.real_bytes);
  for (std::size_t b = 0; b < grid.blocks.size(); ++b) {
    if (functions < 1 || functions > 1000 || (*header)[b].back() != functions) return std::nullopt;
    const std::size_t reals = static_cast<std::size_t>(grid.blocks[b].points() * functions);
    if (!cursor.open_record(reals * real)) return std::nullopt;
    const auto values = cursor.skip(reals, real);
    if (!values) {
      near.consider(cursor, std::to_string(functions) + " functions declared (" + format.describe(contents.text) + ")");
      return std::nullopt;
    }
    if (!cursor.close_record()) return std::nullopt;
    layout.blocks.push_back(*values);
  }
  if (!cursor.at_end(padding)) return std::nullopt;
  return layout;
}

[[noreturn]] void refuse(const Plot3dContents& contents, const Near& near, const std::string& otherwise) {
  if (!near.what.empty())
    throw Error(ErrorCode::bad_data, contents.name + ": " + near.what + "; " + size_text(contents) + " present, " +
                                         std::to_string(near.missing) + " too few");
  throw Error(ErrorCode::bad_data,
              contents.name + ": " + size_text(contents) + " that fit no PLOT3D dialect; expected " + otherwise);
}

}  // namespace

Plot3dGridLayout fit_grid(const Plot3dContents& contents) {
  Near near;
  for (const bool padding : {false, true})
    for (const int dimensions : {3, 2})
      for (const bool multi : {false, true})
        for (const bool blanked : {false, true})
          for (const Plot3dFormat& format : formats(contents))
            if (auto layout = try_grid(contents, format, multi, dimensions, blanked, padding, near)) return *layout;
  refuse(contents, near, "a grid: sizes, then coordinates");
}

Plot3dSolutionLayout fit_solution(const Plot3dContents& contents, const Plot3dGridLayout& grid) {
  Near near;
  for (const bool padding : {false, true})
    for (const bool overflow : {false, true})
      for (const bool multi : {false, true})
        for (const Plot3dFormat& format : formats(contents))
          if (auto layout = try_solution(contents, grid, format, multi, overflow, padding, near)) return *layout;
  refuse(contents, near,
         "a solution for " + std::to_string(grid.blocks.size()) + " block(s), the first of " +
             dims_text(grid.blocks.front().dims) + " points, as its grid file has");
}

Plot3dSolutionLayout fit_functions(const Plot3dContents& contents, const Plot3dGridLayout& grid) {
  Near near;
  for (const bool padding : {false, true})
    for (const bool multi : {false, true})
      for (const Plot3dFormat& format : formats(contents))
        if (auto layout = try_functions(contents, grid, format, multi, padding, near)) return *layout;
  refuse(contents, near,
         "a function file for " + std::to_string(grid.blocks.size()) + " block(s), the first of " +
             dims_text(grid.blocks.front().dims) + " points, as its grid file has");
}

}  // namespace isostrata
