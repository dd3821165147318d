#include "session/pacing/making_costs.h"

#include <algorithm>
#include <cmath>

#include "engine/messages/coarse_levels.h"

namespace isostrata {
namespace {

constexpr double kLeastCoarsePart = 0.1;
constexpr double kFirstPartOfCells = 0.125;  // of all points, that the first level has

/// Of what the first coarse level takes, what another one does: of finding its layers, which goes by cells, and of drawing them, by facets and by pixels.
double part_of_cells(int level) { return 1 / std::pow(kCoarser.at(static_cast<std::size_t>(level - 1)), 3); }
double part_of_drawing(int level) { return 0.5 + 0.5 / std::pow(kCoarser.at(static_cast<std::size_t>(level - 1)), 2); }

/// What takes `ms` beside something that takes `beside`, and gets as much of the machine: without it, and back.
double alone(double ms, double beside) { return ms <= 2 * beside ? ms / 2 : ms - beside; }
double together(double alone, double beside) { return alone + std::min(alone, beside); }

}  // namespace

void MakingCosts::made(const FrameRequest& request, FramePhase phase, const FrameReady& ready, TimePoint now) {
  const StageTimes& ms = ready.stages;
  const double drawing = ms.order_ms + ms.draw_ms + ms.readback_ms;
  const double size = megapixels(ready.width, ready.height);
  if (request.still || request.samples > 1) return;
  coarse_at_hand_ = ready.coarse_at_hand;
  layers_may_be_coarse_ = ready.layers_may_be_coarse;
  const bool coarse = ready.point_stride > 1;
  const int level = std::max(1, request.coarse);
  const double extraction = phase == FramePhase::moving ? alone(ms.extract_ms, drawing) : ms.extract_ms;
  if (extraction > 0 && coarse)
    coarse_extraction_ = extraction / part_of_cells(level);
  else if (extraction > 0)
    extraction_ = extraction;
  if (phase != FramePhase::moving || request.lossless) {
    moves_layers_ = false;
    // What every n-th point took by what this takes holds for the next gesture, too.
    const double whole = drawing_.ms(Codec::jpeg, size, now), of_coarse = coarse_drawing_.ms(Codec::jpeg, size, now);
    if (coarse_drawing_.pictures() >= CodecCosts::kEnough && whole > 0)
      coarse_part_ = std::clamp(of_coarse / whole, kLeastCoarsePart, 1.0);
    drawing_.rested(drawing, size, now);
    coarse_drawing_.rested(coarse_part_ * drawing, size, now);
    return;
  }
  const Codec codec = ready.video ? ready.video->codec : Codec::jpeg;
  if (coarse)
    coarse_drawing_.moved(codec, drawing / part_of_drawing(level), size, now);
  else
    drawing_.moved(codec, drawing, size, now);
  if (ready.video && ready.video->key) return;  // the first of a stream: an encoder had to be made, too
  encoding_.measured(codec, ms.encode_ms / coding_weight(size), now);
}

double MakingCosts::drawing_ms(int level, Codec codec, double size, TimePoint now) const {
  return level == 0 ? drawing_.ms(codec, size, now) : part_of_drawing(level) * coarse_drawing_.ms(codec, size, now);
}

double MakingCosts::extraction_ms(int level, double beside) const {
  if (level == 0) return together(extraction_, beside);
  return together(part_of_cells(level) * (coarse_extraction_ > 0 ? coarse_extraction_ : kFirstPartOfCells * extraction_), beside);
}

int MakingCosts::most_samples() const {
  int samples = 1;
  while (samples < FrameScheduler::kMostSamples && 4 * samples * samples * drawing_.rested_ms() <= kMostRefiningMs) samples *= 2;
  return samples;
}

}  // namespace isostrata
