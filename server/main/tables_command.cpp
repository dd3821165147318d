#include <algorithm>
#include <boost/json.hpp>
#include <cstdio>
#include <memory>
#include <optional>

#include "extraction/files/output_file.h"
#include "main/arguments.h"
#include "main/commands.h"
#include "main/draw_case.h"
#include "tables/interval_table.h"

namespace isostrata {
namespace {

struct TablesArguments {
  std::vector<std::string> cells;
  std::string one_case, out;
  std::optional<std::int64_t> cases;
  std::uint64_t seed = 1;
  bool json = false;
};

/// Cells with more cases than this are sampled where the number of cases is not given; all of it takes a few seconds.
constexpr std::int64_t kMostCases = 60000;
constexpr std::int64_t kUsualSample = 1000;

TableStatistics statistics(const std::string& name, const TablesArguments& arguments) {
  const LatticeCell cell = lattice_cell_named(name);
  const std::int64_t all = case_count(cell.vertex_count());
  const std::int64_t count = arguments.cases.value_or(all <= kMostCases ? all : kUsualSample);
  return count >= all ? table_statistics(cell) : sample_statistics(cell, count, arguments.seed, command_task());
}

boost::json::object to_json(const TableStatistics& row) {
  return {{"cell", row.cell},         {"dimension", row.dimension},
          {"vertices", row.vertices}, {"cases", row.cases},
          {"counted", row.counted},   {"total_simplices", row.total_simplices},
          {"average", row.average},   {"max", row.max}};
}

void print_text(const std::vector<TableStatistics>& rows) {
  std::printf("%-16s %9s %8s %16s %8s %15s %8s %4s\n", "cell", "dimension", "vertices", "cases", "counted", "total simplices",
              "average", "max");
  for (const TableStatistics& row : rows)
    std::printf("%-16s %9d %8d %16lld %8lld %15lld %8.3f %4lld\n", row.cell.c_str(), row.dimension, row.vertices,
                static_cast<long long>(row.cases), static_cast<long long>(row.counted),
                static_cast<long long>(row.total_simplices), row.average, static_cast<long long>(row.max));
}

/// One case of one cell: drawn into --out, else told in words.
void show_case(const TablesArguments& arguments) {
  if (arguments.cells.size() != 1) throw CLI::ValidationError("--case", "expected just one --cell with it");
  const LatticeCell cell = lattice_cell_named(arguments.cells.front());
  const std::int64_t index = parse_case(cell, arguments.one_case);
  if (!arguments.out.empty()) {
    OutputFile file(arguments.out);
    file.text(draw_case(cell, index));
    file.finish();
    return;
  }
  const std::string simplices = describe_case(cell, index);
  std::printf("%s, case %lld: %lld simplices\n%s", cell.name.c_str(), static_cast<long long>(index),
              static_cast<long long>(std::count(simplices.begin(), simplices.end(), '\n')), simplices.c_str());
}

void run(const TablesArguments& arguments) {
  if (!arguments.one_case.empty()) return show_case(arguments);
  std::vector<TableStatistics> rows;
  if (arguments.cells.empty()) rows = all_table_statistics();
  for (const std::string& name : arguments.cells) rows.push_back(statistics(name, arguments));
  if (!arguments.json) return print_text(rows);
  boost::json::array tables;
  for (const TableStatistics& row : rows) tables.push_back(to_json(row));
  print_json(boost::json::object{{"tables", tables}});
}

}  // namespace

void add_tables_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand("tables", "Generates the interval tables and prints their statistics");
  auto arguments = std::make_shared<TablesArguments>();
  command
      ->add_option("--cell", arguments->cells,
                   "Only this cell; may be repeated: tetrahedron, pyramid, wedge, hexahedron, triangle, quadrilateral, simplex3 to simplex5, cube3 to "
                   "cube5, prism3 to prism5 (over the triangle, the tetrahedron, the 4-simplex)")
      ->allow_extra_args(false);
  command
      ->add_option_function<std::int64_t>(
          "--cases", [arguments](const std::int64_t& cases) { arguments->cases = cases; },
          "This many cases of each --cell, drawn at random (default: all, or 1000 of those with more than 60000)")
      ->check(CLI::Range(std::int64_t{1}, std::int64_t{1000000000}))
      ->needs("--cell");
  command->add_option("--seed", arguments->seed, "The seed of the random numbers")->capture_default_str();
  CLI::Option* one_case = command
                              ->add_option("--case", arguments->one_case,
                                           "One case of one --cell: a digit 0, 1 or 2 for each vertex (below the interval, inside, "
                                           "above), or its number")
                              ->needs("--cell");
  command->add_option("--out", arguments->out, "Draw that case into an .svg file (default: print its simplices)")
      ->needs(one_case)
      ->check([](const std::string& path) {
        return path.ends_with(".svg") ? std::string() : "expected a file that ends in .svg, not '" + path + "'";
      });
  command->add_flag("--json", arguments->json, "Print one JSON document");
  command->callback([arguments] { run(*arguments); });
}

}  // namespace isostrata
