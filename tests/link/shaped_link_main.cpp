// Beside CI: a long thin line to a server on this machine, for a browser. Prints the port where it begins, and is there until its
// input ends.
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <exception>

#include "bench/shaped_link.h"

int main(int argc, char** argv) {
  const int target = argc == 4 ? std::atoi(argv[1]) : 0;
  const double round_trip_ms = argc == 4 ? std::atof(argv[2]) : -1;
  const double mbit = argc == 4 ? std::atof(argv[3]) : -1;
  if (target < 1 || target > 65535 || round_trip_ms < 0 || mbit < 0) {
    std::fprintf(stderr, "usage: isostrata-shaped-link PORT ROUND_TRIP_MS MEGABITS_PER_SECOND (0: no limit)\n");
    return 2;
  }
  try {
    isostrata::LinkShape shape;
    shape.round_trip = std::chrono::microseconds(static_cast<std::int64_t>(round_trip_ms * 1000));
    shape.bits_per_second = mbit * 1e6;
    const isostrata::ShapedLink link(static_cast<unsigned short>(target), shape);
    std::printf("%d\n", link.port());
    std::fflush(stdout);
    while (std::getchar() != EOF) {
    }
  } catch (const std::exception& problem) {
    std::fprintf(stderr, "%s\n", problem.what());
    return 1;
  }
  return 0;
}
