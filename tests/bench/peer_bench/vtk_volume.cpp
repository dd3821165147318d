#include "vtk_volume.h"

#include <vtkCamera.h>
#include <vtkCellArray.h>
#include <vtkCellType.h>
#include <vtkColorTransferFunction.h>
#include <vtkDoubleArray.h>
#include <vtkFloatArray.h>
#include <vtkGenericOpenGLRenderWindow.h>
#include <vtkNew.h>
#include <vtkPiecewiseFunction.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkProjectedTetrahedraMapper.h>
#include <vtkRenderer.h>
#include <vtkTypeInt64Array.h>
#include <vtkUnsignedCharArray.h>
#include <vtkUnstructuredGrid.h>
#include <vtkUnstructuredGridVolumeRayCastMapper.h>
#include <vtkUnstructuredGridVolumeZSweepMapper.h>
#include <vtkVolume.h>
#include <vtkVolumeProperty.h>

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "rendering/gl/gl_context.h"

namespace isostrata::peers {
namespace {

vtkSmartPointer<vtkUnstructuredGrid> copy_mesh(const DrawInput& input) {
  const IntervalMesh& mesh = *input.mesh;
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  points->SetNumberOfPoints(static_cast<vtkIdType>(mesh.positions.size()));
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) points->SetPoint(static_cast<vtkIdType>(i), &mesh.positions[i].x);
  vtkNew<vtkTypeInt64Array> offsets, corners;
  offsets->SetNumberOfValues(static_cast<vtkIdType>(mesh.tetrahedra.size() + 1));
  corners->SetNumberOfValues(static_cast<vtkIdType>(mesh.tetrahedra.size() * 4));
  for (std::size_t t = 0; t <= mesh.tetrahedra.size(); ++t)
    offsets->SetValue(static_cast<vtkIdType>(t), static_cast<vtkIdType>(4 * t));
  for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t)
    for (std::size_t v = 0; v < 4; ++v) corners->SetValue(static_cast<vtkIdType>(4 * t + v), mesh.tetrahedra[t][v]);
  vtkNew<vtkCellArray> cells;
  cells->SetData(offsets, corners);
  vtkNew<vtkFloatArray> scalars;  // all 0 if the colour is constant
  scalars->SetName("scalars");
  scalars->SetNumberOfValues(points->GetNumberOfPoints());
  for (std::size_t i = 0; i < mesh.positions.size(); ++i)
    scalars->SetValue(static_cast<vtkIdType>(i), input.color_values ? (*input.color_values)[i] : 0.0f);
  auto grid = vtkSmartPointer<vtkUnstructuredGrid>::New();
  grid->SetPoints(points);
  grid->SetCells(VTK_TETRA, cells);
  grid->GetPointData()->SetScalars(scalars);
  return grid;
}

/// Of VTK's three mappers each takes the opacity for the extinction per unit distance, so our extinction is what they are told.
void set_style(vtkVolumeProperty& property, const DrawInput& input) {
  const IntervalStyle& style = input.styles.front();
  const double unit = input.unit_distance > 0 ? input.unit_distance : default_unit_distance(input.bounds.diagonal());
  vtkNew<vtkColorTransferFunction> color;
  vtkNew<vtkPiecewiseFunction> opacity;
  const double lower = style.constant() ? 0 : style.color_lower, upper = style.constant() ? 1 : style.color_upper;
  if (style.constant()) {
    for (const double at : {lower, upper}) color->AddRGBPoint(at, style.color[0], style.color[1], style.color[2]);
  } else {
    const std::vector<Rgb>& rgb = color_map(style.color_map).rgb;
    for (std::size_t i = 0; i < rgb.size(); ++i)
      color->AddRGBPoint(lower + (upper - lower) * static_cast<double>(i) / static_cast<double>(rgb.size() - 1), rgb[i][0],
                         rgb[i][1], rgb[i][2]);
  }
  for (const double at : {lower, upper}) opacity->AddPoint(at, extinction(style.opacity, unit) * unit);
  property.SetColor(color);
  property.SetScalarOpacity(opacity);
  property.SetScalarOpacityUnitDistance(unit);
  property.SetInterpolationTypeToLinear();
  property.ShadeOff();
}

vtkSmartPointer<vtkUnstructuredGridVolumeMapper> make_mapper(VtkMapper which, int threads) {
  if (which == VtkMapper::projected_tetrahedra)
    return vtkSmartPointer<vtkUnstructuredGridVolumeMapper>(vtkSmartPointer<vtkProjectedTetrahedraMapper>::New());
  if (which == VtkMapper::zsweep) {
    auto mapper = vtkSmartPointer<vtkUnstructuredGridVolumeZSweepMapper>::New();
    mapper->AutoAdjustSampleDistancesOff();
    mapper->SetImageSampleDistance(1);
    return mapper;
  }
  auto mapper = vtkSmartPointer<vtkUnstructuredGridVolumeRayCastMapper>::New();
  mapper->AutoAdjustSampleDistancesOff();
  mapper->SetImageSampleDistance(1);
  mapper->IntermixIntersectingGeometryOff();
  mapper->SetNumberOfThreads(threads);
  return mapper;
}

}  // namespace

const char* name_of(VtkMapper mapper) {
  switch (mapper) {
    case VtkMapper::projected_tetrahedra:
      return "projected tetrahedra";
    case VtkMapper::bunyk_ray_cast:
      return "Bunyk ray cast";
    case VtkMapper::zsweep:
      return "ZSweep";
  }
  return "";
}

struct VtkVolume::Scene {
  std::unique_ptr<GlContext> context;
  int width = 0, height = 0;
  vtkNew<vtkGenericOpenGLRenderWindow> window;
  vtkNew<vtkRenderer> renderer;
  vtkNew<vtkVolume> volume;
};

VtkVolume::VtkVolume(VtkMapper mapper, const DrawInput& input, int threads) : scene_(std::make_unique<Scene>()) {
  Scene& scene = *scene_;
  scene.context = open_context("surfaceless");
  scene.context->make_current();
  scene.width = input.width;
  scene.height = input.height;
  scene.window->SetSize(input.width, input.height);
  scene.window->SetOffScreenRendering(1);
  scene.window->SetMultiSamples(0);
  scene.window->SetReadyForRendering(true);
  scene.window->SetSupportsOpenGL(true);
  scene.window->SetIsCurrent(true);
  if (!scene.window->InitializeFromCurrentContext())
    throw Error(ErrorCode::unavailable, "VTK cannot draw in an EGL surfaceless context: " + scene.context->device());
  scene.window->AddRenderer(scene.renderer);
  scene.renderer->SetBackground(input.background[0], input.background[1], input.background[2]);
  const auto with = make_mapper(mapper, threads);
  with->SetInputData(copy_mesh(input));
  set_style(*scene.volume->GetProperty(), input);
  scene.volume->SetMapper(with);
  scene.renderer->AddVolume(scene.volume);
}

VtkVolume::~VtkVolume() {
  scene_->context->make_current();
  scene_->window->RemoveRenderer(scene_->renderer);
  scene_->window->Finalize();
}

const std::string& VtkVolume::device() const { return scene_->context->device(); }

Image VtkVolume::draw(const Camera& from) {
  scene_->context->make_current();
  vtkCamera* const camera = scene_->renderer->GetActiveCamera();
  camera->SetPosition(from.eye.x, from.eye.y, from.eye.z);
  camera->SetFocalPoint(from.at.x, from.at.y, from.at.z);
  camera->SetViewUp(from.up.x, from.up.y, from.up.z);
  camera->SetViewAngle(from.fov_deg);
  scene_->renderer->ResetCameraClippingRange();
  scene_->window->Render();
  vtkNew<vtkUnsignedCharArray> pixels;
  scene_->window->GetRGBACharPixelData(0, 0, scene_->width - 1, scene_->height - 1, 0, pixels);
  Image image{scene_->width, scene_->height, {}};
  const auto row = static_cast<std::size_t>(scene_->width) * 4;
  image.rgba.resize(row * static_cast<std::size_t>(scene_->height));
  for (int y = 0; y < scene_->height; ++y)  // VTK's first row is the lowest
    std::copy_n(pixels->GetPointer(0) + row * static_cast<std::size_t>(scene_->height - 1 - y), row,
                image.rgba.begin() + static_cast<std::ptrdiff_t>(row * static_cast<std::size_t>(y)));
  return image;
}

}  // namespace isostrata::peers
