#include <vtkCellType.h>
#include <vtkIdList.h>
#include <vtkNew.h>
#include <vtkUnstructuredGrid.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "import/bytes/parsed_number.h"
#include "import/vtk/set_cells.h"
#include "import/xdmf/xdmf_grid.h"

namespace isostrata {
namespace {

/// Nodes are in VTK's order in all of them.
struct XdmfKind {
  std::string_view name;
  int number;  // in a Mixed topology
  int vtk_type;
  int nodes;  // 0: the file says how many
};

constexpr std::array kXdmfKinds{
    XdmfKind{"polyvertex", 1, VTK_POLY_VERTEX, 0},
    XdmfKind{"polyline", 2, VTK_POLY_LINE, 0},
    XdmfKind{"polygon", 3, VTK_POLYGON, 0},
    XdmfKind{"triangle", 4, VTK_TRIANGLE, 3},
    XdmfKind{"quadrilateral", 5, VTK_QUAD, 4},
    XdmfKind{"tetrahedron", 6, VTK_TETRA, 4},
    XdmfKind{"pyramid", 7, VTK_PYRAMID, 5},
    XdmfKind{"wedge", 8, VTK_WEDGE, 6},
    XdmfKind{"hexahedron", 9, VTK_HEXAHEDRON, 8},
    XdmfKind{"polyhedron", 16, VTK_POLYHEDRON, 0},
    XdmfKind{"edge_3", 34, VTK_QUADRATIC_EDGE, 3},
    XdmfKind{"quadrilateral_9", 35, VTK_BIQUADRATIC_QUAD, 9},
    XdmfKind{"triangle_6", 36, VTK_QUADRATIC_TRIANGLE, 6},
    XdmfKind{"quadrilateral_8", 37, VTK_QUADRATIC_QUAD, 8},
    XdmfKind{"tetrahedron_10", 38, VTK_QUADRATIC_TETRA, 10},
    XdmfKind{"pyramid_13", 39, VTK_QUADRATIC_PYRAMID, 13},
    XdmfKind{"wedge_15", 40, VTK_QUADRATIC_WEDGE, 15},
    XdmfKind{"wedge_18", 41, VTK_BIQUADRATIC_QUADRATIC_WEDGE, 18},
    XdmfKind{"hexahedron_20", 48, VTK_QUADRATIC_HEXAHEDRON, 20},
    XdmfKind{"hexahedron_24", 49, VTK_BIQUADRATIC_QUADRATIC_HEXAHEDRON, 24},
    XdmfKind{"hexahedron_27", 50, VTK_TRIQUADRATIC_HEXAHEDRON, 27},
};

/// Other names of the same.
std::string plain_xdmf_name(std::string name) {
  for (const auto& [other, own] : {std::pair<std::string_view, std::string_view>{"edge3", "edge_3"}, {"tri_6", "triangle_6"}, {"quad_8", "quadrilateral_8"}, {"quad_9", "quadrilateral_9"}, {"tet_10", "tetrahedron_10"},
                                   {"tri", "triangle"}, {"quad", "quadrilateral"}, {"tet", "tetrahedron"}, {"hex", "hexahedron"}, {"hex_20", "hexahedron_20"}, {"hex_24", "hexahedron_24"}, {"hex_27", "hexahedron_27"}})
    if (name == other) return std::string(own);
  return name;
}

/// XdmfCells one after the other, of one type or of several.
struct XdmfCells {
  std::vector<std::uint8_t> types;
  std::vector<std::int64_t> ends{0};
  std::vector<std::int64_t> ids;
};

/// A list of numbers: of each cell its type, how many nodes (or faces) it has if the type does not say it, and these.
class MixedCells {
 public:
  MixedCells(const std::vector<std::int64_t>& list, std::int64_t base, std::string name) : list_(list), base_(base), name_(std::move(name)) {}

  vtkSmartPointer<vtkUnstructuredGrid> run() {
    const auto grid = vtkSmartPointer<vtkUnstructuredGrid>::New();
    XdmfCells cells;
    bool polyhedra = false;
    while (at_ < list_.size()) {
      const std::int64_t number = list_[at_++];
      const auto kind = std::find_if(kXdmfKinds.begin(), kXdmfKinds.end(), [&](const XdmfKind& one) { return one.number == number; });
      if (kind == kXdmfKinds.end()) throw Error(ErrorCode::bad_data, name_ + ": cell " + std::to_string(cells.types.size()) + " has type " + std::to_string(number) + ", which is none of XDMF's");
      polyhedra = polyhedra || kind->vtk_type == VTK_POLYHEDRON;
      add(*kind, cells);
    }
    if (!polyhedra)
      set_cells(grid, cells.types, cells.ends, cells.ids);
    else
      insert(cells, grid);
    return grid;
  }

 private:
  void take(std::int64_t count, std::vector<std::int64_t>& to) {
    if (count < 0 || static_cast<std::uint64_t>(count) > list_.size() - at_)
      throw Error(ErrorCode::bad_data, name_ + ": the list of its cells ends within a cell: " + std::to_string(count) + " nodes or faces from place " + std::to_string(at_) + " of " + std::to_string(list_.size()));
    for (; count > 0; --count) to.push_back(list_[at_++] - base_);
  }
  std::int64_t number() {
    if (at_ == list_.size()) throw Error(ErrorCode::bad_data, name_ + ": the list of its cells ends within a cell");
    return list_[at_++];
  }
  void add(const XdmfKind& kind, XdmfCells& cells) {
    if (kind.vtk_type == VTK_POLYHEDRON) {  // as VTK's lists of faces have it
      const std::int64_t faces = number();
      cells.ids.push_back(faces);
      for (std::int64_t f = 0; f < faces; ++f) {
        cells.ids.push_back(number());
        take(cells.ids.back(), cells.ids);
      }
    } else {
      take(kind.nodes > 0 ? kind.nodes : number(), cells.ids);
    }
    cells.types.push_back(static_cast<std::uint8_t>(kind.vtk_type));
    cells.ends.push_back(static_cast<std::int64_t>(cells.ids.size()));
  }
  static void insert(const XdmfCells& cells, vtkUnstructuredGrid* grid) {
    grid->Allocate(static_cast<vtkIdType>(cells.types.size()));
    vtkNew<vtkIdList> ids;
    for (std::size_t c = 0; c < cells.types.size(); ++c) {
      ids->SetNumberOfIds(0);
      for (std::int64_t i = cells.ends[c]; i < cells.ends[c + 1]; ++i) ids->InsertNextId(cells.ids[static_cast<std::size_t>(i)]);
      grid->InsertNextCell(cells.types[c], ids);
    }
  }

  const std::vector<std::int64_t>& list_;
  const std::int64_t base_;
  const std::string name_;
  std::size_t at_ = 0;
};

}  // namespace

vtkSmartPointer<vtkUnstructuredGrid> xdmf_cells(const XdmfElement& topology, XdmfFile& file, XdmfValues& values, const ReadRequest& request) {
  const std::string name = topology.file->filename().string(), type = plain_xdmf_name(topology.word({"TopologyType", "Type"}));
  const auto kind = std::find_if(kXdmfKinds.begin(), kXdmfKinds.end(), [&](const XdmfKind& one) { return one.name == type; });
  if (type != "mixed" && (kind == kXdmfKinds.end() || kind->vtk_type == VTK_POLYHEDRON))
    throw Error(ErrorCode::unsupported, name + ": a topology of type '" + topology.attribute("TopologyType") + topology.attribute("Type") + "'; expected cells of XDMF's names, a mesh of one of its six structured types, or Mixed");
  if (!topology.attribute("Order").empty()) throw Error(ErrorCode::unsupported, name + ": a topology with an Order of its nodes; write them in XDMF's own order");
  const std::string offset = topology.attribute("BaseOffset");
  const auto base = offset.empty() ? std::optional<std::int64_t>(0) : parsed_number<std::int64_t>(offset);
  if (!base || *base < 0 || *base > 1) throw Error(ErrorCode::bad_data, name + ": BaseOffset '" + offset + "'; expected 0 or 1");
  const XdmfElement item = file.child(topology, "DataItem");
  if (!item) {
    if (type == "polyvertex") return vtkSmartPointer<vtkUnstructuredGrid>::New();  // points alone
    throw Error(ErrorCode::bad_data, name + ": a topology of type '" + type + "' without a DataItem that lists its cells");
  }
  const XdmfArray list = values.read(item);
  check_bytes(request, 24 * static_cast<std::uint64_t>(list.count()), name);
  std::vector<std::int64_t> ids = list.whole();
  if (type == "mixed") return MixedCells(ids, *base, name).run();
  std::int64_t nodes = kind->nodes;
  if (nodes == 0) {
    const auto said = parsed_number<std::int64_t>(topology.attribute("NodesPerElement"));
    nodes = said ? *said : list.shape.size() == 2 ? static_cast<std::int64_t>(list.shape[1]) : type == "polyvertex" ? 1 : 0;
  }
  if (nodes < 1 || ids.size() % static_cast<std::size_t>(nodes) != 0)
    throw Error(ErrorCode::bad_data, name + ": a topology of type '" + type + "' lists " + std::to_string(ids.size()) + " nodes; expected a multiple of " + std::to_string(nodes));
  XdmfCells cells;
  if (*base != 0)
    for (std::int64_t& id : ids) id -= *base;
  cells.types.assign(ids.size() / static_cast<std::size_t>(nodes), static_cast<std::uint8_t>(kind->vtk_type));
  cells.ends.resize(cells.types.size() + 1);
  for (std::size_t c = 0; c < cells.ends.size(); ++c) cells.ends[c] = static_cast<std::int64_t>(c) * nodes;
  cells.ids = std::move(ids);
  const auto grid = vtkSmartPointer<vtkUnstructuredGrid>::New();
  set_cells(grid, cells.types, cells.ends, cells.ids);
  return grid;
}

}  // namespace isostrata
