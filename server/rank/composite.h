// Pictures of regions become one, front to back, by all ranks together.
//
// Source: K. Moreland, W. Kendall, T. Peterka, J. Huang, "An Image Compositing Solution at Scale", 2011: IceT, which does the work.
#pragma once

#include <IceT.h>
#include <mpi.h>

#include <array>
#include <vector>

#include "base/image.h"

namespace isostrata {

/// One in a process. Every function is called by all ranks, with the same size and order.
class Compositor {
 public:
  explicit Compositor(MPI_Comm ranks);
  ~Compositor();
  Compositor(const Compositor&) = delete;
  Compositor& operator=(const Compositor&) = delete;

  /// Premultiplied colours over one another: those of front_to_back[0] before all others. covered: x, y, width and height of the pixels that
  /// this rank may have drawn. What comes back is the whole picture on the first rank, without depth, and empty on others; it
  /// is there until the next call. Throws internal.
  const FloatImage& blend(const FloatImage& own, const std::array<int, 4>& covered, const std::vector<int>& front_to_back);

  FloatImage painted;  // for whoever paints several such pictures over one another

 private:
  IceTContext context_;
  FloatImage whole_;  // memory that is written for the first time is dear
};

}  // namespace isostrata
