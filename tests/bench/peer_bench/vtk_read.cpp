#include "vtk_read.h"

#include <vtkCellData.h>
#include <vtkCompositeDataIterator.h>
#include <vtkCompositeDataSet.h>
#include <vtkDataArray.h>
#include <vtkDataSet.h>
#include <vtkDataSetReader.h>
#include <vtkExodusIIReader.h>
#include <vtkMetaImageReader.h>
#include <vtkNIFTIImageReader.h>
#include <vtkNew.h>
#include <vtkNrrdReader.h>
#include <vtkPointData.h>
#include <vtkSmartPointer.h>
#include <vtkXMLGenericDataObjectReader.h>

#include <cstdint>
#include <filesystem>
#include <utility>

#include "base/error.h"

namespace isostrata::peers {
namespace {

std::int64_t look_at(vtkDataSetAttributes* attributes) {
  std::int64_t values = 0;
  for (int i = 0; i < attributes->GetNumberOfArrays(); ++i)
    if (vtkDataArray* array = attributes->GetArray(i)) {
      double range[2];
      array->GetRange(range, array->GetNumberOfComponents() > 1 ? -1 : 0);
      values += array->GetNumberOfValues();
    }
  return values;
}

std::int64_t look_at(vtkDataObject* output) {
  if (auto* dataset = vtkDataSet::SafeDownCast(output)) return look_at(dataset->GetPointData()) + look_at(dataset->GetCellData());
  std::int64_t values = 0;
  if (auto* blocks = vtkCompositeDataSet::SafeDownCast(output)) {
    const auto each = vtkSmartPointer<vtkCompositeDataIterator>::Take(blocks->NewIterator());
    for (each->InitTraversal(); !each->IsDoneWithTraversal(); each->GoToNextItem()) values += look_at(each->GetCurrentDataObject());
  }
  return values;
}

template <class Reader>
vtkSmartPointer<vtkDataObject> read(const std::string& file) {
  vtkNew<Reader> reader;
  reader->SetFileName(file.c_str());
  if constexpr (requires { reader->SetAllArrayStatus(vtkExodusIIReader::NODAL, 1); }) {
    reader->UpdateInformation();
    for (const int kind : {vtkExodusIIReader::NODAL, vtkExodusIIReader::ELEM_BLOCK}) reader->SetAllArrayStatus(kind, 1);
  }
  if constexpr (requires { reader->ReadAllScalarsOn(); }) {
    reader->ReadAllScalarsOn();
    reader->ReadAllVectorsOn();
    reader->ReadAllFieldsOn();
  }
  reader->Update();
  return reader->GetOutputDataObject(0);
}

}  // namespace

std::shared_ptr<void> read_by_vtk(const std::string& file) {
  const std::string ending = std::filesystem::path(file).extension().string();
  const auto is_one_of = [&](std::initializer_list<const char*> endings) {
    for (const char* of : endings)
      if (ending == of) return true;
    return false;
  };
  vtkSmartPointer<vtkDataObject> data;
  if (is_one_of({".vti", ".vtr", ".vts", ".vtu"}))
    data = read<vtkXMLGenericDataObjectReader>(file);
  else if (ending == ".vtk")
    data = read<vtkDataSetReader>(file);
  else if (is_one_of({".mhd", ".mha"}))
    data = read<vtkMetaImageReader>(file);
  else if (is_one_of({".nrrd", ".nhdr"}))
    data = read<vtkNrrdReader>(file);
  else if (is_one_of({".nii", ".gz"}))
    data = read<vtkNIFTIImageReader>(file);
  else if (is_one_of({".e", ".ex2", ".exo"}))
    data = read<vtkExodusIIReader>(file);
  else
    throw Error(ErrorCode::unsupported, file + ": no reader of VTK's is measured for '" + ending +
                                            "'; expected .vti, .vtr, .vts, .vtu, .vtk, .mhd, .mha, .nrrd, .nhdr, .nii, .nii.gz, .e, .ex2 or .exo");
  if (!data || look_at(data) == 0) throw Error(ErrorCode::bad_data, file + ": VTK read no values");
  return std::make_shared<vtkSmartPointer<vtkDataObject>>(std::move(data));
}

}  // namespace isostrata::peers
