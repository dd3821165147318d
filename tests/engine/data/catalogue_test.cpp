#include "engine/data/catalogue.h"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <fstream>
#include <map>
#include <set>

#include "base/error.h"
#include "support/temporary_folder.h"

namespace isostrata {
namespace {

namespace fs = std::filesystem;

class CatalogueFiles : public ::testing::Test {
 protected:
  CatalogueFiles() {
    for (const char* file : {"data/a.vtk", "data/deep/a.vtk", "data/finxyz.bin", "data/finq.bin", "data/notes.txt",
                             "data/.hidden.vtk", "outside.vtk"})
      root_.write(file, "x");
    fs::create_symlink(root_ / "outside.vtk", root_ / "data" / "link.vtk");
  }
  testing::TemporaryFolder root_;
};

TEST(CatalogueIds, NameAPartAndAVersionOfIt) {
  Region part;
  set_box(part, "0:31,:,5:");
  set_stride(part, "2");
  const std::string id = part_id("head-3f2a91", part);
  EXPECT_EQ(id, "head-3f2a91@:31,:,5:*2");
  for (const std::string& text : {id, part_id("head-3f2a91~2", part)}) {
    EXPECT_EQ(part_of_id(text), part) << text;
    EXPECT_EQ(plain_id(text), id);
    EXPECT_EQ(whole_id(plain_id(text)), "head-3f2a91");
  }
  EXPECT_EQ(part_id("head-3f2a91~2", part), id + "~2");
  EXPECT_EQ(whole_id(id + "~2"), "head-3f2a91~2");
  EXPECT_EQ(with_part_of(id, "head-3f2a91~7"), id + "~7");
  EXPECT_EQ(with_part_of("head-3f2a91", "head-3f2a91~7"), "head-3f2a91~7");
  EXPECT_EQ(part_of_id("head-3f2a91~2"), Region{});
  EXPECT_EQ(part_id(id, Region{}), "head-3f2a91");
  EXPECT_EQ(part_name("head.nii", part), "head.nii, points :31,:,5: by 2");
  for (const char* wrong : {"head@", "head@1", "head@:,:,:*0", "head@9:3,:,:"}) EXPECT_THROW(part_of_id(wrong), Error) << wrong;
}

TEST_F(CatalogueFiles, BlocksThatAFileListsAreNoSteps) {
  const auto listed = [](const std::string& kind, const std::string& inside) {
    return "<?xml version=\"1.0\"?>\n<VTKFile type=\"" + kind + "\" version=\"1.0\"><" + kind + ">" + inside + "</" + kind + "></VTKFile>\n";
  };
  root_.write("more/parts.vtm", listed("vtkMultiBlockDataSet", "<DataSet index=\"0\" file=\"p.vti\"/><DataSet index=\"1\" file=\"q.vti\"/>"));
  root_.write("more/time.pvd", listed("Collection", "<DataSet timestep=\"0\" file=\"r.vti\"/><DataSet timestep=\"1\" file=\"s.vti\"/>"));
  for (const char* name : {"p", "q", "r", "s"}) root_.write("more/" + std::string(name) + ".vti", listed("ImageData", ""));
  const auto catalogue = Catalogue::from_sources({(root_ / "more").string()});
  std::map<std::string, bool> one_step;
  for (const CatalogueEntry& entry : catalogue.entries()) {
    one_step[entry.name] = entry.one_step;
    EXPECT_EQ(entry.parts, 2) << entry.name;
  }
  EXPECT_EQ(one_step, (std::map<std::string, bool>{{"parts.vtm", true}, {"time.pvd", false}}));
}

TEST_F(CatalogueFiles, TheNumbersOfASeriesAreKnownWhetherItIsNamedOrFound) {
  for (const char* name : {"wave_0010", "wave_0020", "wave_0030"}) root_.write("more/" + std::string(name) + ".vtk", "# vtk DataFile Version 3.0\n");
  for (const std::string& source : {(root_ / "more").string(), (root_ / "more/wave_*.vtk").string()}) {
    const Catalogue catalogue = Catalogue::from_sources({source});
    ASSERT_EQ(catalogue.entries().size(), 1u) << source;
    const CatalogueEntry& entry = catalogue.entries().front();
    EXPECT_EQ(entry.numbers.place_of(30, entry.files), 2) << source;
    EXPECT_EQ(entry.numbers.place_of(15, entry.files), -1) << source;
    EXPECT_EQ(entry.numbers.digits, 4) << source;
  }
}

TEST_F(CatalogueFiles, ADirectoryOffersWhatCanBeReadInsideItself) {
  const auto catalogue = Catalogue::from_sources({(root_ / "data").string()});
  std::set<std::string> names, ids;
  for (const auto& entry : catalogue.entries()) {
    names.insert(entry.name);
    ids.insert(entry.id);
    EXPECT_EQ(entry.id.find('/'), std::string::npos) << entry.id;
    EXPECT_EQ(catalogue.find(entry.id), &entry);
  }
  EXPECT_EQ(names, (std::set<std::string>{"a.vtk", "deep/a.vtk", "finxyz.bin"}));
  EXPECT_EQ(ids.size(), 3u);
}

TEST_F(CatalogueFiles, IdsAreTheSameInTheNextServer) {
  const auto one = Catalogue::from_sources({(root_ / "data").string()});
  const auto two = Catalogue::from_sources({"torus:8", (root_ / "data" / "deep" / "a.vtk").string()});
  EXPECT_EQ(two.find("torus-8")->source, "torus:8");
  EXPECT_EQ(two.entries()[1].name, "a.vtk");
  EXPECT_EQ(one.entries().size(), 3u);
  EXPECT_EQ(Catalogue::from_sources({(root_ / "data").string()}).entries()[1].id, one.entries()[1].id);
}

TEST_F(CatalogueFiles, LinksInCirclesPipesAndDirectoriesWithTheNameOfAFileAreLeftOut) {
  const fs::path data = root_ / "data";
  fs::create_directory_symlink(data, data / "deep" / "again");
  fs::create_symlink("circle.vtk", data / "circle.vtk");
  fs::create_symlink("nowhere.vtk", data / "dangling.vtk");
  fs::create_directories(data / "folder.vtk");
  ASSERT_EQ(mkfifo((data / "pipe.vtk").c_str(), 0600), 0);
  EXPECT_EQ(Catalogue::from_sources({data.string()}).entries().size(), 3u);
  EXPECT_THROW(Catalogue::from_sources({(data / "circle.vtk").string()}), Error);
}

TEST_F(CatalogueFiles, NumberedFilesAreOneEntryAndWhatIsPassedOverIsCounted) {
  for (const char* file : {"data/s_1.vti", "data/s_2.vti", "data/s_3.vti"}) root_.write(file, "x");
  const auto catalogue = Catalogue::from_sources({(root_ / "data").string(), (root_ / "data" / "s_*.vti").string()});
  ASSERT_EQ(catalogue.entries().size(), 4u);
  const CatalogueEntry& series = catalogue.entries().back();
  EXPECT_EQ(series.name, "s_*.vti");
  EXPECT_EQ(series.files, 3);
  EXPECT_EQ(series.bytes, 3u);
  EXPECT_EQ(series.kind, "XML VTK");
  std::int64_t passed_over = 0;
  for (const PassedOver& passed : catalogue.passed_over()) passed_over += passed.files;
  EXPECT_EQ(passed_over, 4);  // the solution, the notes, what is hidden, the link
}

TEST_F(CatalogueFiles, WhatIsNotThereIsNamed) {
  try {
    Catalogue::from_sources({(root_ / "nosuch.vtk").string()});
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::not_found);
    EXPECT_NE(std::string(error.what()).find("nosuch.vtk"), std::string::npos);
  }
  EXPECT_EQ(Catalogue::analytic().find("nosuch"), nullptr);
}

}  // namespace
}  // namespace isostrata
