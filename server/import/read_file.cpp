#include "import/read_file.h"

#include "import/read_nrrd.h"
#include "import/read_plot3d.h"
#include "import/read_vtk.h"
#include "import/recognise.h"

namespace isostrata {

Imported read_file(const ReadRequest& request) {
  const Recognised recognised = recognise(request.file);
  switch (recognised.kind) {
    case FileKind::vtk_legacy:
      return read_vtk_legacy(request);
    case FileKind::vtk_xml:
      return read_vtk_xml(request, recognised.vtk_type);
    case FileKind::pvd:
      return read_pvd(request);
    case FileKind::nrrd:
      return read_nrrd(request);
    case FileKind::plot3d:
      return read_plot3d(request);
    case FileKind::exodus:
      return read_exodus(request);
    case FileKind::meta_image:
      return read_meta_image(request);
    case FileKind::slc:
      return read_slc(request);
  }
  throw Error(ErrorCode::internal, "a kind of file without a reader");
}

}  // namespace isostrata
