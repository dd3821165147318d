// What one viewer may ask for. The page and clients are told in Welcome.
#pragma once

#include <cstddef>
#include <cstdint>

namespace isostrata {

constexpr std::uint32_t kProtocolMajor = 1;
constexpr std::uint32_t kProtocolMinor = 2;

constexpr int kMaxIntervals = 256;
constexpr int kMaxTransferPoints = 512;  // of all intervals of a session together
constexpr int kMaxTerms = 16;            // of a combination
constexpr int kMaxSmearSteps = 64;
// Three pictures a second are the most that may flash without harm (WCAG 2.3.1).
constexpr double kMinCycleSeconds = 1.0 / 3, kMaxCycleSeconds = 3600;
constexpr int kMaxSide = 16384;                 // of a viewport or an image, in pixels
constexpr std::int64_t kMaxPixels = 1ll << 26;  // of one picture: 67 million, 256 MiB as RGBA
constexpr int kMaxBins = 4096;
constexpr int kMaxClipPlanes = 32;
constexpr std::size_t kMaxNameBytes = 1024;   // of ids, array names, colour maps
constexpr std::size_t kMaxPersonBytes = 128;  // of the name of a participant or an invitation, and of a client's id
constexpr std::size_t kMaxMessageBytes = 1 << 20;
constexpr double kMaxMagnitude = 1e300;  // of any coordinate or value: sums and squares of differences stay apart from overflow
constexpr double kMaxCoordinate = 1e30;  // of a camera

}  // namespace isostrata
