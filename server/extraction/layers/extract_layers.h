// Everything that can be asked of an extraction, as one plain request: what the command line, the engine and the benchmarks send.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/task.h"
#include "data/dataset/dataset.h"
#include "extraction/intervals/extract_intervals.h"
#include "extraction/mesh/interval_mesh.h"
#include "scene/field_values.h"
#include "scene/range_term.h"
#include "scene/time_mode.h"
#include "scene/triangulation.h"

namespace isostrata {

struct LayerRequest {
  std::string array;  // empty: the dataset's first
  std::vector<Interval> intervals;
  std::vector<RangeTerm> terms;
  int step = 0;                // where no time is given
  std::optional<double> time;  // in the dataset's units, clamped to nothing: outside the steps' times is invalid_argument
  TimeMode time_mode = TimeMode::step;
  Triangulation triangulation = Triangulation::table;
  FieldValues values = FieldValues::interpolated;  // whole: at a step, without terms, by the table; others are `unsupported`
  std::vector<std::string> carry;         // other arrays to bring to the mesh's points
  bool facets = false;                    // fill IntervalMesh::facets
  bool tetrahedra = true;                 // as ExtractOptions: of whole values alone
  bool normals = false;                   // with terms and facets: fill Layers::normals
  bool body_normals = false;              // with terms: fill Layers::body_normals
  std::uint64_t max_bytes = 16ull << 30;  // throws too_large, with the numbers, if more would be needed

  bool operator==(const LayerRequest&) const = default;
};

/// Which time was extracted, and how.
struct LayerTime {
  double time = 0;                 // that was asked for
  TimeMode mode = TimeMode::step;  // what was done: `step` where interpolation was asked for just at a step, too
  int first = 0, second = 0;       // the steps that were used; equal where one was enough
  double weight = 0;               // of second
  double build_ms = 0;             // to make the space-time volume; 0 if it was kept
  double slice_ms = 0;             // to slice it
  std::int64_t simplices = 0;      // 4-simplices in it
  std::uint64_t bytes = 0;         // that it takes
};

struct Layers {
  std::shared_ptr<const Dataset> dataset;  // whose grid the mesh lies in: the step's; between steps the first step's, or, where
                                           // points move or the field is interpolated, one of that time with the arrays asked for; of whole
                                           // values at points nearest_point_cells of it
  IntervalMesh mesh;                       // without origins in space-time mode
  std::vector<MeshArray> carried;          // one per LayerRequest::carry; of whole values those that belong to cells are in_cells
  std::vector<Vec3f> normals;              // [np] of the surfaces of combined ranges (combined_normals.h); not of slices
  std::vector<Vec3f> body_normals;         // [np] of combined ranges, along the gradient of LayerRequest::array; not of slices
  LayerTime time;
};

/// Opens a step of the dataset. The same object again where the same step is asked for again.
using StepSource = std::function<std::shared_ptr<const Dataset>(int step, const Task& task)>;

class BrickMemory;    // brick_memory.h
class FaceMemory;     // face_memory.h
class KeptSpaceTime;  // extract_at_time.h
class OrderedMemory;  // ordered_memory.h

/// extract_intervals, or what stands in for it on a device.
using Extractor = std::function<IntervalMesh(const Grid& grid, const PointArray& array, std::span<const Interval> intervals,
                                             const ExtractOptions& options, const Task& task)>;

/// What makes an extraction cheaper and leaves its result as it is.
struct LayerAids {
  BrickMemory* bricks = nullptr;     // as ExtractOptions::bricks
  OrderedMemory* ordered = nullptr;  // as ExtractOptions::ordered
  FaceMemory* faces = nullptr;       // as ExtractOptions::faces
  KeptSpaceTime* kept = nullptr;     // keeps the volume between two steps for the next slice
  Extractor extractor;  // called in place of extract_intervals if that is all there is to do: one field, no terms, tables
};

/// In space-time mode the volume between the two steps is made and sliced; a dataset of one step is extracted as it is. There
/// the strict triangulation has nothing to change: a slice's tetrahedra are turned over only where the cell's own split is.
/// Whole values of an array of cells are taken by its cells, those of an array of points by nearest_point_cells, on which every array has whole values.
/// Throws not_found (an array that is not there, naming it and those that are), invalid_argument, unsupported, too_large,
/// cancelled, and what `steps` and the aids throw. Any thread.
Layers extract_layers(const LayerRequest& request, const StepSource& steps, const Task& task, const LayerAids& aids = {});

}  // namespace isostrata
