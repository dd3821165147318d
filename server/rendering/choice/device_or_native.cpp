#include "rendering/choice/device_or_native.h"

#include <algorithm>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "base/error.h"
#include "extraction/bricks/layer_bricks.h"
#include "extraction/intervals/extract_intervals.h"
#include "rendering/choice/native_renderer.h"
#include "rendering/picture/body_shading.h"
#include "rendering/picture/check_draw_input.h"

namespace isostrata {
namespace {

/// What a picture needs of a device beside its mesh.
struct Needs {
  explicit Needs(const DrawInput& input)
      : pixels(std::int64_t{input.width} * input.height),
        values(input.color_values != nullptr),
        surfaces(std::any_of(input.styles.begin(), input.styles.end(), [](const IntervalStyle& style) { return style.visible && style.surface.drawn(); })),
        floats(input.float_image),
        mean_depth(input.mean_depth),
        shaded(shades_bodies(input)) {}
  bool no_less_than(const Needs& other) const {
    return pixels >= other.pixels && values >= other.values && surfaces >= other.surfaces && floats >= other.floats && mean_depth >= other.mean_depth && shaded >= other.shaded;
  }

  std::int64_t pixels;
  bool values, surfaces, floats, mean_depth, shaded;
};

/// What the device has no room for.
struct Refused {
  std::weak_ptr<const IntervalMesh> mesh;
  Needs needs;
  std::string why;
};

class DeviceOrNative final : public Renderer {
 public:
  explicit DeviceOrNative(std::unique_ptr<Renderer> device) : device_(std::move(device)) {}

  DrawResult draw(const DrawInput& input) override {
    if (input.mesh && input.mesh->tetrahedra.empty() && !input.mesh->facets.empty()) return native().draw(input);
    const Refused* refused = find_refused(input);
    if (refused_.empty()) forget();
    if (!refused) {
      try {
        return device_->draw(input);
      } catch (const Error& error) {
        if (error.code() != ErrorCode::too_large) throw;
        refused = &refused_.emplace_back(Refused{input.mesh, Needs(input), without_name(error.what())});
      }
    }
    DrawResult result = native().draw(with_mesh(input));
    result.facts.device += " in place of " + device() + ", which has no room: " + refused->why;
    return result;
  }
  const std::string& device() const override { return device_->device(); }
  bool extracts() const override { return device_->extracts(); }

 private:
  Renderer& native() {
    if (!native_) native_ = make_native_renderer();
    return *native_;
  }
  /// Null: this picture may be tried. Sessions take turns, so several meshes are known.
  const Refused* find_refused(const DrawInput& input) {
    std::erase_if(refused_, [](const Refused& of) { return of.mesh.expired(); });
    const Needs needs(input);
    const auto known = std::find_if(refused_.begin(), refused_.end(), [&](const Refused& of) { return of.mesh.lock() == input.mesh && needs.no_less_than(of.needs); });
    return known == refused_.end() ? nullptr : &*known;
  }
  /// Layers whose mesh was to be made on the device get it here, where the native renderer needs one.
  DrawInput with_mesh(const DrawInput& input) {
    if (!input.bricks || all_constant(input)) return input;
    if (mesh_of_.lock() != input.bricks) {
      const LayerBricks& layers = *input.bricks;
      ExtractOptions options;
      options.values = true;
      options.measure = false;
      IntervalMesh mesh = extract_intervals(layers.grid(), layers.array(), layers.intervals(), options, Task{});
      values_ = std::make_shared<const std::vector<float>>(mesh.values.begin(), mesh.values.end());
      mesh_ = std::make_shared<const IntervalMesh>(std::move(mesh));
      mesh_of_ = input.bricks;
    }
    DrawInput drawn = input;
    drawn.bricks = nullptr;
    drawn.mesh = mesh_;
    drawn.color_values = values_;
    return drawn;
  }
  void forget() {
    native_.reset();  // what it has made of meshes goes with it
    mesh_.reset();
    values_.reset();
    mesh_of_.reset();
  }
  /// A device's message often begins with its name.
  std::string without_name(const std::string& message) const {
    const std::string name = device() + ": ";
    return message.starts_with(name) ? message.substr(name.size()) : message;
  }

  const std::unique_ptr<Renderer> device_;
  std::unique_ptr<Renderer> native_;  // made when it is needed
  std::vector<Refused> refused_;      // whose meshes live
  std::weak_ptr<const LayerBricks> mesh_of_;
  std::shared_ptr<const IntervalMesh> mesh_;          // of those
  std::shared_ptr<const std::vector<float>> values_;  // of their array, at its points
};

}  // namespace

std::unique_ptr<Renderer> make_device_or_native(std::unique_ptr<Renderer> device) { return std::make_unique<DeviceOrNative>(std::move(device)); }

}  // namespace isostrata
