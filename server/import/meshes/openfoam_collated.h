// Cases of OpenFOAM's file handler "collated": each file of a folder "processors4" (or "processors4_0-1" and "processors4_2-3") holds those of all its processors, a block of bytes each.
// VTK's reader takes a folder for each processor.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "import/imported/imported.h"

namespace isostrata {

struct CollatedCase {
  std::vector<std::filesystem::path> folders;  // in the order of their processors
  std::vector<std::string> names;              // of the times that all of them have, in their order
  std::vector<double> times;                   // the same as numbers
  std::vector<std::string> regions;            // folders with a mesh, below those of times and "constant"; "" is the only one of most cases
};

/// folders: openfoam_parts of data/files/openfoam_case.h. From the names in them alone. Throws bad_data if they are not all there, or have no time in common; too_large if there are too many.
CollatedCase collated_case(const std::vector<std::filesystem::path>& folders, const std::string& name);

/// The folders that take_apart writes into, in request.scratch, of a file that is such a case; else nothing. For whoever may soon make no more folders.
void make_folders_of_processors(const ReadRequest& request);

/// The case of each processor as files of its own.
class TakenApart {
 public:
  /// The mesh as it is at the request's step, as the constant one, and the fields of this step. Throws bad_data if a file is cut off or has another number of blocks, not_found if a
  /// mesh lacks a file.
  TakenApart(const CollatedCase& of, const ReadRequest& request);
  ~TakenApart();  // removes them
  TakenApart(const TakenApart&) = delete;
  TakenApart& operator=(const TakenApart&) = delete;

  const std::vector<std::filesystem::path>& folders() const { return folders_; }

 private:
  struct Run {
    std::size_t first, count;  // of folders_
  };
  void split(const std::filesystem::path& from, const std::filesystem::path& folder, const Run& processors, const std::filesystem::path& to);

  const ReadRequest& request_;
  std::vector<std::filesystem::path> folders_, files_;
  std::uint64_t bytes_ = 0;
};

}  // namespace isostrata
