#include "import/meshes/read_plot3d.h"

#include <algorithm>
#include <cctype>
#include <cstddef>

#include "data/files/recognise.h"
#include "import/meshes/plot3d_layout.h"

namespace isostrata {
namespace {

namespace fs = std::filesystem;

std::string upper_case(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  return text;
}

/// `name` with the last `from` (any case) replaced by `to`, in upper case where `from` stood in upper case; empty if there is
/// none.
std::string replaced(const std::string& name, const std::string& from, std::string to) {
  const auto at = small_letters(name).rfind(from);
  if (at == std::string::npos) return {};
  if (std::isupper(static_cast<unsigned char>(name[at]))) to = upper_case(to);
  return name.substr(0, at) + to + name.substr(at + from.size());
}

/// The first of `names` that is a file beside `file` and not `file` itself.
std::optional<fs::path> beside(const fs::path& file, const std::vector<std::string>& names) {
  for (const std::string& name : names) {
    const fs::path candidate = file.parent_path() / name;
    std::error_code ignored;
    if (!name.empty() && candidate.filename() != file.filename() && fs::is_regular_file(candidate, ignored)) return candidate;
  }
  return std::nullopt;
}

std::string listed(const std::vector<std::string>& names) {
  std::string text;
  for (auto name = names.begin(); name != names.end(); ++name)
    if (!name->empty() && std::find(names.begin(), name, *name) == name) text += (text.empty() ? "" : ", ") + *name;
  return text;
}

struct Files {
  fs::path grid;
  std::optional<fs::path> solution, functions;
};

std::vector<std::string> solution_names(const fs::path& grid) {
  const std::string name = grid.filename().string(), stem = grid.stem().string(), renamed = replaced(stem, "xyz", "q");
  return {replaced(name, "xyz", "q"),
          stem + ".q",
          stem + ".Q",
          replaced(name, "grid", "q"),
          replaced(name, "grid", "solution"),
          renamed.empty() ? renamed : renamed + grid.extension().string()};
}

std::vector<std::string> grid_names(const fs::path& solution) {
  std::string stem = solution.stem().string();
  const std::string extension = solution.extension().string();
  std::vector<std::string> names;
  if (small_letters(solution.extension().string()) != ".q" && small_letters(solution.extension().string()) != ".f" && !stem.empty())
    names.push_back(stem.substr(0, stem.size() - 1) + "xyz" + solution.extension().string());
  for (;;) {  // "multi-bin-oflow.q" belongs to "multi-bin.xyz"
    const bool upper = extension.size() > 1 && std::isupper(static_cast<unsigned char>(extension[1]));
    for (const char* known : {".xyz", ".x", ".g", ".grd", ".p3d"}) names.push_back(stem + (upper ? upper_case(known) : known));
    const auto cut = stem.find_last_of("-_.");
    if (cut == std::string::npos || cut == 0) return names;
    stem.resize(cut);
  }
}

Files find_files(const fs::path& file) {
  const std::string name = file.filename().string(), extension = small_letters(file.extension().string());
  const bool solution = extension == ".q" || (extension != ".f" && small_letters(file.stem().string()).ends_with("q"));
  Files files;
  if (solution || extension == ".f") {
    const auto names = grid_names(file);
    const auto grid = beside(file, names);
    if (!grid) throw Error(ErrorCode::not_found, name + ": no PLOT3D grid file beside it; looked for " + listed(names));
    files.grid = *grid;
    (solution ? files.solution : files.functions) = file;
    return files;
  }
  files.grid = file;
  const auto names = solution_names(file);
  files.solution = beside(file, names);
  files.functions = beside(file, {file.stem().string() + ".f", file.stem().string() + ".F"});
  if (!files.solution && !files.functions)
    throw Error(ErrorCode::not_found,
                name + ": no PLOT3D solution file beside it; looked for " + listed(names) + ", " + file.stem().string() + ".f");
  return files;
}

FileArray reals_array(std::string name, const Plot3dContents& contents, const Plot3dFormat& format, std::size_t at,
                      std::size_t points, int components) {
  const Plot3dReals reals = read_reals(contents, format, at, points, components);
  FileArray array;
  array.name = std::move(name);
  array.components = components;
  array.type = reals.type;
  array.values = reals.bytes;
  array.storage = reals.storage;
  return array;
}

void add_blanking(Block& block, std::vector<std::int32_t> iblank) {
  const auto cells = static_cast<std::size_t>(block.grid.cell_count());
  auto [storage, hidden] = allocate<std::uint8_t>(cells);
  std::array<std::int64_t, kMaxCellVertices> ids{};
  bool any = false;
  for (std::size_t c = 0; c < cells; ++c) {
    const int n = block.grid.cell_points(static_cast<std::int64_t>(c), ids);
    hidden[c] =
        std::any_of(ids.begin(), ids.begin() + n, [&](std::int64_t id) { return iblank[static_cast<std::size_t>(id)] == 0; });
    any = any || hidden[c];
  }
  const auto values = std::make_shared<std::vector<std::int32_t>>(std::move(iblank));
  FileArray array;
  array.name = "IBlank";
  array.type = ScalarType::int32;
  array.values = std::as_bytes(std::span<const std::int32_t>(*values));
  array.storage = values;
  block.arrays.push_back(std::move(array));
  if (!any) return;
  block.grid.hidden_cells = hidden;
  block.grid.storage =
      std::make_shared<std::pair<std::shared_ptr<const void>, std::shared_ptr<const void>>>(block.grid.storage, storage);
}

Block grid_block(const Plot3dContents& contents, const Plot3dGridLayout& layout, const Plot3dBlock& placed) {
  const auto n = static_cast<std::size_t>(placed.points());
  Plot3dReals reals = read_reals(contents, layout.format, placed.coordinates, n, layout.dimensions);
  const bool single = reals.type == ScalarType::float32;
  if (layout.dimensions == 2) {  // z = 0
    const std::size_t scalar = size_of(reals.type);
    auto [storage, bytes] = allocate<std::byte>(3 * scalar * n);
    std::fill(bytes.begin(), bytes.end(), std::byte{0});
    for (std::size_t p = 0; p < n; ++p)
      std::copy_n(reals.bytes.data() + 2 * scalar * p, 2 * scalar, bytes.data() + 3 * scalar * p);
    reals = {reals.type, bytes, storage};
  }
  Block block;
  PointSpan points;
  if (single)
    points = std::span<const Vec3f>(reinterpret_cast<const Vec3f*>(reals.bytes.data()), n);
  else
    points = std::span<const Vec3d>(reinterpret_cast<const Vec3d*>(reals.bytes.data()), n);
  block.grid.shape = CurvilinearGrid{placed.dims, points};
  block.grid.storage = reals.storage;
  if (placed.blanking) add_blanking(block, read_integers(contents, layout.format, *placed.blanking, n));
  return block;
}

void add_solution(Block& block, const Plot3dContents& contents, const Plot3dSolutionLayout& layout, std::size_t at,
                  int dimensions) {
  const auto n = static_cast<std::size_t>(block.grid.point_count());
  const std::size_t stride = n * (contents.text ? 1 : static_cast<std::size_t>(layout.format.real_bytes));
  const auto add = [&](const std::string& name, int first, int components) {
    block.arrays.push_back(
        reals_array(name, contents, layout.format, at + stride * static_cast<std::size_t>(first), n, components));
  };
  add("Density", 0, 1);
  add("Momentum", 1, dimensions);
  add("StagnationEnergy", 1 + dimensions, 1);
  const int standard = dimensions + 2;
  for (int v = standard; v < layout.variables; ++v) {
    const int extra = v - standard;
    if (extra == 0)
      add("Gamma", v, 1);
    else if (extra <= layout.species)
      add("Species Density " + std::to_string(extra), v, 1);
    else
      add("Turb Field Quantity " + std::to_string(extra - layout.species), v, 1);
  }
}

}  // namespace

Imported read_plot3d(const ReadRequest& request) {
  check_step(request, 1);
  const Files files = find_files(request.file);
  const Plot3dContents grid_contents = load_plot3d(files.grid, request.max_bytes);
  const Plot3dGridLayout grid = fit_grid(grid_contents);
  request.progress(0.1);
  Imported imported;
  for (const Plot3dBlock& block : grid.blocks) imported.blocks.push_back(grid_block(grid_contents, grid, block));
  request.progress(0.2);

  if (files.solution) {
    const Plot3dContents contents = load_plot3d(*files.solution, request.max_bytes);
    const Plot3dSolutionLayout layout = fit_solution(contents, grid);
    for (std::size_t b = 0; b < grid.blocks.size(); ++b)
      add_solution(imported.blocks[b], contents, layout, layout.blocks[b], grid.dimensions);
    imported.notes.push_back("PLOT3D: grid " + files.grid.filename().string() + " (" + grid.format.describe(grid_contents.text) +
                             "), solution " + files.solution->filename().string() + " (" + layout.format.describe(contents.text) +
                             ")");
  }
  request.progress(0.4);
  if (files.functions) {
    const Plot3dContents contents = load_plot3d(*files.functions, request.max_bytes);
    const Plot3dSolutionLayout layout = fit_functions(contents, grid);
    for (std::size_t b = 0; b < grid.blocks.size(); ++b) {
      const auto n = static_cast<std::size_t>(grid.blocks[b].points());
      const std::size_t stride = n * (contents.text ? 1 : static_cast<std::size_t>(layout.format.real_bytes));
      for (int f = 0; f < layout.variables; ++f)
        imported.blocks[b].arrays.push_back(reals_array("Function " + std::to_string(f), contents, layout.format,
                                                        layout.blocks[b] + stride * static_cast<std::size_t>(f), n, 1));
    }
    imported.notes.push_back("PLOT3D: functions " + files.functions->filename().string());
  }
  return imported;
}

}  // namespace isostrata
