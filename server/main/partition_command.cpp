#include <boost/json.hpp>
#include <cctype>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "base/parallel.h"
#include "base/stopwatch.h"
#include "data/parts/partition.h"
#include "data/values/source_mapping.h"
#include "extraction/files/output_file.h"
#include "extraction/files/write_part.h"
#include "extraction/layers/owned_cells.h"
#include "main/arguments.h"
#include "main/commands.h"
#include "main/sandbox_option.h"

namespace isostrata {
namespace {

namespace fs = std::filesystem;

struct PartitionArguments {
  std::string file, out;
  int parts = 0, step = 0, threads = 0;
  bool json = false;
};

/// The folder that the parts are put into. What was written goes again unless all of it was.
class PartFolder {
 public:
  explicit PartFolder(const std::string& path) : path_(path) {
    std::error_code error;
    made_ = fs::create_directory(path_, error);
    if (error || !fs::is_directory(path_, error))
      throw Error(ErrorCode::unavailable, path + ": cannot be made: " + (error ? error.message() : "a file has that name") + "; expected a folder that is empty or not there yet, in one that can be written to");
    const bool empty = fs::is_empty(path_, error);
    if (error) throw Error(ErrorCode::unavailable, path + ": cannot be read: " + error.message());
    if (!empty) throw Error(ErrorCode::invalid_argument, path + ": is not empty; expected an empty folder, or one that is not there yet");
  }
  ~PartFolder() {
    std::error_code ignored;
    for (const fs::path& file : written_) fs::remove(file, ignored);
    if (made_ && !done_) fs::remove(path_, ignored);
  }
  PartFolder(const PartFolder&) = delete;
  PartFolder& operator=(const PartFolder&) = delete;

  fs::path file(const std::string& name) { return written_.emplace_back(path_ / name); }
  void keep() { written_.clear(), done_ = true; }

 private:
  const fs::path path_;
  std::vector<fs::path> written_;
  bool made_ = false, done_ = false;
};

/// "fire_ug" of "data/fire_ug.vtu", "torus-64" of "torus:64": letters that are safe in names, and never empty.
std::string stem_of(const std::string& file) {
  std::string name = fs::path(file).lexically_normal().filename().stem().string();
  for (char& c : name)
    if (!std::isalnum(static_cast<unsigned char>(c)) && c != '-' && c != '_' && c != '.') c = '-';
  name.erase(0, name.find_first_not_of('.'));
  return name.empty() ? "parts" : name;
}

void check_parts(const Dataset& whole, int parts) {
  if (whole.grid.cell_count() == 0) throw Error(ErrorCode::unsupported, whole.name + ": it has no cells, so there is nothing to part");
  if (whole.grid.flat()) throw Error(ErrorCode::unsupported, whole.name + ": a flat grid is not parted; expected cells that have a volume");
  if (parts > whole.grid.cell_count())
    throw Error(ErrorCode::invalid_argument, "--parts " + std::to_string(parts) + ": more than the " + std::to_string(whole.grid.cell_count()) + " cells of " + whole.name);
}

boost::json::object to_json(const DatasetParts& made, const std::string& list, double load_ms, double write_ms) {
  boost::json::array parts;
  for (const DatasetParts::Part& of : made.parts)
    parts.push_back(boost::json::object{{"file", of.file}, {"points", of.points}, {"cells", of.cells}, {"own_cells", of.own_cells}});
  return {{"list", list}, {"manifest", manifest_of(list).string()}, {"grid", made.grid}, {"points", made.points}, {"cells", made.cells}, {"parts", std::move(parts)},
          {"ms", boost::json::object{{"load", load_ms}, {"write", write_ms}}}};
}

void print_text(const DatasetParts& made, const std::string& list, double load_ms, double write_ms) {
  std::printf("%s: %lld cells in %zu parts\n%24s %12s %12s %12s\n", list.c_str(), static_cast<long long>(made.cells), made.parts.size(), "part", "own cells", "all cells", "points");
  for (const DatasetParts::Part& of : made.parts)
    std::printf("%24s %12lld %12lld %12lld\n", of.file.c_str(), static_cast<long long>(of.own_cells), static_cast<long long>(of.cells), static_cast<long long>(of.points));
  std::printf("load %.1f ms, write %.1f ms on %d threads\n", load_ms, write_ms, thread_count());
}

void run(const PartitionArguments& arguments) {
  if (arguments.threads > 0) set_thread_count(arguments.threads);
  Stopwatch stage;
  Task& task = command_task();
  const auto whole = open_argument(arguments.file, arguments.step);
  check_parts(*whole, arguments.parts);
  const double load_ms = stage.lap_ms();
  PartFolder folder(arguments.out);
  const std::string stem = stem_of(arguments.file);
  const PartEndings endings = part_endings(whole->grid);
  const RegionTree regions = make_regions(whole->grid, arguments.parts);
  DatasetParts made = partition_of(*whole, regions);
  std::vector<WrittenPart> written;
  for (int region = 0; region < arguments.parts; ++region) {
    task.check();
    task.report(static_cast<double>(region) / arguments.parts, "writing");
    PartOrigin origin;
    const auto part = take_region(*whole, regions, region, {}, &origin);
    const OwnsCell owns = owner_of(part->grid, regions, region);
    std::vector<std::uint8_t> owned(static_cast<std::size_t>(part->grid.cell_count()));
    std::int64_t own_cells = 0;
    for (std::size_t c = 0; c < owned.size(); ++c) own_cells += owned[c] = owns(static_cast<std::int64_t>(c));
    written.push_back(write_part(folder.file(stem + "_" + std::to_string(region) + endings.piece), *whole, *part, origin, owned, task));
    made.parts.push_back({written.back().file, written.back().first, part->grid.point_count(), part->grid.cell_count(), own_cells});
    for (const PointArray& array : whole->arrays) drop_pages(array);  // they were copied
  }
  const fs::path list = folder.file(stem + endings.list);
  write_part_list(list, *whole, written);
  OutputFile manifest(folder.file(manifest_of(list).filename().string()));
  manifest.text(to_text(made));
  manifest.finish();
  folder.keep();
  task.report(1, "writing");
  const double write_ms = stage.lap_ms();
  if (arguments.json)
    print_json(to_json(made, list.string(), load_ms, write_ms));
  else
    print_text(made, list.string(), load_ms, write_ms);
}

}  // namespace

void add_partition_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand("partition", "Writes a dataset in parts, one for each rank, which then reads no other (docs/ranks.md); VTK and ParaView open them as one");
  const auto arguments = std::make_shared<PartitionArguments>();
  add_file_option(*command, arguments->file, "A file, or the name of analytic data (torus:64)");
  command->add_option("--parts", arguments->parts, "How many: as many as there will be ranks, and no more than there are cells")->required()->check(CLI::Range(1, 65536));
  command->add_option("--out", arguments->out, "The folder for the parts, their list (.pvtu, .pvti, .pvtr or .pvts, by the kind of grid) and the planes between them (.parts.json); empty, or not there yet")
      ->type_name("FOLDER")
      ->required();
  add_region_options(*command);
  command->add_option("--step", arguments->step, "The time step to write, from 0");
  command->add_option("--threads", arguments->threads, "Threads to use (default: all cores)")->check(CLI::Range(0, 4096));
  command->add_flag("--json", arguments->json, "Print one JSON document");
  add_sandbox_option(*command);
  command->callback([arguments] { run(*arguments); });
}

}  // namespace isostrata
