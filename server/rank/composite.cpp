#include "rank/composite.h"

#include <IceTMPI.h>

#include <string>

#include "base/error.h"

namespace isostrata {

Compositor::Compositor(MPI_Comm ranks) {
  const IceTCommunicator communicator = icetCreateMPICommunicator(ranks);
  context_ = icetCreateContext(communicator);
  icetDestroyMPICommunicator(communicator);  // the context has a copy
  icetDiagnostics(ICET_DIAG_OFF);            // it would print; icetGetError tells
  icetSetColorFormat(ICET_IMAGE_COLOR_RGBA_FLOAT);
  icetSetDepthFormat(ICET_IMAGE_DEPTH_NONE);
  icetStrategy(ICET_STRATEGY_SEQUENTIAL);  // of those that keep an order the one for a single tile
  icetCompositeMode(ICET_COMPOSITE_MODE_BLEND);
  icetEnable(ICET_ORDERED_COMPOSITE);
}

Compositor::~Compositor() { icetDestroyContext(context_); }

const FloatImage& Compositor::blend(const FloatImage& own, const std::array<int, 4>& covered, const std::vector<int>& front_to_back) {
  static constexpr IceTDouble kIdentity[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
  static constexpr IceTFloat kClear[4] = {0, 0, 0, 0};
  while (icetGetError() != ICET_NO_ERROR) {
  }
  icetResetTiles();
  icetAddTile(0, 0, own.width, own.height, 0);
  icetCompositeOrder(front_to_back.data());
  const IceTImage image = icetCompositeImage(own.rgba.data(), nullptr, covered.data(), kIdentity, kIdentity, kClear);
  if (const IceTEnum error = icetGetError(); error != ICET_NO_ERROR)
    throw Error(ErrorCode::internal, "IceT could not composite a picture of " + std::to_string(own.width) + "x" + std::to_string(own.height) + ": error " + std::to_string(error));
  if (icetImageIsNull(image) || icetImageGetColorFormat(image) == ICET_IMAGE_COLOR_NONE || icetImageGetNumPixels(image) == 0) {
    whole_ = {};
    return whole_;
  }
  whole_.width = own.width;
  whole_.height = own.height;
  whole_.rgba.resize(own.rgba.size());
  icetImageCopyColorf(image, whole_.rgba.data(), ICET_IMAGE_COLOR_RGBA_FLOAT);
  return whole_;
}

}  // namespace isostrata
