#include "rendering/compute/compute_renderer.h"

#include <algorithm>
#include <bit>
#include <vector>

#include "base/error.h"
#include "base/stopwatch.h"
#include "rendering/compute/gl_tiles.h"
#include "rendering/gl/draw_with_state.h"
#include "rendering/picture/blank_picture.h"

namespace isostrata {
namespace {

/// Everything that lives in one context.
class ComputeState {
 public:
  explicit ComputeState(std::unique_ptr<GlContext> context) : device_(std::move(context), "draw with native"), mesh_(device_), pipeline_(device_) {
    device_.gl().PixelStorei(GL_PACK_ALIGNMENT, 1);
  }
  ~ComputeState() {
    try {
      device_.make_current();  // the objects are deleted in their own context
    } catch (const Error&) {
      // a lost context: the driver has dropped them already
    }
  }

  DrawResult draw(const DrawInput& input);
  void give_back() {
    mesh_.give_back();
    pipeline_.give_back();
  }
  const GlContext& context() const { return device_.context(); }

 private:
  ComputeDevice device_;
  TileMesh mesh_;
  TilePipeline pipeline_;
};

/// Bits that the tiles of the largest part leave for the rest of a key.
std::uint32_t key_bits(const DrawInput& input, int largest_part) {
  const auto tiles = [&](int size) { return static_cast<unsigned>((std::min(size, largest_part) + 15) / 16); };
  return 32 - static_cast<std::uint32_t>(std::bit_width(tiles(input.width) * tiles(input.height)));
}

DrawResult ComputeState::draw(const DrawInput& input) {
  device_.make_current();
  device_.check();
  DrawResult result;
  DrawFacts& facts = result.facts;
  facts.renderer = "compute";
  facts.device = device_.context().device();

  Stopwatch watch;
  mesh_.set(input);
  const double mesh_ms = watch.lap_ms();
  const TileStyles styles = tile_styles(input, mesh_.scale());
  for (std::size_t i = 0; i < styles.drawn.size(); ++i)
    if (styles.drawn[i]) facts.tetrahedra += mesh_.tetrahedra_of(i);
  watch.lap_ms();
  const TileOrder order = tile_order(input, styles, key_bits(input, pipeline_.largest_part()));
  const double cpu_order_ms = watch.lap_ms();

  result.image = blank_picture(input);

  const TilePicture picture{&input, &mesh_, &styles, &order};
  pipeline_.begin(picture);
  std::vector<TilePart> parts;
  const int side = pipeline_.largest_part();
  for (int y = 0; y < input.height; y += side)
    for (int x = 0; x < input.width; x += side)
      parts.push_back({x, y, std::min(side, input.width - x), std::min(side, input.height - y)});
  std::int64_t late = 0;
  while (!parts.empty()) {
    const TilePart part = parts.back();
    parts.pop_back();
    const TileDrawn drawn =
        pipeline_.draw(picture, part, std::get_if<Image>(&result.image), std::get_if<FloatImage>(&result.image));
    facts.fragments += drawn.fragments;
    late += drawn.late;
    if (!drawn.too_many) continue;
    if (part.width <= 16 && part.height <= 16)
      throw Error(ErrorCode::too_large,
                  device_.context().device() + ": more tetrahedra in 16x16 pixels than renderer compute has room for: draw with native");
    const int half_width = part.width > 16 ? (part.width / 2 + 15) / 16 * 16 : part.width;
    const int half_height = part.height > 16 ? (part.height / 2 + 15) / 16 * 16 : part.height;
    for (int y = 0; y < part.height; y += half_height)
      for (int x = 0; x < part.width; x += half_width)
        parts.push_back({part.x + x, part.y + y, std::min(half_width, part.width - x), std::min(half_height, part.height - y)});
  }

  facts.stages = pipeline_.stages();
  facts.order_ms = mesh_ms + cpu_order_ms;
  for (const StageTime& stage : facts.stages)
    (stage.name == "blend" || stage.name == "merge" ? facts.draw_ms : facts.order_ms) += stage.ms;
  facts.stages.insert(facts.stages.begin(), {"mesh", mesh_ms});
  facts.readback_ms = pipeline_.readback_ms();
  facts.order = order.method;
  facts.order_exact = order.kind == TILE_ORDER_NONE || (order.kind == TILE_ORDER_LIST ? order.list_exact : late == 0);
  if (order.kind == TILE_ORDER_INDEX)
    facts.order += late == 0 ? " (exact)" : " (exact but for " + std::to_string(late) + " fragments inside cells)";
  if (auto* floats = std::get_if<FloatImage>(&result.image))
    for (std::vector<float>* depths : {&floats->depth, &floats->mean_depth})
      for (float& depth : *depths) depth *= static_cast<float>(mesh_.scale());
  return result;
}

class ComputeRenderer final : public Renderer {
 public:
  ComputeRenderer(std::unique_ptr<GlContext> context, std::string wanted) : wanted_(std::move(wanted)) {
    state_ = std::make_unique<ComputeState>(std::move(context));
    device_ = state_->context().device();
  }

  DrawResult draw(const DrawInput& input) override {
    return draw_with_state(
        state_, [&] { return std::make_unique<ComputeState>(open_context(wanted_)); }, input);
  }

  const std::string& device() const override { return device_; }
  bool extracts() const override { return true; }

 private:
  std::string wanted_, device_;
  std::unique_ptr<ComputeState> state_;
};

}  // namespace

std::unique_ptr<Renderer> make_compute_renderer(std::unique_ptr<GlContext> context, std::string device) {
  return std::make_unique<ComputeRenderer>(std::move(context), std::move(device));
}

}  // namespace isostrata
