// What is said of the values of a file that no rank reads whole is what one process says, and it looks the same.
#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <stdexcept>

#include "rank/by_ranks.h"
#include "support/served.h"

namespace isostrata::testing {
namespace {

/// 66 MiB of bytes, which are mapped where they lie; values fall along x, rise from the middle along the others.
std::filesystem::path write_large(const std::filesystem::path& path) {
  constexpr int kSide[3] = {420, 410, 402};
  std::ofstream out(path, std::ios::binary);
  out << "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 420 410 402\nencoding: raw\n\n";
  std::vector<char> row(kSide[0]);
  for (int z = 0; z < kSide[2]; ++z)
    for (int y = 0; y < kSide[1]; ++y) {
      for (int x = 0; x < kSide[0]; ++x)
        row[static_cast<std::size_t>(x)] = static_cast<char>((kSide[0] - x) / 4 + std::abs(y - kSide[1] / 2) / 4 + std::abs(z - kSide[2] / 2) / 3);
      out.write(row.data(), static_cast<std::streamsize>(row.size()));
    }
  return path;
}

/// The answer to one request, as JSON.
boost::json::value ask(const Served& server, const std::string& method, const std::string& path, const std::string& body = "") {
  const std::string url = server.url();  // http://127.0.0.1:PORT/?token=TOKEN
  const auto colon = url.rfind(':'), slash = url.find('/', colon), token = url.find("token=");
  const int socket = ::socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(std::stoi(url.substr(colon + 1, slash - colon - 1))));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  if (::connect(socket, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) throw std::runtime_error("no connection to " + url);
  const std::string request = method + " /api/v1/" + path + " HTTP/1.1\r\nHost: 127.0.0.1:" + url.substr(colon + 1, slash - colon - 1) + "\r\nAuthorization: Bearer " +
                              url.substr(token + 6) + "\r\nContent-Type: application/json\r\nContent-Length: " + std::to_string(body.size()) +
                              "\r\nConnection: close\r\n\r\n" + body;
  if (::send(socket, request.data(), request.size(), 0) != static_cast<ssize_t>(request.size())) throw std::runtime_error("nothing was sent to " + url);
  std::string answer;
  char part[4096];
  for (ssize_t got = 0; (got = ::recv(socket, part, sizeof part, 0)) > 0;) answer.append(part, static_cast<std::size_t>(got));
  ::close(socket);
  const auto head = answer.find("\r\n\r\n");
  if (!answer.starts_with("HTTP/1.1 2") || head == std::string::npos) throw std::runtime_error(path + ": " + answer);
  return boost::json::parse(answer.substr(head + 4));
}

/// What a session that begins with the server's dataset says: intervals, histogram, statistics, the dataset.
std::array<boost::json::value, 4> told_by(const Served& server) {
  const auto dataset = ask(server, "GET", "datasets").at("datasets").at(0).at("id").as_string();
  const auto session = ask(server, "POST", "sessions", "{\"dataset\":\"" + std::string(dataset) + "\"}").at("id").as_string();
  const std::string of = "sessions/" + std::string(session);
  return {ask(server, "GET", of + "/intervals"), ask(server, "GET", of + "/histogram?bins=50"), ask(server, "GET", of + "/statistics"),
          ask(server, "GET", "datasets/" + std::string(dataset))};
}

TEST(FactsByRanks, PicturesOfAMappedFileAreThoseOfOneProcess) {
  const TemporaryFolder folder;
  const std::string file = quoted(write_large(folder / "large.nrrd"));
  for (const char* layers : {" --interval 60.5:70.5,opacity=0.3", " --interval 20.5:22.5,color=map:viridis,opacity=0.4"}) {
    const std::string arguments = file + layers + " --size 120x90";
    const Distance off = distance_of(render_exr(folder, arguments, 0), render_exr(folder, arguments, 3));
    EXPECT_GT(off.brightest, 0.05) << layers;
    EXPECT_LE(off.worst, 1e-5) << layers;
  }
}

TEST(FactsByRanks, RangesHistogramAndStatisticsOfAMappedFileAreThoseOfOneProcess) {
  set_mpi_environment();
  const TemporaryFolder folder;
  const std::string file = write_large(folder / "large.nrrd").string();
  Served many({file, "--renderer", "native", "--ranks", launcher(3)}), one({file, "--renderer", "native"});
  ASSERT_FALSE(many.url().empty()) << many.process().err();
  ASSERT_FALSE(one.url().empty()) << one.process().err();
  const auto by_many = told_by(many), by_one = told_by(one);
  EXPECT_EQ(by_many[0], by_one[0]) << by_many[0] << " and " << by_one[0];  // the first view, which ranges and samples decide
  EXPECT_EQ(by_many[1], by_one[1]) << by_many[1];
  std::int64_t counted = 0;
  for (const auto& bin : by_many[1].at("counts").as_array()) counted += std::stoll(std::string(bin.as_string()));
  EXPECT_EQ(counted, 420 * 410 * 402);
  for (const char* name : {"lower", "upper"}) EXPECT_EQ(by_many[2].at(name), by_one[2].at(name)) << by_many[2];
  for (const char* name : {"mean", "standardDeviation"})
    EXPECT_NEAR(by_many[2].at(name).to_number<double>(), by_one[2].at(name).to_number<double>(), 1e-12 * by_one[2].at("upper").to_number<double>()) << by_many[2];
  EXPECT_EQ(many.stop(SIGTERM), 0);
  one.stop(SIGTERM);
}

// The first rank has one part of three, and says what is so of all.
TEST(FactsByRanks, FactsHistogramAndFirstViewOfPartsAreThoseOfOneProcess) {
  set_mpi_environment();
  const TemporaryFolder folder;
  for (const char* data : {"torus:20", "mixed:9"}) {
    SCOPED_TRACE(data);
    const std::filesystem::path out = folder / std::string(data, 5);
    const CommandResult run = run_isostrata(std::string("partition ") + data + " --parts 3 --json --out " + quoted(out));
    ASSERT_EQ(run.status, 0) << run.err;
    const std::string list(boost::json::parse(run.out).at("list").as_string());
    Served many({list, "--renderer", "native", "--ranks", launcher(3)}), one({data, "--renderer", "native"});
    ASSERT_FALSE(many.url().empty()) << many.process().err();
    ASSERT_FALSE(one.url().empty()) << one.process().err();
    const auto by_many = told_by(many), by_one = told_by(one);
    EXPECT_EQ(by_many[0], by_one[0]) << by_many[0] << " and " << by_one[0];
    for (const char* name : {"lower", "upper", "counts"}) EXPECT_EQ(by_many[1].at(name), by_one[1].at(name)) << by_many[1];
    EXPECT_NEAR(by_many[2].at("mean").to_number<double>(), by_one[2].at("mean").to_number<double>(), 1e-12 * by_one[2].at("upper").to_number<double>()) << by_many[2];
    for (const char* name : {"points", "cells", "lower", "upper"}) EXPECT_EQ(by_many[3].at(name), by_one[3].at(name)) << by_many[3];
    EXPECT_EQ(many.stop(SIGTERM), 0);
    one.stop(SIGTERM);
  }
}

}  // namespace
}  // namespace isostrata::testing
