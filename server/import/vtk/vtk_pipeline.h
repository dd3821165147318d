// What is the same for every reader of VTK's: checks, time steps, progress, and what is made of its output.
#pragma once

#include <string>
#include <vector>

#include "import/imported/imported.h"

class vtkAlgorithm;
class vtkDataObject;

namespace isostrata {

/// Tells request.progress how far the reader is. The request must outlive the reader's work.
void report_progress(vtkAlgorithm* reader, const ReadRequest& request);

/// The times that a reader's information lists; empty if it lists none. After UpdateInformation. `name` is the file's.
std::vector<double> listed_times(vtkAlgorithm* reader, const std::string& name);

/// The time that a file says it has, as ParaView and VTK write it; {0} where it says none.
std::vector<double> declared_times(vtkDataObject* object);

/// Updates the reader's information, checks the declared size and the step, reads it, and turns its output into blocks. Throws bad_data with the first
/// thing that VTK complained of.
Imported run_reader(vtkAlgorithm* reader, const ReadRequest& request);

/// As run_reader, for a reader that has been told what to read and whose information is up to date.
Imported read_step(vtkAlgorithm* reader, const ReadRequest& request);

}  // namespace isostrata
