// The grids of tetrahedra that are drawn without being split, each made once for all sessions (extraction/surfaces/base_tetrahedra.h).
#pragma once

#include <condition_variable>
#include <cstdint>
#include <list>
#include <memory>
#include <mutex>
#include <string>

#include "extraction/surfaces/base_tetrahedra.h"

namespace isostrata {

/// Any thread may call any function. Lock: mutex_.
class BaseMeshes {
 public:
  /// max_bytes: kept between uses, and the most that making one may take.
  explicit BaseMeshes(std::uint64_t max_bytes);

  /// The mesh of a step's array, if it is there. Null while it is being made, too.
  std::shared_ptr<const BaseTetrahedra> find(const std::shared_ptr<const Dataset>& dataset, const std::string& array);
  /// Makes it if it is not there; waits if another thread is at it. Null if the grid has other cells or the memory does
  /// not suffice. Throws not_found, cancelled.
  std::shared_ptr<const BaseTetrahedra> make(const std::shared_ptr<const Dataset>& dataset, const std::string& array,
                                             const Task& task);
  /// Of the meshes that are kept.
  std::uint64_t held_bytes() const;

 private:
  struct Held {
    std::weak_ptr<const Dataset> dataset;  // one object per step; a mesh does not keep its dataset
    std::string array;
    std::shared_ptr<const BaseTetrahedra> base;  // null while it is being made
    std::uint64_t bytes = 0;
  };
  std::list<Held>::iterator at(const std::shared_ptr<const Dataset>& dataset, const std::string& array);  // with mutex_ held
  void drop(std::uint64_t max_bytes);                                                                     // with mutex_ held

  const std::uint64_t max_bytes_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::list<Held> held_;  // the last used one first
};

}  // namespace isostrata
