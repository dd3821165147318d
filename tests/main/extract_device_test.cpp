#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <boost/json.hpp>

#include "support/run_isostrata.h"

namespace {

using namespace isostrata::testing;
using ::testing::HasSubstr;
namespace json = boost::json;

// With EGL's vendor list empty and a driver that does not exist, neither EGL nor OSMesa makes a context.
constexpr const char* kNoDriver = "__EGL_VENDOR_LIBRARY_FILENAMES=/nonexistent.json MESA_GL_VERSION_OVERRIDE=3.0";

json::value extract_json(const std::string& arguments, const std::string& environment = "") {
  const CommandResult result = run_isostrata("extract " + arguments + " --json", environment);
  EXPECT_EQ(result.status, 0) << arguments << ": " << result.err;
  return result.status == 0 ? json::parse(result.out) : json::value();
}

TEST(ExtractDevice, ADeviceGivesWhatTheCpuGives) {
  for (const std::string data : {"torus:24 --interval 0.1:0.2 --interval 0.2:0.4", "cylinder:12x8x6 --interval 0.9:1"}) {
    const json::value cpu = extract_json(data), device = extract_json(data + " --device surfaceless");
    ASSERT_TRUE(cpu.is_object() && device.is_object());
    for (const char* key : {"cells", "active_cells", "tetrahedra", "points", "unmatched_facets"})
      EXPECT_EQ(cpu.at(key).to_number<long long>(), device.at(key).to_number<long long>()) << data << " " << key;
    EXPECT_GT(device.at("tetrahedra").to_number<long long>(), 0) << data;
    for (const char* key : {"lower", "upper", "domain"})
      EXPECT_EQ(cpu.at("boundary_facets").at(key).to_number<long long>(),
                device.at("boundary_facets").at(key).to_number<long long>())
          << data << " " << key;
    const auto &a = cpu.at("intervals").as_array(), &b = device.at("intervals").as_array();
    for (std::size_t i = 0; i < a.size(); ++i) {
      for (const char* key : {"active_cells", "tetrahedra", "inverted"})
        EXPECT_EQ(a[i].at(key).to_number<long long>(), b[i].at(key).to_number<long long>()) << data << " " << key;
      EXPECT_NEAR(a[i].at("volume").to_number<double>(), b[i].at("volume").to_number<double>(), 1e-9) << data;
    }
    EXPECT_EQ(cpu.at("device").as_string(), "cpu");
    EXPECT_THAT(std::string(device.at("device").as_string()), HasSubstr("OpenGL"));
  }
}

TEST(ExtractDevice, AutoGoesOnOnTheCpuWhereThereIsNoGpu) {
  const json::value document = extract_json("torus:16 --interval 0.1:0.2 --device auto", kNoDriver);
  ASSERT_TRUE(document.is_object());
  EXPECT_EQ(document.at("device").as_string(), "cpu");
  EXPECT_GT(document.at("tetrahedra").to_number<long long>(), 0);
}

TEST(ExtractDevice, ANamedDeviceThatCannotSaysWhy) {
  const CommandResult none = run_isostrata("extract torus:16 --interval 0.1:0.2 --device surfaceless", kNoDriver);
  EXPECT_EQ(none.status, 1);
  EXPECT_THAT(none.err, HasSubstr("surfaceless"));
  const CommandResult unstructured = run_isostrata("extract tets:6 --interval 0.1:0.5 --device surfaceless");
  EXPECT_EQ(unstructured.status, 1);
  EXPECT_THAT(unstructured.err, HasSubstr("extract on the CPU"));
  const CommandResult unknown = run_isostrata("extract torus:16 --interval 0.1:0.2 --device nosuch");
  EXPECT_EQ(unknown.status, 1);
  EXPECT_THAT(unknown.err, HasSubstr("nosuch"));
}

TEST(ExtractDevice, BenchTimesUploadApartFromExtraction) {
  const CommandResult result =
      run_isostrata("bench extract --data torus:16 --data cylinder:12x8x6 --device surfaceless --repeat 2 --json");
  ASSERT_EQ(result.status, 0) << result.err;
  const json::value document = json::parse(result.out);
  const auto& runs = document.at("runs").as_array();
  ASSERT_EQ(runs.size(), 2u);
  for (const auto& run : runs) {
    EXPECT_GT(run.at("active_cells").to_number<long long>(), 0);
    EXPECT_GT(run.at("tetrahedra").to_number<long long>(), 0);
    EXPECT_GE(run.at("upload_ms").to_number<double>(), 0);
    EXPECT_GE(run.at("index_ms").to_number<double>(), 0);
    for (const char* ms : {"records_ms", "ms"})
      EXPECT_LE(run.at(ms).at("min").to_number<double>(), run.at(ms).at("max").to_number<double>());
    EXPECT_TRUE(run.at("software").as_bool());
  }
}

TEST(ExtractDevice, BenchScalesTheArrayToBytes) {
  const CommandResult result = run_isostrata("bench extract --data torus:20 --device surfaceless --as-bytes --repeat 1 --json");
  ASSERT_EQ(result.status, 0) << result.err;
  const json::value run = json::parse(result.out).at("runs").at(0);
  EXPECT_EQ(run.at("type").as_string(), "uint8");
  EXPECT_GT(run.at("active_cells").to_number<long long>(), 0);
  EXPECT_EQ(run_isostrata("bench extract --data torus:20 --as-bytes --repeat 1").status, 1);
}

TEST(ExtractDevice, DoctorSaysWhetherItWorks) {
  const CommandResult works = run_isostrata("doctor --device surfaceless --json");
  ASSERT_EQ(works.status, 0) << works.err;
  EXPECT_TRUE(json::parse(works.out).at("compute_extraction").at("ok").as_bool()) << works.out;
  const CommandResult none = run_isostrata("doctor --json", kNoDriver);
  EXPECT_FALSE(json::parse(none.out).at("compute_extraction").at("ok").as_bool()) << none.out;
}

}  // namespace
