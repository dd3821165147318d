#include "random/layer_laws.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

#include "extraction/layers/extract_layers.h"

namespace isostrata::random_test {
namespace {

std::shared_ptr<Dataset> dataset_of(const Grid& grid, std::vector<PointArray> arrays) {
  auto data = std::make_shared<Dataset>();
  data->name = "random";
  data->grid = grid;
  data->bounds = grid.bounds();
  data->arrays = std::move(arrays);
  for (PointArray& array : data->arrays) measure_range(array);
  return data;
}

double volume_of(const IntervalMesh& mesh) {
  double sum = 0;
  for (const IntervalSummary& summary : mesh.summaries) sum += summary.signed_volume;
  return sum;
}

[[noreturn]] void differ(const std::string& law, double left, double right) {
  std::ostringstream text;
  text.precision(17);
  text << law << ": " << left << " and " << right;
  throw BrokenLaw(text.str());
}

/// Extracts, counts, and checks that the facets match.
double checked_volume(const LayerRequest& request, const StepSource& steps, const std::string& what, Checked& checked) {
  const Task task;
  const Layers layers = extract_layers(request, steps, task);
  if (const auto unmatched = count_unmatched_facets(layers.mesh, task); unmatched != 0)
    throw BrokenLaw(what + ": " + std::to_string(unmatched) + " unmatched facets");
  checked.tetrahedra += static_cast<std::int64_t>(layers.mesh.tetrahedra.size());
  checked.points += static_cast<std::int64_t>(layers.mesh.positions.size());
  checked.facets += static_cast<std::int64_t>(layers.mesh.facets.size());
  return volume_of(layers.mesh);
}

/// A range that begins and ends on values of the array or between them.
Interval random_range(const PointArray& array, Random& random) {
  const double width = array.upper - array.lower;
  std::uniform_real_distribution<double> part(0, 1);
  const double a = array.lower + width * part(random), b = array.lower + width * part(random);
  if (a == b) return {array.lower, std::nextafter(array.upper, std::numeric_limits<double>::infinity())};
  return {std::min(a, b), std::max(a, b)};
}

}  // namespace

Checked check_combined(const RandomInput& input, Random& random) {
  const auto data = dataset_of(input.grid, {input.array, input.second});
  const StepSource steps = [&](int, const Task&) { return data; };
  Checked checked;
  checked.cells = input.grid.cell_count();
  LayerRequest request;
  request.array = data->arrays[0].name;
  request.intervals = {input.intervals.front()};
  request.facets = true;
  const RangeTerm term{RangeOperator::intersect, data->arrays[1].name, random_range(data->arrays[1], random)};
  const double a = checked_volume(request, steps, "A", checked);
  const auto with = [&](RangeOperator op, const char* what) {
    request.terms = {term};
    request.terms[0].op = op;
    return checked_volume(request, steps, what, checked);
  };
  const double both = with(RangeOperator::intersect, "A and B"), only_a = with(RangeOperator::subtract, "A minus B");
  const double either = with(RangeOperator::unite, "A or B"), one = with(RangeOperator::exclusive_or, "A xor B");
  const double rounding = 1e-10 * (std::abs(either) + 1);
  if (!(std::abs(both + only_a - a) <= rounding)) differ("A and B with A minus B is A", both + only_a, a);
  if (!(std::abs(either - one - both) <= rounding)) differ("A or B less A xor B is A and B", either - one, both);
  return checked;
}

Checked check_strict(const RandomInput& input) {
  const auto data = dataset_of(input.grid, {input.array});
  const StepSource steps = [&](int, const Task&) { return data; };
  const Task task;
  LayerRequest request;
  request.intervals = input.intervals;
  request.facets = true;
  const IntervalMesh table = extract_layers(request, steps, task).mesh;
  request.triangulation = Triangulation::strict;
  const IntervalMesh strict = extract_layers(request, steps, task).mesh;
  if (const auto unmatched = count_unmatched_facets(strict, task); unmatched != 0)
    throw BrokenLaw("strict: " + std::to_string(unmatched) + " unmatched facets");
  // On the cells' faces both are the same; inside, an isosurface may be cut otherwise.
  if (count_label(strict, FacetLabel::domain) != count_label(table, FacetLabel::domain))
    throw BrokenLaw("strict: " + std::to_string(count_label(strict, FacetLabel::domain)) + " domain facets, the tables make " +
                    std::to_string(count_label(table, FacetLabel::domain)));
  // Where the intervals tile the range both fill what the same domain facets enclose.
  const double rounding = 1e-11 * std::pow(input.expectation.scale, 3);
  if (input.expectation.tiles && !(std::abs(volume_of(strict) - volume_of(table)) <= rounding))
    differ("the strict volume is the tables'", volume_of(strict), volume_of(table));
  for (const IntervalSummary& summary : strict.summaries)
    if (summary.inverted != 0 && input.expectation.flat_faces)
      throw BrokenLaw("strict: " + std::to_string(summary.inverted) + " inverted tetrahedra");
  Checked checked;
  checked.cells = input.grid.cell_count();
  checked.tetrahedra = static_cast<std::int64_t>(strict.tetrahedra.size());
  checked.points = static_cast<std::int64_t>(strict.positions.size());
  checked.facets = static_cast<std::int64_t>(strict.facets.size());
  return checked;
}

Checked check_space_time(const RandomInput& input, Random& random) {
  PointArray later = input.second;
  later.name = input.array.name;
  const auto first = dataset_of(input.grid, {input.array}), second = dataset_of(input.grid, {later});
  first->times = second->times = {0.0, 1.0};
  second->step = 1;
  const StepSource steps = [&](int step, const Task&) { return step == 0 ? first : second; };
  Checked checked;
  checked.cells = input.grid.cell_count();
  const double lower = std::min(first->arrays[0].lower, second->arrays[0].lower);
  const double upper = std::max(first->arrays[0].upper, second->arrays[0].upper);
  LayerRequest request;
  request.array = input.array.name;
  request.facets = true;
  request.time_mode = TimeMode::spacetime;
  request.intervals = tiling({lower, lower + 0.4 * (upper - lower), lower + 0.7 * (upper - lower), upper});
  std::erase_if(request.intervals, [](const Interval& interval) { return !(interval.lower < interval.upper); });
  if (request.intervals.empty()) request.intervals = {{lower, std::nextafter(upper, std::numeric_limits<double>::infinity())}};
  const double whole = input.expectation.whole;
  for (const double time : {0.0, std::uniform_real_distribution<double>(0, 1)(random), 1.0}) {
    request.time = time;
    const double volume = checked_volume(request, steps, "at time " + std::to_string(time), checked);
    if (whole >= 0 && !(std::abs(volume - whole) <= 1e-10 * whole)) differ("a slice holds all of the mesh", volume, whole);
  }
  return checked;
}

}  // namespace isostrata::random_test
