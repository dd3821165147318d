// Pieces of one grid: what several files have of one point is one point.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>

#include "data/files.h"
#include "support/vtk_text.h"

namespace isostrata {
namespace {

using test::Scratch;
using testing::VtuText;

double linear(const Vec3d& p) { return 1 + 2 * p.x - 3 * p.y + 0.5 * p.z; }

/// Unit cubes [from, to) of a bar along x, two cubes wide, with a point array and a cell array.
VtuText bar(int from, int to, const std::function<double(const Vec3d&)>& value = linear) {
  VtuText vtu;
  const int n = to - from + 1;
  std::vector<double> values, numbers;
  for (int k = 0; k < 2; ++k)
    for (int j = 0; j < 3; ++j)
      for (int i = from; i <= to; ++i) {
        vtu.points.push_back({i / 3.0, j / 7.0, k / 11.0});
        values.push_back(value(vtu.points.back()));
      }
  for (int j = 0; j < 2; ++j)
    for (int i = 0; i < n - 1; ++i) {
      const auto id = [&](int a, int b, int c) { return std::int64_t{i + a + n * (j + b + 3 * c)}; };
      vtu.add(12, {id(0, 0, 0), id(1, 0, 0), id(1, 1, 0), id(0, 1, 0), id(0, 0, 1), id(1, 0, 1), id(1, 1, 1), id(0, 1, 1)});
      numbers.push_back(from + i + 100 * j);
    }
  vtu.point_array("f", "Float64", values);
  vtu.cell_array("number", "Float64", numbers);
  return vtu;
}

class Pieces : public ::testing::Test {
 protected:
  std::shared_ptr<const Dataset> open(const std::vector<std::string>& pieces, const std::string& more_on_cells = "") {
    std::string list;
    for (std::size_t i = 0; i < pieces.size(); ++i) {
      const std::string name = "p" + std::to_string(i) + ".vtu";
      scratch_.write(name, pieces[i]);
      list += "<Piece Source=\"" + name + "\"/>";
    }
    return test::open(scratch_.write(
        "all.pvtu", testing::vtk_file("PUnstructuredGrid",
                                      "<PUnstructuredGrid GhostLevel=\"0\"><PPointData><PDataArray type=\"Float64\" Name=\"f\"/></PPointData>"
                                      "<PCellData><PDataArray type=\"Float64\" Name=\"number\"/>" + more_on_cells + "</PCellData>"
                                      "<PPoints><PDataArray type=\"Float64\" NumberOfComponents=\"3\"/></PPoints>" +
                                          list + "</PUnstructuredGrid>\n")));
  }
  static bool says(const Dataset& data, const std::string& part) {
    return std::any_of(data.notes.begin(), data.notes.end(),
                       [&](const std::string& note) { return note.find(part) != std::string::npos; });
  }
  static std::map<std::array<double, 3>, std::size_t> points_by_place(const Dataset& data) {
    std::map<std::array<double, 3>, std::size_t> at;
    for (std::int64_t p = 0; p < data.grid.point_count(); ++p) {
      const Vec3d x = data.grid.point(p);
      at[{x.x, x.y, x.z}] = static_cast<std::size_t>(p);
    }
    return at;
  }
  /// How many faces no two visible cells share.
  static std::size_t open_faces(const Dataset& data) {
    std::map<std::vector<std::int64_t>, int> faces;
    std::array<std::int64_t, kMaxCellVertices> ids{};
    for (std::int64_t c = 0; c < data.grid.cell_count(); ++c) {
      if (data.grid.hidden(c)) continue;
      data.grid.cell_points(c, ids);
      for (const CellFace& face : topology(data.grid.cell_type(c)).faces) {
        std::vector<std::int64_t> key;
        for (int v = 0; v < face.size; ++v) key.push_back(ids[static_cast<std::size_t>(face.vertex[v])]);
        std::sort(key.begin(), key.end());
        ++faces[key];
      }
    }
    return static_cast<std::size_t>(std::count_if(faces.begin(), faces.end(), [](const auto& of) { return of.second == 1; }));
  }

  const Scratch scratch_;
};

TEST_F(Pieces, AreTheGridThatTheyArePiecesOf) {
  const auto whole = test::open(scratch_.write("whole.vtu", bar(0, 9).text()));
  const auto pieces = open({bar(0, 3).text(), bar(3, 4).text(), bar(4, 9).text()});
  EXPECT_EQ(pieces->grid.point_count(), whole->grid.point_count());
  EXPECT_EQ(pieces->grid.cell_count(), whole->grid.cell_count());
  EXPECT_EQ(open_faces(*pieces), open_faces(*whole));
  EXPECT_TRUE(says(*pieces, "12 points that 3 pieces share are one point each"));
  // Every point once, with its own value, and cells' values averaged over the pieces alike.
  auto at = points_by_place(*whole);
  for (std::int64_t p = 0; p < pieces->grid.point_count(); ++p) {
    const Vec3d x = pieces->grid.point(p);
    const auto same = at.extract({x.x, x.y, x.z});
    ASSERT_FALSE(same.empty()) << "a point twice";
    EXPECT_EQ(pieces->array("f").at(static_cast<std::size_t>(p)), linear(x));
    EXPECT_NEAR(pieces->array("number").at(static_cast<std::size_t>(p)), whole->array("number").at(same.mapped()), 1e-12);
  }
}

TEST_F(Pieces, MeetWhereTheirNumbersWereRoundedInTwoWays) {
  const auto whole = test::open(scratch_.write("whole.vtu", bar(0, 9).text()));
  VtuText right = bar(4, 9, [](const Vec3d& p) { return std::nextafter(linear(p), 100.0); });
  for (Vec3d& p : right.points) p = {std::nextafter(p.x, 100.0), std::nextafter(p.y, -100.0), std::nextafter(p.z, 100.0)};
  const auto pieces = open({bar(0, 4).text(), right.text()});
  EXPECT_EQ(pieces->grid.point_count(), whole->grid.point_count());
  EXPECT_EQ(open_faces(*pieces), open_faces(*whole));
  EXPECT_TRUE(says(*pieces, "6 points that 2 pieces share are one point each"));
}

TEST_F(Pieces, OfAMeshAsFineAsItsRoundingAreJoinedToTheLastBitOnly) {
  const auto fine = [](int from, int to) {
    VtuText vtu = bar(from, to);
    for (Vec3d& p : vtu.points) p = {1e6 + p.x * 1e-8, 1e6 + p.y * 1e-8, 1e6 + p.z * 1e-8};
    return vtu.text();
  };
  const auto whole = test::open(scratch_.write("whole.vtu", fine(0, 9)));
  const auto pieces = open({fine(0, 4), fine(4, 9)});
  EXPECT_EQ(pieces->grid.point_count(), whole->grid.point_count());
  EXPECT_EQ(open_faces(*pieces), open_faces(*whole));
}

TEST_F(Pieces, GhostCellsAreLeftOutWithTheirValues) {
  const auto whole = test::open(scratch_.write("whole.vtu", bar(0, 9).text()));
  const auto piece = [](int from, int to, int own_from, int own_to) {
    VtuText vtu = bar(from, to);
    std::vector<int> marks;
    for (int j = 0; j < 2; ++j)
      for (int i = from; i < to; ++i) marks.push_back(i < own_from || i >= own_to);
    vtu.cell_array("vtkGhostType", "UInt8", marks);
    return vtu.text();
  };
  const auto pieces = open({piece(0, 4, 0, 3), piece(2, 6, 3, 5), piece(4, 9, 5, 9)}, "<PDataArray type=\"UInt8\" Name=\"vtkGhostType\"/>");
  EXPECT_EQ(pieces->grid.cell_count(), whole->grid.cell_count());
  EXPECT_EQ(pieces->grid.point_count(), whole->grid.point_count());
  EXPECT_TRUE(pieces->grid.hidden_cells.empty());
  EXPECT_EQ(open_faces(*pieces), open_faces(*whole));
  EXPECT_TRUE(says(*pieces, "8 ghost cells left out"));
  const auto at = points_by_place(*whole);
  for (std::int64_t p = 0; p < pieces->grid.point_count(); ++p) {
    const Vec3d x = pieces->grid.point(p);
    EXPECT_NEAR(pieces->array("number").at(static_cast<std::size_t>(p)), whole->array("number").at(at.at({x.x, x.y, x.z})), 1e-12);  // ghosts count in no mean
  }
}

TEST_F(Pieces, StayApartWhereTheFieldJumps) {
  const auto jump = [](const Vec3d& p) { return linear(p) + (p.y > 0.2 ? 1 : 0); };  // at one of three rows of points
  const auto data = open({bar(0, 3).text(), bar(3, 6, jump).text()});
  EXPECT_TRUE(says(*data, "4 points that 2 pieces share"));
  EXPECT_TRUE(says(*data, "2 points of 2 pieces are at the places of others and stay apart"));
  EXPECT_EQ(open_faces(*data), open_faces(*test::open(scratch_.write("whole.vtu", bar(0, 6).text()))) + 2);
}

TEST_F(Pieces, ACrackWithinOnePieceStaysOpen) {
  VtuText cracked = bar(0, 2);
  const VtuText other = bar(2, 4);
  // The second half of one piece, with points of its own.
  const auto before = static_cast<std::int64_t>(cracked.points.size());
  for (std::size_t c = 0; c < other.types.size(); ++c) {
    std::vector<std::int64_t> ids(other.connectivity.begin() + static_cast<std::ptrdiff_t>(8 * c),
                                  other.connectivity.begin() + static_cast<std::ptrdiff_t>(8 * c + 8));
    for (auto& id : ids) id += before;
    cracked.add(12, ids);
  }
  cracked.points.insert(cracked.points.end(), other.points.begin(), other.points.end());
  cracked.point_arrays = cracked.cell_arrays = "";
  std::vector<double> values;
  for (const Vec3d& p : cracked.points) values.push_back(linear(p));
  cracked.point_array("f", "Float64", values);
  cracked.cell_array("number", "Float64", std::vector<double>(cracked.types.size(), 1));
  const auto data = open({cracked.text(), bar(4, 6).text()});
  EXPECT_EQ(open_faces(*data), open_faces(*test::open(scratch_.write("whole.vtu", bar(0, 6).text()))) + 4);
}

TEST_F(Pieces, ACellThatTwoPiecesHaveCountsOnce) {
  const auto data = open({bar(0, 4).text(), bar(3, 6).text()});
  EXPECT_EQ(std::count(data->grid.hidden_cells.begin(), data->grid.hidden_cells.end(), 1), 2);
  EXPECT_TRUE(says(*data, "2 cells hidden that another piece has as well"));
  EXPECT_EQ(open_faces(*data), open_faces(*test::open(scratch_.write("whole.vtu", bar(0, 6).text()))));
}

TEST_F(Pieces, WithoutPointsAreNothing) {
  VtuText empty;
  empty.point_array("f", "Float64", std::vector<double>{});
  empty.cell_array("number", "Float64", std::vector<double>{});
  const auto data = open({empty.text(), bar(0, 3).text(), empty.text(), bar(3, 5).text()});
  EXPECT_EQ(data->grid.cell_count(), 10);
  EXPECT_EQ(open_faces(*data), open_faces(*test::open(scratch_.write("whole.vtu", bar(0, 5).text()))));
}

TEST_F(Pieces, PartsOfACollectionMeetAlike) {
  scratch_.write("a.vtu", bar(0, 2).text());
  scratch_.write("b.vtu", bar(2, 5).text());
  const auto data = test::open(scratch_.write(
      "parts.pvd", testing::vtk_file("Collection", "<Collection><DataSet timestep=\"0\" part=\"0\" file=\"a.vtu\"/>"
                                                   "<DataSet timestep=\"0\" part=\"1\" file=\"b.vtu\"/></Collection>\n")));
  EXPECT_EQ(open_faces(*data), open_faces(*test::open(scratch_.write("whole.vtu", bar(0, 5).text()))));
}

}  // namespace
}  // namespace isostrata
