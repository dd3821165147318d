// A program that the dynamic loader was started with (`ld.so PROGRAM`), as the download does, finds what lies beside it and starts it alike.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <link.h>

#include <boost/json.hpp>
#include <fstream>
#include <string>

#include "support/places.h"
#include "support/run_isostrata.h"

namespace {

using namespace isostrata::testing;
using ::testing::HasSubstr;

/// The file of this machine's loader: it is in every program's list of what is loaded.
std::string loader() {
  std::string found;
  dl_iterate_phdr(
      [](dl_phdr_info* info, std::size_t, void* out) {
        const std::string name = info->dlpi_name;
        if (name.find("/ld-") != std::string::npos || name.find("/ld64") != std::string::npos) *static_cast<std::string*>(out) = name;
        return 0;
      },
      &found);
  return found;
}

CommandResult run_by_loader(const std::string& arguments) { return run_isostrata(arguments, loader()); }

TEST(LoaderStart, TheWorkerAndTheImporterAreFoundAndStarted) {
  ASSERT_FALSE(loader().empty());
  const CommandResult result = run_by_loader("doctor --json");
  ASSERT_EQ(result.status, 0) << result.err;
  const auto document = boost::json::parse(result.out);
  EXPECT_TRUE(document.at("worker").at("ok").as_bool()) << document.at("worker");
  EXPECT_TRUE(document.at("importer").at("found").as_bool());
  EXPECT_EQ(document.at("importer").at("path").as_string(), isostrata::places::binaries() + "/isostrata-import");
}

TEST(LoaderStart, AForeignFileIsReadInTheSandbox) {
  const TemporaryFolder folder;
  const auto file = folder / "a field.vtk";
  std::ofstream(file) << "# vtk DataFile Version 3.0\nt\nASCII\nDATASET STRUCTURED_POINTS\nDIMENSIONS 2 2 2\nORIGIN 0 0 0\nSPACING 1 1 1\n"
                         "POINT_DATA 8\nSCALARS f float 1\nLOOKUP_TABLE default\n0 1 2 3 4 5 6 7\n";
  const CommandResult result = run_by_loader("info --json --sandbox require '" + file.string() + "'");
  ASSERT_EQ(result.status, 0) << result.err;
  EXPECT_EQ(boost::json::parse(result.out).at("points").to_number<int>(), 8);
}

}  // namespace
