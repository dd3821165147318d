// Combined ranges against chains of VTK's vtkClipDataSet on meshes of tetrahedra, where both are exact.
#include <gtest/gtest.h>
#include <vtkAppendFilter.h>
#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkCellSizeFilter.h>
#include <vtkClipDataSet.h>
#include <vtkDataArray.h>
#include <vtkDoubleArray.h>
#include <vtkIdList.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkSmartPointer.h>
#include <vtkTetra.h>
#include <vtkUnstructuredGrid.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <random>

#include "data/dataset/analytic.h"
#include "data/dataset/dataset.h"
#include "extraction/layers/extract_layers.h"
#include "support/places.h"
#include "support/shared_data.h"

namespace isostrata {
namespace {

using GridPointer = vtkSmartPointer<vtkUnstructuredGrid>;

/// The tetrahedra of a dataset in double, with the arrays named. Slivers and left-handed ones are kept; their volumes count
/// positive in both programs.
GridPointer as_vtk(const Dataset& dataset, const std::vector<std::string>& arrays) {
  GridPointer out = GridPointer::New();
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  for (std::int64_t p = 0; p < dataset.grid.point_count(); ++p) {
    const Vec3d at = dataset.grid.point(p);
    points->InsertNextPoint(at.x, at.y, at.z);
  }
  out->SetPoints(points);
  std::array<std::int64_t, kMaxCellVertices> ids;
  out->Allocate(dataset.grid.cell_count());
  for (std::int64_t c = 0; c < dataset.grid.cell_count(); ++c) {
    if (dataset.grid.hidden(c)) continue;
    const int n = dataset.grid.cell_points(c, ids);
    std::array<vtkIdType, kMaxCellVertices> own;
    std::copy_n(ids.begin(), n, own.begin());
    out->InsertNextCell(static_cast<int>(dataset.grid.cell_type(c)), n, own.data());
  }
  for (const std::string& name : arrays) {
    const PointArray& array = dataset.array(name);
    vtkNew<vtkDoubleArray> values;
    values->SetName(name.c_str());
    for (std::int64_t p = 0; p < dataset.grid.point_count(); ++p) values->InsertNextValue(array.at(p));
    out->GetPointData()->AddArray(values);
  }
  return out;
}

/// The side of a value: what is above, or what is below.
GridPointer clip(const GridPointer& grid, const std::string& array, double value, bool below) {
  if (grid->GetNumberOfCells() == 0) return grid;
  vtkNew<vtkClipDataSet> filter;
  filter->SetInputData(grid);
  filter->SetInputArrayToProcess(0, 0, 0, vtkDataObject::FIELD_ASSOCIATION_POINTS, array.c_str());
  filter->SetValue(value);
  filter->SetInsideOut(below);
  filter->SetOutputPointsPrecision(vtkAlgorithm::DOUBLE_PRECISION);
  filter->Update();
  GridPointer out = GridPointer::New();
  out->ShallowCopy(filter->GetOutput());
  return out;
}

GridPointer inside(const GridPointer& grid, const std::string& array, const Interval& range) {
  return clip(clip(grid, array, range.lower, false), array, range.upper, true);
}

GridPointer joined(const GridPointer& a, const GridPointer& b) {
  vtkNew<vtkAppendFilter> append;
  append->SetOutputPointsPrecision(vtkAlgorithm::DOUBLE_PRECISION);
  if (a->GetNumberOfCells() == 0) return b;
  if (b->GetNumberOfCells() == 0) return a;
  append->AddInputData(a);
  append->AddInputData(b);
  append->Update();
  GridPointer out = GridPointer::New();
  out->ShallowCopy(append->GetOutput());
  return out;
}

GridPointer outside(const GridPointer& grid, const std::string& array, const Interval& range) {
  return joined(clip(grid, array, range.lower, true), clip(grid, array, range.upper, false));
}

double volume(const GridPointer& grid) {
  if (grid->GetNumberOfCells() == 0) return 0;
  vtkNew<vtkCellSizeFilter> size;
  size->SetInputData(grid);
  size->SetComputeVolume(true);
  size->SetComputeArea(false);
  size->SetComputeLength(false);
  size->SetComputeVertexCount(false);
  size->Update();
  vtkDataArray* const volumes = vtkUnstructuredGrid::SafeDownCast(size->GetOutput())->GetCellData()->GetArray("Volume");
  double sum = 0;
  for (vtkIdType i = 0; i < volumes->GetNumberOfTuples(); ++i) sum += std::abs(volumes->GetTuple1(i));
  return sum;
}

/// What is in the region and, as long as a later term may add of it, what is not.
double vtk_volume(const GridPointer& whole, const LayerRequest& request) {
  const auto adds_later = [&](std::size_t from) {
    return std::any_of(request.terms.begin() + static_cast<std::ptrdiff_t>(from), request.terms.end(),
                       [](const RangeTerm& term) { return adds(term.op); });
  };
  const GridPointer nothing = GridPointer::New();
  GridPointer in = inside(whole, request.array, request.intervals[0]);
  GridPointer out = adds_later(0) ? outside(whole, request.array, request.intervals[0]) : nothing;
  for (std::size_t k = 0; k < request.terms.size(); ++k) {
    const auto& [op, array, range] = request.terms[k];
    std::array<std::array<GridPointer, 2>, 2> part{{{nothing, nothing}, {nothing, nothing}}};  // [was in][is in the range]
    const bool out_wanted = adds_later(k + 1);
    for (const bool was : {false, true})
      for (const bool is : {false, true})
        if (combined(op, was, is) || out_wanted)
          part[was][is] = is ? inside(was ? in : out, array, range) : outside(was ? in : out, array, range);
    in = out = nothing;
    for (const bool was : {false, true})
      for (const bool is : {false, true}) {
        GridPointer& to = combined(op, was, is) ? in : out;
        to = joined(to, part[was][is]);
      }
  }
  return volume(in);
}

/// Chains of two terms, of which VTK takes its time.
enum class Pairs { none, some, all };

void compare(const std::shared_ptr<const Dataset>& dataset, const std::string& first, const std::vector<std::string>& others,
             Pairs pairs) {
  ASSERT_EQ(dataset->cell_types.size(), dataset->cell_types.count("tetrahedron"))
      << "where cells are not tetrahedra, VTK cuts otherwise";
  std::vector<std::string> names{first};
  names.insert(names.end(), others.begin(), others.end());
  const GridPointer whole = as_vtk(*dataset, names);
  const double all = volume(whole);
  // A range of the middle of an array's values, by rank: half of the points lie in it.
  const auto middle = [&](const std::string& name, double from, double to) {
    const PointArray& array = dataset->array(name);
    std::vector<double> values;
    for (std::int64_t p = 0; p < dataset->grid.point_count(); ++p) values.push_back(array.at(p));
    std::sort(values.begin(), values.end());
    const auto at = [&](double share) {
      return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
    };
    // Off the points' own values, where VTK and this program decide ties differently.
    return Interval{at(from) + 1e-7 * (array.upper - array.lower), at(to) + 1e-7 * (array.upper - array.lower)};
  };
  constexpr std::array kNames{"and", "or", "minus", "xor"};
  constexpr std::array kOperators{RangeOperator::intersect, RangeOperator::unite, RangeOperator::subtract,
                                  RangeOperator::exclusive_or};
  const Task task;
  const auto check = [&](const std::vector<RangeTerm>& terms, const std::string& what) {
    LayerRequest request;
    request.array = first;
    request.intervals = {middle(first, 0.3, 0.8)};
    request.terms = terms;
    request.facets = false;
    using Clock = std::chrono::steady_clock;
    const auto start = Clock::now();
    const Layers layers = extract_layers(
        request, [&](int, const Task&) { return dataset; }, task);
    const auto between = Clock::now();
    const double theirs = vtk_volume(whole, request);
    const auto end = Clock::now();
    double ours = 0;
    for (const IntervalSummary& summary : layers.mesh.summaries) ours += summary.signed_volume;
    const auto ms = [](auto duration) { return std::chrono::duration<double, std::milli>(duration).count(); };
    std::printf("%-14s %-16s ours %.12g, VTK %.12g, difference %.1e of the mesh; %.0f ms and %.0f ms\n",
                dataset->name.c_str() + dataset->name.rfind('/') + 1, what.c_str(), ours, theirs, std::abs(ours - theirs) / all,
                ms(between - start), ms(end - between));
    std::fflush(stdout);
    EXPECT_GT(theirs, 1e-4 * all) << what;
    EXPECT_NEAR(ours, theirs, 1e-6 * theirs) << what;
  };
  for (std::size_t i = 0; i < kOperators.size(); ++i) check({{kOperators[i], others[0], middle(others[0], 0.4, 0.9)}}, kNames[i]);
  const std::string second = others.size() > 1 ? others[1] : first;
  for (std::size_t i = 0; i < kOperators.size(); ++i)
    for (std::size_t k = 0; k < kOperators.size(); ++k) {
      if (pairs == Pairs::none || (pairs == Pairs::some && k != (i + 1) % kOperators.size())) continue;
      check({{kOperators[i], others[0], middle(others[0], 0.4, 0.9)}, {kOperators[k], second, middle(second, 0.2, 0.5)}},
            std::string(kNames[i]) + ", " + kNames[k]);
    }
}

std::shared_ptr<const Dataset> open(const std::filesystem::path& path) {
  OpenOptions options;
  options.importer = std::filesystem::path(isostrata::places::binaries()) / "isostrata-import";
  const Task task;
  return open_dataset(path.string(), options, task);
}

template <class Field>
void add_array(Dataset& dataset, const std::string& name, const Field& field) {
  auto values = std::make_shared<std::vector<double>>();
  for (std::int64_t p = 0; p < dataset.grid.point_count(); ++p) values->push_back(field(dataset.grid.point(p)));
  PointArray array;
  array.name = name;
  array.type = ScalarType::float64;
  array.values = std::span<const double>(*values);
  array.storage = values;
  measure_range(array);
  dataset.arrays.push_back(std::move(array));
}

/// The dataset without cells of other types.
std::shared_ptr<const Dataset> only_tetrahedra(const Dataset& dataset) {
  struct Cells {
    std::shared_ptr<const void> before;
    std::vector<std::uint8_t> types;
    std::vector<std::int64_t> offsets{0}, connectivity;
  };
  auto cells = std::make_shared<Cells>();
  cells->before = dataset.grid.storage;
  auto out = std::make_shared<Dataset>(dataset);
  std::array<std::int64_t, kMaxCellVertices> ids;
  for (std::int64_t c = 0; c < dataset.grid.cell_count(); ++c) {
    if (dataset.grid.cell_type(c) != CellType::tetrahedron || dataset.grid.hidden(c)) continue;
    dataset.grid.cell_points(c, ids);
    cells->types.push_back(static_cast<std::uint8_t>(CellType::tetrahedron));
    cells->connectivity.insert(cells->connectivity.end(), ids.begin(), ids.begin() + 4);
    cells->offsets.push_back(static_cast<std::int64_t>(cells->connectivity.size()));
  }
  auto& shape = std::get<UnstructuredGrid>(out->grid.shape);
  shape.types = cells->types;
  shape.offsets = cells->offsets;
  shape.connectivity = cells->connectivity;
  out->grid.hidden_cells = {};
  out->grid.storage = cells;
  out->cell_types = {{"tetrahedron", static_cast<std::int64_t>(cells->types.size())}};
  return out;
}

TEST(CombineAgainstVtk, OnTetrahedraOfATorus) {
  for (const auto& [name, pairs] : {std::pair{"tets:32", Pairs::none}, std::pair{"tets:14", Pairs::all}}) {
    const Task task;
    auto dataset = std::make_shared<Dataset>(*make_analytic(name, {}, task));
    add_array(*dataset, "lobes", [](Vec3d p) { return marschner_lobb(p); });
    add_array(*dataset, "slope", [](Vec3d p) { return p.x + 0.3 * p.y * p.y - 0.5 * p.z; });
    compare(dataset, "distance", {"lobes", "slope"}, pairs);
  }
}

/// Flat tetrahedra whose inner points were moved, every other one left-handed.
std::shared_ptr<Dataset> slivers() {
  struct Changed {
    std::shared_ptr<const void> before;
    std::vector<Vec3d> points;
    std::vector<std::int64_t> connectivity;
  };
  const Task task;
  auto dataset = std::make_shared<Dataset>(*make_analytic("tets:9", {}, task));
  auto& shape = std::get<UnstructuredGrid>(dataset->grid.shape);
  auto changed = std::make_shared<Changed>();
  changed->before = dataset->grid.storage;
  std::mt19937_64 random(20);
  std::uniform_real_distribution<double> by(-0.03, 0.03);
  for (std::int64_t p = 0; p < dataset->grid.point_count(); ++p) {
    const Vec3d at = dataset->grid.point(p);
    const bool inside = std::max({std::abs(at.x), std::abs(at.y), std::abs(at.z)}) < 0.99;
    const Vec3d moved = at + (inside ? Vec3d{by(random), by(random), by(random)} : Vec3d{});
    changed->points.push_back({moved.x, moved.y, 0.01 * moved.z});
  }
  changed->connectivity.assign(shape.connectivity.begin(), shape.connectivity.end());
  for (std::size_t c = 0; c < shape.types.size(); c += 2) std::swap(changed->connectivity[4 * c], changed->connectivity[4 * c + 1]);
  shape.points = std::span<const Vec3d>(changed->points);
  shape.connectivity = changed->connectivity;
  dataset->grid.storage = changed;
  dataset->bounds = dataset->grid.bounds();
  return dataset;
}

TEST(CombineAgainstVtk, OnSliversOfEitherOrientation) {
  const auto dataset = slivers();
  add_array(*dataset, "lobes", [](Vec3d p) { return marschner_lobb({p.x, p.y, 100 * p.z}); });
  add_array(*dataset, "slope", [](Vec3d p) { return p.x + 0.3 * p.y * p.y - 50 * p.z; });
  compare(dataset, "distance", {"lobes", "slope"}, Pairs::some);
}

TEST(SharedDataCombineAgainstVtk, OnThePost) {
  ISOSTRATA_NEEDS_SHARED_DATA();
  auto dataset = std::make_shared<Dataset>(*open(testing::shared_data() / "ug_post_tets" / "post.vtk"));
  add_array(*dataset, "radius", [](Vec3d p) { return std::hypot(p.x, p.y); });  // the file has one array only
  compare(dataset, "Pressure", {"radius"}, Pairs::all);
}

TEST(SharedDataCombineAgainstVtk, OnThePatchAntenna) {
  ISOSTRATA_NEEDS_SHARED_DATA();
  compare(only_tetrahedra(*open(testing::shared_data() / "ug_patch_antenna" / "patch_antenna.vtu")), "ElectricField",
          {"MagneticField", "MagneticField_x"}, Pairs::all);
}

TEST(SharedDataCombineAgainstVtk, OnTheAneurysmsTetrahedra) {
  ISOSTRATA_NEEDS_SHARED_DATA();
  compare(only_tetrahedra(*open(testing::shared_data() / "ug_aneurysm_fem" / "output_fem.vtu")), "Umag", {"p", "u"}, Pairs::some);
}

}  // namespace
}  // namespace isostrata
