// Readers that one process makes for each file: what they give, how they end, and that a broken one costs the others nothing.
#include "data/open/loaded_importer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <future>
#include <thread>

#include "data/files.h"
#include "data/open/importer_request.h"
#include "support/read_process.h"
#include "support/run_isostrata.h"

namespace isostrata {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::SizeIs;

std::string field(int value) {
  return "# vtk DataFile Version 3.0\nt\nASCII\nDATASET STRUCTURED_POINTS\nDIMENSIONS 2 2 2\nORIGIN 0 0 0\nSPACING 1 1 1\n"
         "POINT_DATA 8\nSCALARS f float 1\nLOOKUP_TABLE default\n0 1 2 3 4 5 6 " + std::to_string(value) + "\n";
}

/// Those that `parent` has made, by the first 15 letters of their names.
std::vector<pid_t> children(const std::string& name, pid_t parent) {
  std::vector<pid_t> found;
  std::error_code error;
  for (fs::directory_iterator it("/proc", error), end; !error && it != end; it.increment(error)) {
    const std::string id = it->path().filename().string();
    if (id.find_first_not_of("0123456789") != std::string::npos) continue;
    const std::string stat = testing::read_process(it->path() / "stat");
    const auto open = stat.find('('), close = stat.rfind(')');
    if (open == std::string::npos || stat.substr(open + 1, close - open - 1) != name) continue;
    char state = 0;
    int of = 0;
    if (std::sscanf(stat.c_str() + close + 1, " %c %d", &state, &of) == 2 && of == parent && state != 'Z') found.push_back(std::stoi(id));
  }
  return found;
}
/// This process's own that make readers, of one of the two programs.
std::vector<pid_t> forks(const std::string& program) {
  auto found = children("isostrata-forks", getpid());
  std::erase_if(found, [&](pid_t id) { return fs::read_symlink("/proc/" + std::to_string(id) + "/exe").filename() != program; });
  return found;
}
pid_t forking() {
  test::open(test::Scratch().write("one.vtk", field(1)));
  const auto found = forks("isostrata-import");
  return found.size() == 1 ? found[0] : 0;
}

/// Waits until it holds, for at most 20 s.
template <typename Holds>
bool in_time(const Holds& holds) {
  for (int i = 0; i < 2000; ++i, std::this_thread::sleep_for(std::chrono::milliseconds(10)))
    if (holds()) return true;
  return false;
}

/// A reader of fifteen million numbers of text, which takes seconds.
struct Busy {
  test::Scratch scratch;
  Task task;
  std::future<std::string> said;

  explicit Busy(int nice = 0) {
    std::string numbers;
    for (int i = 0; i < 250 * 250 * 250; ++i) numbers += "0\n";
    const fs::path file = scratch.write("long.vtk", "# vtk DataFile Version 3.0\nt\nASCII\nDATASET STRUCTURED_POINTS\nDIMENSIONS 250 250 250\nORIGIN 0 0 0\n"
                                                    "SPACING 1 1 1\nPOINT_DATA 15625000\nSCALARS f float 1\nLOOKUP_TABLE default\n" + numbers);
    said = std::async(std::launch::async, [this, file, nice] {
      try {
        if (nice > 0) setpriority(PRIO_PROCESS, 0, nice);  // of this thread
        std::vector<std::string> words{file.string(), scratch.path().string(), "0", "8000000000", "100", "off"};
        const auto result = follow_child([&](int out, int err) { return start_loaded_importer(words, reader_needs(words.front()), out, err); }, 100, task,
                                         [](std::string_view) {});
        return "status " + std::to_string(result.exit_status) + " signal " + std::to_string(result.signal);
      } catch (const Error& error) {
        return std::string(to_string(error.code()));
      }
    });
  }
  static fs::path program() { return fs::path(places::binaries()) / "isostrata-import"; }
  std::vector<pid_t> readers() const { return children("isostrata-impor", forks("isostrata-import").at(0)); }
};

TEST(ImporterRequest, ComesOutAsItWentIn) {
  const ImporterRequest request{{"a b", "c\nd", "0"}, {"ONE=1", "TWO=", "THREE=a=b"}, 10};
  const ImporterRequest got = from_packet(to_packet(request));
  EXPECT_EQ(got.words, request.words);
  EXPECT_EQ(got.nice, 10);
  EXPECT_EQ(got.environment, request.environment);
  EXPECT_EQ(from_packet(to_packet({{"a"}, {}})).words, std::vector<std::string>{"a"});
  EXPECT_THROW(to_packet({{std::string(kMostRequest, 'x')}, {}}), Error);
}

TEST(LoadedImporter, OneProcessReadsAllFilesAtOnce) {
  const pid_t first = forking();
  ASSERT_NE(first, 0);
  const test::Scratch scratch;
  std::vector<std::future<double>> uppers;
  for (int i = 0; i < 12; ++i)
    uppers.push_back(std::async(std::launch::async, [&scratch, i] {
      return test::open(scratch.write("f" + std::to_string(i) + ".vtk", field(100 + i)))->arrays.at(0).upper;
    }));
  for (int i = 0; i < 12; ++i) EXPECT_EQ(uppers[static_cast<std::size_t>(i)].get(), 100 + i);
  EXPECT_EQ(forking(), first);
  EXPECT_THAT(children("isostrata-impor", first), IsEmpty());
}

TEST(LoadedImporter, OfManyLibrariesThereIsAnotherThatOnlyFilesWhichNeedItStart) {
  const auto before = forks("isostrata-import-all");
  ASSERT_NE(forking(), 0);
  EXPECT_EQ(forks("isostrata-import-all"), before) << "a legacy file of VTK";
  const test::Scratch scratch;
  scratch.write("one.vtk", field(7));
  const fs::path list = scratch.write("list.pvd", "<VTKFile type=\"Collection\"><Collection><DataSet timestep=\"0\" file=\"one.vtk\"/></Collection></VTKFile>");
  EXPECT_EQ(test::open(list)->arrays.at(0).upper, 7);
  EXPECT_THAT(forks("isostrata-import-all"), SizeIs(1)) << "a list may name any file";
}

TEST(LoadedImporter, AReaderHasTheVariablesOfItsOwnRequest) {
  setenv("ISOSTRATA_TOKEN", "a secret", 1);
  const test::Scratch scratch;
  setenv("TMPDIR", scratch.path().c_str(), 1);
  EXPECT_NO_THROW(test::open(scratch.write("one.vtk", field(1))));
  unsetenv("TMPDIR");
  const pid_t forks = forking();
  unsetenv("ISOSTRATA_TOKEN");
  EXPECT_THAT(test::read_bytes("/proc/" + std::to_string(forks) + "/environ"), Not(HasSubstr("a secret")));
}

TEST(LoadedImporter, ACancelledReaderIsGoneWhenItsTaskIs) {
  ASSERT_NE(forking(), 0);
  Busy busy;
  ASSERT_TRUE(in_time([&] { return busy.readers().size() == 1; }));
  busy.task.cancel();
  EXPECT_EQ(busy.said.get(), "cancelled");
  EXPECT_THAT(busy.readers(), IsEmpty());
}

TEST(LoadedImporter, AReaderIsAsNiceAsTheThreadThatAsks) {
  ASSERT_NE(forking(), 0);
  const int here = getpriority(PRIO_PROCESS, 0), nicer = std::min(here + 5, 19);
  for (const int nice : {0, nicer}) {
    Busy busy(nice);
    ASSERT_TRUE(in_time([&] { return busy.readers().size() == 1; }));
    const pid_t reader = busy.readers().at(0);
    EXPECT_TRUE(in_time([&] { return getpriority(PRIO_PROCESS, static_cast<id_t>(reader)) == (nice ? nice : here); }));
    busy.task.cancel();
    busy.said.get();
  }
}

TEST(LoadedImporter, AKilledReaderIsSaidAndCostsNobodyElse) {
  ASSERT_NE(forking(), 0);
  Busy busy;
  ASSERT_TRUE(in_time([&] { return busy.readers().size() == 1; }));
  kill(busy.readers().at(0), SIGKILL);
  EXPECT_EQ(busy.said.get(), "status 0 signal 9");
  EXPECT_NO_THROW(test::open(busy.scratch.write("one.vtk", field(1))));
}

TEST(LoadedImporter, IfItsProcessIsKilledReadersEndAndTheNextFileStartsAnother) {
  const pid_t first = forking();
  Busy busy;
  ASSERT_TRUE(in_time([&] { return busy.readers().size() == 1; }));
  const pid_t reader = busy.readers().at(0);
  kill(first, SIGKILL);
  EXPECT_EQ(busy.said.get(), "unavailable");
  EXPECT_TRUE(in_time([&] { return kill(reader, 0) != 0 || testing::read_process("/proc/" + std::to_string(reader) + "/stat").find(") Z") != std::string::npos; }));
  EXPECT_NE(forking(), first);
}

TEST(LoadedImporter, EndsWithWhoStartedIt) {
  const test::Scratch scratch;
  const auto file = scratch.write("one.vtk", field(1));
  const auto with_this_folder = [&] {  // as its TMPDIR
    std::vector<std::string> found;
    for (const auto& process : fs::directory_iterator("/proc"))
      if (test::read_bytes(process.path() / "environ").find("TMPDIR=" + scratch.path().string()) != std::string::npos)
        found.push_back(test::read_bytes(process.path() / "cmdline"));
    return found;
  };
  const auto result = testing::run_isostrata("info '" + file.string() + "'", "TMPDIR='" + scratch.path().string() + "'");
  EXPECT_EQ(result.status, 0) << result.err;
  EXPECT_TRUE(in_time([&] { return with_this_folder().empty(); }));
}

TEST(LoadedImporter, LoadsNoLibraryOfTheFolderWhereItIsStarted) {
  const test::Scratch scratch;
  for (const char* name : {"libz.so.1", "libm.so.6", "libc.so.6", "libvtkCommonCore-9.1.so.1"}) scratch.write(name, "not a library");
  const std::string command = "cd '" + scratch.path().string() + "' && '" + Busy::program().string() + "' 2>/dev/null";
  const int state = std::system(command.c_str());
  ASSERT_TRUE(WIFEXITED(state));
  EXPECT_EQ(WEXITSTATUS(state), 2) << "it says how it is used";
}

}  // namespace
}  // namespace isostrata
