#include "data/values/array_units.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace isostrata {
namespace {

TEST(ArrayUnits, ANoteSaysTheUnitOfItsArrayAlone) {
  std::vector<std::string> notes{"12 triangles skipped"};
  note_unit(notes, "wind", "m s-1");
  note_unit(notes, "it's", "K");
  note_unit(notes, "none", "");
  EXPECT_EQ(notes.size(), 3u);
  EXPECT_EQ(unit_of(notes, "wind"), "m s-1");
  EXPECT_EQ(unit_of(notes, "it's"), "K");
  for (const char* array : {"none", "win", "wind'", "it", ""}) EXPECT_EQ(unit_of(notes, array), "") << array;
  EXPECT_EQ(name_with_unit(notes, "wind"), "wind (m s-1)");
  EXPECT_EQ(name_with_unit(notes, "none"), "none");
}

}  // namespace
}  // namespace isostrata
