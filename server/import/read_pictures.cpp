#include <vtkBMPReader.h>
#include <vtkImageData.h>
#include <vtkInformation.h>
#include <vtkNew.h>
#include <vtkPNGReader.h>
#include <vtkPNMReader.h>
#include <vtkSmartPointer.h>
#include <vtkStringArray.h>
#include <vtkTIFFReader.h>

#include <array>

#include "data/file_series.h"
#include "data/recognise.h"
#include "import/read_own.h"
#include "import/vtk_messages.h"
#include "import/vtk_pipeline.h"

namespace isostrata {
namespace {

vtkSmartPointer<vtkImageReader2> reader_of(const std::filesystem::path& file) {
  const std::string name = small_letters(file.filename().string());
  if (name.ends_with(".png")) return vtkSmartPointer<vtkPNGReader>::New();
  if (name.ends_with(".bmp")) return vtkSmartPointer<vtkBMPReader>::New();
  if (ends_with_one_of(name, ".pnm .pgm")) return vtkSmartPointer<vtkPNMReader>::New();
  return vtkSmartPointer<vtkTIFFReader>::New();
}

/// Size, type and number of components: VTK trusts that all slices are as the first.
std::array<int, 5> layout_of(const std::filesystem::path& file) {
  const std::string name = file.filename().string();
  const auto reader = reader_of(file);
  if (!reader->CanReadFile(file.c_str())) throw Error(ErrorCode::bad_data, name + ": is not the picture that its name says");
  reader->SetFileName(file.c_str());
  reader->UpdateInformation();
  throw_on_vtk_error(name);
  const int* extent = reader->GetDataExtent();
  return {extent[1] - extent[0] + 1, extent[3] - extent[2] + 1, extent[5] - extent[4] + 1, reader->GetDataScalarType(), reader->GetNumberOfScalarComponents()};
}

}  // namespace

Imported read_pictures(const ReadRequest& request) {
  const std::string name = request.file.filename().string();
  check_step(request, 1);
  const std::vector<SeriesFile> files = series_files(request.file);
  const auto first = layout_of(files.front().path);
  vtkNew<vtkStringArray> names;
  for (const SeriesFile& file : files) {
    const auto layout = files.size() == 1 ? first : layout_of(file.path);
    if (layout != first)
      throw Error(ErrorCode::bad_data, file.path.filename().string() + ": " + std::to_string(layout[0]) + " x " + std::to_string(layout[1]) + " pixels of " +
                                           std::to_string(layout[4]) + " components; the first slice, " + files.front().path.filename().string() + ", has " +
                                           std::to_string(first[0]) + " x " + std::to_string(first[1]) + " of " + std::to_string(first[4]) + ", or another type");
    names->InsertNextValue(file.path.string());
  }
  if (first[2] != 1) throw Error(ErrorCode::unsupported, name + ": slices of " + std::to_string(first[2]) + " pages each; expected one page");
  const auto reader = reader_of(files.front().path);
  reader->SetFileNames(names);
  Imported imported = run_reader(reader, request);
  imported.notes.push_back(std::to_string(files.size()) + " pictures as slices along z, 1 apart as pixels are");
  return imported;
}

}  // namespace isostrata
