#include <boost/json.hpp>
#include <cstdio>
#include <memory>

#include "main/arguments.h"
#include "main/commands.h"
#include "tables/interval_table.h"

namespace isostrata {
namespace {

boost::json::object to_json(const TableStatistics& row) {
  return {{"cell", row.cell},           {"dimension", row.dimension},
          {"vertices", row.vertices},   {"cases", row.cases},
          {"total_simplices", row.total_simplices}, {"average", row.average},
          {"max", row.max}};
}

void print_text(const std::vector<TableStatistics>& rows) {
  std::printf("%-12s %9s %8s %6s %15s %8s %4s\n", "cell", "dimension", "vertices", "cases", "total simplices", "average", "max");
  for (const TableStatistics& row : rows)
    std::printf("%-12s %9d %8d %6lld %15lld %8.3f %4lld\n", row.cell.c_str(), row.dimension, row.vertices,
                static_cast<long long>(row.cases), static_cast<long long>(row.total_simplices), row.average,
                static_cast<long long>(row.max));
}

}  // namespace

void add_tables_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand("tables", "Generates the interval tables and prints their statistics");
  auto json = std::make_shared<bool>(false);
  command->add_flag("--json", *json, "Print one JSON document");
  command->callback([json] {
    const std::vector<TableStatistics> rows = all_table_statistics();
    if (!*json) return print_text(rows);
    boost::json::array tables;
    for (const TableStatistics& row : rows) tables.push_back(to_json(row));
    print_json(boost::json::object{{"tables", tables}});
  });
}

}  // namespace isostrata
