// VTK's way to an interval volume: clip at the lower end, clip the rest at the upper end, and cut what is left into tetrahedra.
#pragma once

#include <cstdint>
#include <memory>

#include "workload.h"

namespace isostrata::peers {

/// The workload as a VTK dataset over the very same arrays: nothing is copied but the axes of a rectilinear grid. One per thread.
class VtkPeer {
 public:
  /// Throws unsupported for grids with hidden cells.
  explicit VtkPeer(const Workload& workload);
  ~VtkPeer();

  /// vtkTableBasedClipDataSet at the lower end, then, inside out, at the upper one. New filters at each call.
  void clip_twice();
  /// vtkDataSetTriangleFilter on the result.
  void tetrahedralise();

  std::int64_t cells() const;           // of the newest result
  double volume() const;                // of the newest result's tetrahedra; precondition: tetrahedralise
  std::int64_t not_tetrahedra() const;  // cells of the newest result that are something else
  void forget();                        // frees the results

 private:
  struct Pipeline;
  std::unique_ptr<Pipeline> pipeline_;
};

}  // namespace isostrata::peers
