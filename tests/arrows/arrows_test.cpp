#include "arrows/arrows.h"
#include "support/places.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <stdexcept>

namespace isostrata {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::IsEmpty;

// A tree of made-up sources in a folder of its own, gone at the end.
class Arrows : public testing::Test {
 protected:
  Arrows() {
    fs::create_directories(root_ / "server");
    write("server/base/vec.h", "#pragma once\n#include <vector>\n");
  }
  ~Arrows() override { fs::remove_all(root_); }

  void write(const std::string& path, const std::string& text) {
    fs::create_directories((root_ / path).parent_path());
    std::ofstream(root_ / path) << text;
  }

  const fs::path root_ = fs::temp_directory_path() / ("isostrata-arrows-" + std::to_string(getpid()));
};

TEST(ArrowsOfThisRepository, AllPointOneWay) { EXPECT_THAT(broken_arrows(isostrata::places::source()), IsEmpty()); }

TEST_F(Arrows, EveryPairOfRoomsIsAllowedOneWayOnly) {
  const auto& order = rooms();
  std::vector<std::string> expected;
  for (std::size_t from = 0; from < order.size(); ++from)
    for (std::size_t to = 0; to < order.size(); ++to) {
      const std::string file = "server/" + order[from] + "/includes_" + order[to] + ".cpp";
      const std::string header = order[to] + "/door.h";
      write(file, "#include \"" + header + "\"\n");
      if (to > from) expected.push_back(file + ":1: " + order[from] + " may not include " + order[to] + ": " + header);
    }
  std::sort(expected.begin(), expected.end());
  EXPECT_EQ(broken_arrows(root_), expected);
}

TEST_F(Arrows, TheFoldersOfARoomPointOneWayToo) {
  write("server/data/CMakeLists.txt", "isostrata_room(data FOLDERS grid\n  readers doors PUBLIC isostrata_base)\n");
  write("server/data/grid/grid.h", "#include \"base/vec.h\"\n");
  write("server/data/readers/read.h", "#include \"data/grid/grid.h\"\n");
  write("server/data/doors/open.cpp", "#include \"data/readers/read.h\"\n#include \"data/doors/open.h\"\n");
  EXPECT_THAT(broken_arrows(root_), IsEmpty());
  write("server/data/grid/back.cpp", "#include \"data/grid/grid.h\"\n#include \"data/doors/open.h\"\n");
  EXPECT_THAT(broken_arrows(root_),
              ElementsAre("server/data/grid/back.cpp:2: data/grid may not include data/doors: data/doors/open.h"));
}

TEST_F(Arrows, TheFoldersOfTheImporterDoAsWell) {
  write("server/import/CMakeLists.txt", "set(FOLDERS bytes hdf5)\n");
  write("server/import/hdf5/read.h", "#include \"import/bytes/number.h\"\n");
  write("server/import/bytes/number.h", "#include \"import/hdf5/read.h\"\n");
  EXPECT_THAT(broken_arrows(root_),
              ElementsAre("server/import/bytes/number.h:1: import/bytes may not include import/hdf5: import/hdf5/read.h"));
}

TEST_F(Arrows, ARoomWithFoldersHasNothingBesideThem) {
  write("server/data/CMakeLists.txt", "isostrata_room(data FOLDERS grid readers)\n");
  write("server/data/grid/grid.h", "#pragma once\n");
  write("server/data/loose.cpp", "\n");
  write("server/data/attic/old.cpp", "\n");
  EXPECT_THAT(broken_arrows(root_), ElementsAre("server/data/CMakeLists.txt: FOLDERS names readers, which has no source",
                                                "server/data/attic: is not among the FOLDERS of the room's CMakeLists.txt",
                                                "server/data/loose.cpp: is in none of the room's folders"));
}

TEST_F(Arrows, AnIncludeIsFoundHoweverItIsSpaced) {
  write("server/base/back.cpp", "// why\n\n  #  include   \"net/listener.h\"  // never\n");
  EXPECT_THAT(broken_arrows(root_), ElementsAre("server/base/back.cpp:3: base may not include net: net/listener.h"));
}

TEST_F(Arrows, CommentsAndLibrariesAreNoIncludes) {
  write("server/base/fine.cpp",
        "// #include \"net/listener.h\"\n#include <net/if.h>\n#include \"vec.h\"\n#include \"base/vec.h\"\n");
  EXPECT_THAT(broken_arrows(root_), IsEmpty());
}

TEST_F(Arrows, AngleBracketsDoNotHideARoom) {
  write("server/net/listener.h", "#pragma once\n");
  write("server/base/back.cpp", "#include <net/if.h>\n#include <net/listener.h>\n");
  EXPECT_THAT(broken_arrows(root_), ElementsAre("server/base/back.cpp:2: base may not include net: net/listener.h"));
}

TEST_F(Arrows, AShaderIsASourceToo) {
  write("server/extraction/cells.glsl", "#include \"rendering/camera.h\"\n");
  EXPECT_THAT(broken_arrows(root_),
              ElementsAre("server/extraction/cells.glsl:1: extraction may not include rendering: rendering/camera.h"));
}

TEST_F(Arrows, TheClientKnowsTheProtocolAndNoRoom) {
  write("client/client.cpp", "#include \"client/client.h\"\n#include \"isostrata/v1/isostrata.pb.h\"\n#include \"base/vec.h\"\n");
  EXPECT_THAT(broken_arrows(root_), ElementsAre("client/client.cpp:3: client may not include base: base/vec.h"));
}

TEST_F(Arrows, TheServerDoesNotKnowTheClient) {
  write("server/main/a.cpp", "#include \"client/client.h\"\n");
  write("server/main/b.cpp", "#include <isostrata/client.h>\n");
  EXPECT_THAT(broken_arrows(root_), ElementsAre("server/main/a.cpp:1: main may not include the client: client/client.h",
                                                "server/main/b.cpp:1: main may not include the client: isostrata/client.h"));
}

TEST_F(Arrows, ProtobufStopsAtSession) {
  write("server/engine/scene.cpp", "#include \"isostrata/v1/isostrata.pb.h\"\n");
  write("server/session/commands/apply_command.cpp", "#include \"isostrata/v1/isostrata.pb.h\"\n");
  EXPECT_THAT(broken_arrows(root_),
              ElementsAre("server/engine/scene.cpp:1: Protobuf left of session: isostrata/v1/isostrata.pb.h"));
}

TEST_F(Arrows, TheImportChildReachesDataAndNoFurther) {
  write("server/import/main.cpp",
        "#include \"data/grid.h\"\n#include \"import/limits.h\"\n#include \"extraction/mesh/interval_mesh.h\"\n");
  EXPECT_THAT(broken_arrows(root_),
              ElementsAre("server/import/main.cpp:3: import may not include extraction: extraction/mesh/interval_mesh.h"));
}

TEST_F(Arrows, AnUnknownRoomIsRefused) {
  write("server/core/thing.h", "#pragma once\n");
  write("server/main/main.cpp", "#include \"core/thing.h\"\n");
  EXPECT_THAT(broken_arrows(root_), ElementsAre("server/core: is not a room", "server/main/main.cpp:1: no such room: core/thing.h"));
}

TEST_F(Arrows, NamesThatSayNothingAreRefused) {
  for (const char* name : {"util", "string_utils", "common", "helpers", "session_manager", "misc"})
    write(std::string("server/base/") + name + ".h", "#pragma once\n");
  write("server/base/utility_cart.h", "#pragma once\n");
  EXPECT_EQ(broken_arrows(root_).size(), 6u);
}

TEST_F(Arrows, ATypeHasItsNameForItself) {
  write("server/net/a.h", "namespace isostrata {\nstruct Tile;\nstruct Tile {\n  struct Entry {};\n};\n}\n");
  write("server/net/b.h", "namespace isostrata {\nclass Tile final : public Base {\n};\n}\n");
  write("client/c.h", "namespace isostrata::client {\nclass Tile {\n};\nstruct Entry {};\n}\n");
  EXPECT_THAT(broken_arrows(root_), ElementsAre("server/net/b.h:2: isostrata::Tile has this name in server/net/a.h, too"));
}

TEST_F(Arrows, TheWireFormatIsProto3) {
  write("protocol/new.proto", "syntax = \"proto3\";\n");
  write("protocol/old.proto", "// syntax = \"proto3\" would be better\nsyntax = \"proto2\";\n");
  EXPECT_THAT(broken_arrows(root_), ElementsAre("protocol/old.proto: is not proto3"));
}

TEST(ArrowsOfNothing, AFolderWithoutSourcesIsAnErrorNotASuccess) {
  EXPECT_THROW(broken_arrows(fs::temp_directory_path() / "isostrata-no-such-folder"), std::runtime_error);
}

}  // namespace
}  // namespace isostrata
