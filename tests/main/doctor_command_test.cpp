#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <boost/json.hpp>
#include <fstream>

#include "support/osmesa.h"
#include "support/run_isostrata.h"

namespace {

using namespace isostrata::testing;
using ::testing::AnyOf;
using ::testing::HasSubstr;

TEST(DoctorCommand, SaysWhatItTriedAndWhatWillBeUsed) {
  const CommandResult result = run_isostrata("doctor --json");
  ASSERT_EQ(result.status, 0) << result.err;
  const auto document = boost::json::parse(result.out);
  EXPECT_TRUE(document.at("can_draw").as_bool());
  EXPECT_FALSE(document.at("device").as_string().empty());
  bool surfaceless = false, osmesa = false, egl = false, hardware = false;
  for (const auto& device : document.at("devices").as_array()) {
    surfaceless = surfaceless || device.at("name").as_string() == "EGL surfaceless";
    osmesa = osmesa || device.at("name").as_string() == "OSMesa";
    hardware = hardware || (device.at("ok").as_bool() && !device.at("software").as_bool());
    egl = egl || (!osmesa && device.at("ok").as_bool());
    EXPECT_FALSE(device.at("detail").as_string().empty());
  }
  EXPECT_TRUE(surfaceless);
  EXPECT_NE(osmesa, egl) << "OSMesa is tried if EGL gave nothing";
  EXPECT_EQ(document.at("unused_cards").as_array().empty(), hardware || document.at("cards").as_array().empty()) << document.at("unused_cards");
  const auto& worker = document.at("worker");
  EXPECT_TRUE(worker.at("ok").as_bool()) << worker;
  EXPECT_THAT(std::string(worker.at("detail").as_string()), HasSubstr("was replaced by process"));
  EXPECT_EQ(worker.at("device"), document.at("device")) << "the worker draws on what doctor says is used";
  EXPECT_GT(worker.at("frame_ms").to_number<double>(), 0);
  bool vp9 = false;
  for (const auto& codec : document.at("codecs").as_array()) {
    const std::string name(codec.at("name").as_string()), detail(codec.at("detail").as_string());
    EXPECT_TRUE(codec.at("ok").as_bool()) << name;
    if (name == "vp9-444") {
      vp9 = true;
      EXPECT_THAT(detail, HasSubstr("decoded as they were"));
    }
  }
  EXPECT_TRUE(vp9);
  const auto& sandbox = document.at("sandbox");
  EXPECT_EQ(sandbox.at("used").as_string(), "try");
  EXPECT_EQ(sandbox.at("ok").as_bool(), sandbox.at("landlock").to_number<int>() > 0 && sandbox.at("seccomp").as_bool());
  EXPECT_EQ(sandbox.at("ok").as_bool(), sandbox.at("missing").as_string().empty());
  EXPECT_GE(document.at("limits").at("cores").to_number<int>(), 1);
  EXPECT_GT(document.at("limits").at("memory_bytes").to_number<long long>(), 1ll << 20);
}

TEST(DoctorCommand, SaysWhichEglItLoadsAndWhyADriverOfItDoesNotLoad) {
  const TemporaryFolder folder;
  std::ofstream(folder / "10_gone.json") << R"({"file_format_version": "1.0.0", "ICD": {"library_path": "libEGL_gone.so.0"}})";
  std::ofstream(folder / "20_empty.json") << "{}";
  const CommandResult result = run_isostrata("doctor --json", "__EGL_VENDOR_LIBRARY_DIRS='" + folder.path().string() + "'");
  ASSERT_EQ(result.status, 0) << result.err;
  const auto document = boost::json::parse(result.out);
  EXPECT_THAT(std::string(document.at("c_library").at("detail").as_string()), HasSubstr("/libc.so.6"));
  const auto& egl = document.at("egl").as_array();
  ASSERT_EQ(egl.size(), 3u) << document.at("egl");
  EXPECT_TRUE(egl[0].at("ok").as_bool());
  EXPECT_THAT(std::string(egl[0].at("detail").as_string()), HasSubstr("/libEGL.so.1"));
  EXPECT_EQ(egl[1].at("name").as_string(), "10_gone.json: libEGL_gone.so.0");
  EXPECT_FALSE(egl[1].at("ok").as_bool());
  EXPECT_THAT(std::string(egl[1].at("detail").as_string()), HasSubstr("libEGL_gone.so.0: cannot open shared object file"));
  EXPECT_FALSE(egl[2].at("ok").as_bool());
  EXPECT_THAT(std::string(egl[2].at("detail").as_string()), HasSubstr("names no driver"));
}

TEST(DoctorCommand, IsLoudAboutSoftware) {
  const CommandResult result = run_isostrata("doctor --device surfaceless");
  ASSERT_EQ(result.status, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("*** SOFTWARE rendering"));
  EXPECT_THAT(result.out, HasSubstr("process that draws"));
}

/// As EGL's only driver, the one that ends every process that loads it.
std::string crashing_driver(const TemporaryFolder& folder) {
  std::ofstream(folder / "10_crash.json") << R"({"file_format_version": "1.0.0", "ICD": {"library_path": ")" << isostrata::places::binaries()
                                          << R"(/libisostrata-crashing-driver.so"}})";
  return "__EGL_VENDOR_LIBRARY_DIRS='" + folder.path().string() + "'";
}

TEST(DoctorCommand, ADriverThatEndsItsProcessIsNamedAndTheCpuDraws) {
  const TemporaryFolder folder;
  const CommandResult result = run_isostrata("doctor --json", crashing_driver(folder));
  ASSERT_EQ(result.status, 0) << result.err;
  const auto document = boost::json::parse(result.out);
  EXPECT_THAT(std::string(document.at("device").as_string()), HasSubstr("CPU"));
  EXPECT_TRUE(document.at("worker").at("ok").as_bool()) << document.at("worker");
  const auto& devices = document.at("devices").as_array();
  ASSERT_EQ(devices.size(), 3u) << document.at("devices");
  for (const std::size_t i : {0u, 1u}) {
    EXPECT_EQ(devices[i].at("name").as_string(), i == 0 ? "EGL devices" : "EGL surfaceless");
    EXPECT_FALSE(devices[i].at("ok").as_bool());
    EXPECT_THAT(std::string(devices[i].at("detail").as_string()), HasSubstr("signal 11"));
  }
  EXPECT_EQ(devices[2].at("name").as_string(), "OSMesa");
  EXPECT_EQ(devices[2].at("ok").as_bool(), osmesa_is_installed());
  EXPECT_THAT(std::string(document.at("egl").as_array().at(1).at("detail").as_string()), HasSubstr("signal 11"));
}

TEST(DoctorCommand, CommandsGoOnWhereADriverEndsItsProcess) {
  const TemporaryFolder folder;
  const std::string out = " --out '" + (folder / "a.png").string() + "'", driver = crashing_driver(folder);
  const CommandResult picture = run_isostrata("render torus:8 --json" + out, driver);
  ASSERT_EQ(picture.status, 0) << picture.err;
  EXPECT_THAT(std::string(boost::json::parse(picture.out).at("device").as_string()), HasSubstr("CPU"));
  EXPECT_EQ(run_isostrata("doctor --device surfaceless", driver).status, 1);
  EXPECT_EQ(run_isostrata("extract torus:8 --interval 0:0.2 --device auto --out '" + (folder / "a.vtu").string() + "'", driver).status, 0);
}

// zink draws by Vulkan; without a Vulkan driver Mesa's EGL says so, and its OSMesa ends the process.
TEST(DoctorCommand, ZinkEndsNoCommand) {
  const TemporaryFolder folder;
  const CommandResult result = run_isostrata("doctor --json", "GALLIUM_DRIVER=zink");
  ASSERT_EQ(result.status, 0) << result.err;
  EXPECT_TRUE(boost::json::parse(result.out).at("worker").at("ok").as_bool());
  EXPECT_EQ(run_isostrata("render torus:8 --renderer auto --out '" + (folder / "a.png").string() + "'", "GALLIUM_DRIVER=zink").status, 0);
}

// With EGL's vendor list empty and a driver that does not exist, neither EGL nor OSMesa makes a context.
TEST(DoctorCommand, ExitsWithOneAndTheReasonsWhereTheDeviceCannotDraw) {
  const std::string no_driver = "__EGL_VENDOR_LIBRARY_FILENAMES=/nonexistent.json MESA_GL_VERSION_OVERRIDE=3.0";
  const CommandResult result = run_isostrata("doctor --json --device osmesa", no_driver);
  EXPECT_EQ(result.status, 1);
  const auto document = boost::json::parse(result.out);
  EXPECT_FALSE(document.at("can_draw").as_bool());
  EXPECT_TRUE(document.at("device").is_null());
  EXPECT_THAT(std::string(document.at("reason").as_string()), HasSubstr("OSMesa"));
  EXPECT_THAT(result.err, HasSubstr("no OpenGL 4.5 device for 'osmesa'"));
  EXPECT_FALSE(document.at("worker").at("ok").as_bool());
  EXPECT_EQ(run_isostrata("render torus:8 --renderer raster --out a.png", no_driver).status, 1);
}

TEST(DoctorCommand, TheCpuDrawsWhereNoDeviceCan) {
  const CommandResult result =
      run_isostrata("doctor --json", "__EGL_VENDOR_LIBRARY_FILENAMES=/nonexistent.json MESA_GL_VERSION_OVERRIDE=3.0");
  ASSERT_EQ(result.status, 0) << result.err;
  const auto document = boost::json::parse(result.out);
  EXPECT_THAT(std::string(document.at("device").as_string()), HasSubstr("CPU"));
  for (const auto& device : document.at("devices").as_array()) EXPECT_FALSE(device.at("ok").as_bool());
}

// Where EGL has no driver at all, OSMesa takes over by itself.
TEST(DoctorCommand, FallsBackToOsmesaWithoutEgl) {
  const TemporaryFolder folder;
  const CommandResult result =
      run_isostrata("render torus:8 --renderer raster --json --out '" + (folder / "a.png").string() + "'",
                    "__EGL_VENDOR_LIBRARY_FILENAMES=/nonexistent.json");
  if (!osmesa_is_installed()) {
    EXPECT_EQ(result.status, 1);
    EXPECT_THAT(result.err, HasSubstr("libOSMesa.so.6 cannot be loaded"));
    return;
  }
  ASSERT_EQ(result.status, 0) << result.err;
  EXPECT_THAT(std::string(boost::json::parse(result.out).at("device").as_string()), HasSubstr("OSMesa"));
}

}  // namespace
