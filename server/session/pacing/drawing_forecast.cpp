#include "session/pacing/drawing_forecast.h"

namespace isostrata {
namespace {

constexpr Duration kSameScene = std::chrono::seconds(1);  // a rest so soon after a moving picture shows what that showed

}  // namespace

void DrawingForecast::rested(double ms, double pixels, TimePoint now) {
  if (!(ms > 0) || !(pixels > 0)) return;
  by_pixels_.known(kBeside * ms, pixels, moved_ > 0 && now - moved_at_ < kSameScene, now);
  rest_ms_ = kBeside * ms;
  rest_pixels_ = pixels;
  moved_ = 0;
}

void DrawingForecast::moved(Codec codec, double ms, double pixels, TimePoint now) {
  const double before = by_pixels_.scaled(1, pixels, 1, now);
  by_pixels_.measured(ms, pixels, now);
  moving_.rescale(by_pixels_.scaled(1, pixels, 1, now) / before);  // what was measured of this size is told anew of a megapixel
  moving_.measured(codec, by_pixels_.scaled(ms, pixels, 1, now), now);
  ++moved_;
  moved_at_ = now;
}

double DrawingForecast::ms(Codec codec, double pixels, TimePoint now) const {
  const double moving = by_pixels_.scaled(moving_.expected(codec, now), 1, pixels, now);
  if (rest_ms_ <= 0) return moving;
  const double rest = by_pixels_.scaled(rest_ms_, rest_pixels_, pixels, now);
  return moved_ == 0 || moving <= 0 ? rest : (kRestCounts * rest + moved_ * moving) / (kRestCounts + moved_);
}

}  // namespace isostrata
