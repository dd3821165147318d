// The fuzz targets without a fuzzer: every input of their corpora, whole, cut short and with a byte changed, so that what was
// found once stays found and the targets go on compiling. A law that breaks ends the process and says which.
#include <gtest/gtest.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "support/places.h"

extern "C" {
int fuzz_commands(const std::uint8_t* data, std::size_t size);
int fuzz_request(const std::uint8_t* data, std::size_t size);
int fuzz_json(const std::uint8_t* data, std::size_t size);
}

namespace {

namespace fs = std::filesystem;

void replay(const char* name, int (*target)(const std::uint8_t*, std::size_t)) {
  int inputs = 0;
  for (const auto& file : fs::directory_iterator(fs::path(isostrata::places::source()) / "tests/fuzz/corpus" / name)) {
    std::ifstream in(file.path(), std::ios::binary);
    const std::string bytes(std::istreambuf_iterator<char>(in), {});
    const auto run = [&](const std::string& input) {
      EXPECT_EQ(target(reinterpret_cast<const std::uint8_t*>(input.data()), input.size()), 0) << file.path();
    };
    run(bytes);
    const std::size_t step = 1 + bytes.size() / 24;
    for (std::size_t at = 0; at < bytes.size(); at += step) {
      run(bytes.substr(0, at));
      std::string other = bytes;
      other[at] = static_cast<char>(other[at] ^ (1 << at % 8));
      run(other);
    }
    ++inputs;
  }
  EXPECT_GE(inputs, 8);
}

TEST(FuzzTargets, HoldOnTheirCorpusOfCommands) { replay("commands", fuzz_commands); }
TEST(FuzzTargets, HoldOnTheirCorpusOfRequests) { replay("request", fuzz_request); }
TEST(FuzzTargets, HoldOnTheirCorpusOfJson) { replay("json", fuzz_json); }

}  // namespace
