// isostrata-random-extract: random cells and meshes against the laws of interval volumes, for as long as one likes. Meant to run
// under AddressSanitizer and UndefinedBehaviorSanitizer beside the tests that CI runs:
//
//   cmake --preset asan && ninja -C build/asan isostrata-random-extract && build/asan/bin/isostrata-random-extract
//
// Prints what was checked; where a law breaks, what broke and the one line that does it again, and exits with 1.
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "base/error.h"
#include "base/task.h"
#include "extraction/unstructured/ordered_memory.h"
#include "random/layer_laws.h"
#include "random/mesh_laws.h"
#include "random/random_grids.h"

namespace isostrata::random_test {
namespace {

struct Options {
  std::int64_t cells = 1'000'000;  // of each kind
  std::uint64_t seed = 20041014;
  std::string only;         // one kind
  std::int64_t batch = -1;  // one batch of it
};

IntervalMesh extracted(const RandomInput& input) { return extract(input.grid, input.array, input.intervals); }

Checked check_plain(const RandomInput& input) {
  return check_mesh(input.grid, input.array, input.intervals, extracted(input), input.expectation);
}

/// A structured grid and the same cells written out one by one give the same tetrahedra.
Checked check_structured(const RandomInput& input) {
  const IntervalMesh mesh = extracted(input);
  const Checked checked = check_mesh(input.grid, input.array, input.intervals, mesh, input.expectation);
  Grid explicit_cells = unstructured_grid(as_parts(input.grid));
  explicit_cells.hidden_cells = input.grid.hidden_cells;
  const IntervalMesh other = extract(explicit_cells, input.array, input.intervals);
  if (tetrahedra_by_origin(mesh) != tetrahedra_by_origin(other)) throw BrokenLaw("a grid and its explicit cells differ");
  if (mesh.facets.size() != other.facets.size()) throw BrokenLaw("a grid and its explicit cells have other boundaries");
  return checked;
}

/// Tetrahedra that were laid out obey the laws and are those of the way without a layout. Where a value is not finite the way
/// without is taken, so other values stand in for some of these.
Checked check_ordered(RandomInput input, Random& random) {
  std::vector<double> values(static_cast<std::size_t>(input.grid.point_count()));
  double finite = input.array.lower;
  for (std::size_t p = 0; p < values.size(); ++p) {
    values[p] = input.array.at(p);
    if (std::isfinite(values[p])) finite = values[p];
  }
  if (!std::isfinite(finite)) finite = 0;
  if (random() % 8 != 0)
    for (double& value : values)
      if (!std::isfinite(value)) value = finite;
  input.array = point_array(values);
  OrderedMemory memory(std::uint64_t{1} << 30);
  memory.make(input.grid, Task{});
  ExtractOptions options;
  options.facets = true;
  options.ordered = &memory;
  const IntervalMesh mesh = extract_intervals(input.grid, input.array, input.intervals, options, Task{});
  const Checked checked = check_mesh(input.grid, input.array, input.intervals, mesh, input.expectation);
  const IntervalMesh other = extracted(input);
  if (tetrahedra_by_origin(mesh) != tetrahedra_by_origin(other)) throw BrokenLaw("a layout changes the tetrahedra");
  if (mesh.facets.size() != other.facets.size()) throw BrokenLaw("a layout changes the boundaries");
  return checked;
}

struct Kind {
  std::string name;
  std::function<Checked(Random&)> batch;
  int share = 1;  // of the cells asked for, one in so many: for what takes several extractions
};

std::vector<Kind> kinds() {
  std::vector<Kind> out;
  for (const CellType type : kCellTypes)
    out.push_back({std::string(topology(type).name), [type](Random& random) {
                     constexpr std::int64_t kCells = 500;
                     return check_plain(isolated_cells(type, kCells, random() % 2 == 0, random));
                   }});
  out.push_back({"ordered", [](Random& random) {
                   return check_ordered(isolated_cells(CellType::tetrahedron, 500, random() % 2 == 0, random), random);
                 }});
  out.push_back({"glued", [](Random& random) {
                   Checked sum;
                   for (int pair = 0; pair < 50; ++pair) sum += check_plain(glued_cells(random));
                   return sum;
                 }});
  out.push_back({"mixed", [](Random& random) { return check_plain(mixed_mesh(random)); }});
  out.push_back({"polyhedra", [](Random& random) { return check_plain(polyhedra(random)); }});
  out.push_back({"structured", [](Random& random) {
                   Checked sum;
                   for (int grid = 0; grid < 10; ++grid) sum += check_structured(structured_grid(random));
                   return sum;
                 }});
  out.push_back({"combined",
                 [](Random& random) {
                   Checked sum = check_combined(mixed_mesh(random), random);
                   for (int grid = 0; grid < 4; ++grid) sum += check_combined(structured_grid(random), random);
                   return sum;
                 },
                 10});
  out.push_back({"strict",
                 [](Random& random) {
                   Checked sum = check_strict(mixed_mesh(random));
                   sum += check_strict(polyhedra(random));
                   for (int grid = 0; grid < 4; ++grid) sum += check_strict(structured_grid(random));
                   return sum;
                 },
                 10});
  out.push_back({"spacetime",
                 [](Random& random) {
                   Checked sum = check_space_time(mixed_mesh(random), random);
                   sum += check_space_time(polyhedra(random), random);
                   return sum;
                 },
                 10});
  return out;
}

/// The same numbers for a batch whether it runs alone or among others.
Random random_of(const Options& options, const std::string& kind, std::int64_t batch) {
  std::vector<std::uint32_t> words{static_cast<std::uint32_t>(options.seed), static_cast<std::uint32_t>(options.seed >> 32),
                                   static_cast<std::uint32_t>(batch), static_cast<std::uint32_t>(batch >> 32)};
  words.insert(words.end(), kind.begin(), kind.end());
  std::seed_seq sequence(words.begin(), words.end());
  return Random(sequence);
}

bool run_kind(const Kind& kind, const Options& options) {
  const auto start = std::chrono::steady_clock::now();
  Checked sum;
  std::int64_t batches = 0;
  const std::int64_t first = std::max<std::int64_t>(options.batch, 0);
  for (std::int64_t batch = first; sum.cells < options.cells / kind.share && (options.batch < 0 || batch == first);
       ++batch, ++batches) {
    Random random = random_of(options, kind.name, batch);
    std::string what;
    try {
      sum += kind.batch(random);
      continue;
    } catch (const BrokenLaw& law) {
      what = law.what();
    } catch (const Error& error) {
      what = std::string("an error: ") + error.what();
    }
    std::printf("%s, batch %lld: %s\nagain: isostrata-random-extract --seed %llu --only %s --batch %lld\n", kind.name.c_str(),
                static_cast<long long>(batch), what.c_str(), static_cast<unsigned long long>(options.seed), kind.name.c_str(),
                static_cast<long long>(batch));
    return false;
  }
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  std::printf(
      "%-12s %9lld cells in %7lld batches: %9lld active, %7lld absent, %10lld tetrahedra, %10lld points, %10lld facets; %.1f s\n",
      kind.name.c_str(), static_cast<long long>(sum.cells), static_cast<long long>(batches), static_cast<long long>(sum.active),
      static_cast<long long>(sum.absent), static_cast<long long>(sum.tetrahedra), static_cast<long long>(sum.points),
      static_cast<long long>(sum.facets), seconds);
  std::fflush(stdout);
  return true;
}

int usage() {
  std::string names;
  for (const Kind& kind : kinds()) names += " " + kind.name;
  std::fprintf(stderr, "usage: isostrata-random-extract [--cells N] [--seed S] [--only KIND] [--batch N]\nkinds:%s\n",
               names.c_str());
  return 2;
}

int run(int argc, char** argv) {
  Options options;
  for (int i = 1; i + 1 < argc; i += 2) {
    const std::string name = argv[i], value = argv[i + 1];
    if (name == "--cells")
      options.cells = std::atoll(value.c_str());
    else if (name == "--seed")
      options.seed = std::strtoull(value.c_str(), nullptr, 10);
    else if (name == "--only")
      options.only = value;
    else if (name == "--batch")
      options.batch = std::atoll(value.c_str());
    else
      return usage();
  }
  if (argc % 2 == 0) return usage();
  bool any = false;
  std::printf("seed %llu\n", static_cast<unsigned long long>(options.seed));
  for (const Kind& kind : kinds()) {
    if (!options.only.empty() && kind.name != options.only) continue;
    any = true;
    if (!run_kind(kind, options)) return 1;
  }
  return any ? 0 : usage();
}

}  // namespace
}  // namespace isostrata::random_test

int main(int argc, char** argv) { return isostrata::random_test::run(argc, argv); }
