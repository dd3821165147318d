#include "engine/first/kept_first_view.h"

#include <cstring>
#include <filesystem>
#include <string>
#include <type_traits>
#include <vector>

#include "base/program_file.h"
#include "data/values/kept_facts.h"

namespace isostrata {
namespace {

constexpr const char* kFact = "first-view";

/// Whatever chooses first views is in this file: another one may choose others.
std::string chooser() {
  std::error_code error;
  const std::filesystem::path file = program_file();
  const auto bytes = std::filesystem::file_size(file, error);
  const auto changed = error ? std::filesystem::file_time_type{} : std::filesystem::last_write_time(file, error);
  return error ? "" : std::to_string(bytes) + ' ' + std::to_string(changed.time_since_epoch().count());
}

/// The fields of a view, in one order for writing and for reading.
template <class Archive, class View>
void each_field(Archive& archive, View& view) {
  const auto surface = [&](auto& of) {
    archive(of.lower), archive(of.upper), archive(of.domain), archive(of.own_color), archive(of.color), archive(of.opacity), archive(of.ambient);
    archive(of.diffuse), archive(of.specular), archive(of.shininess), archive(of.silhouette), archive(of.texture), archive(of.texture_lower);
    archive(of.texture_upper), archive(of.texture_repeat);
  };
  archive(view.array), archive(view.array_reason), archive(view.values), archive(view.step), archive(view.step_reason), archive(view.kind);
  archive(view.kind_reason), archive(view.lower), archive(view.upper);
  archive.list(view.layers, [&](auto& layer) {
    archive(layer.lower), archive(layer.upper), archive(layer.color), archive(layer.opacity), surface(layer.surface), archive(layer.name), archive(layer.reason);
  });
  archive(view.light_reason), archive(view.direction), archive(view.up), archive(view.axis_scale), archive(view.scale_reason);
  archive.list(view.outline, [&](auto& point) { archive(point); });
  archive(view.up_reason), archive(view.camera_reason);
}

struct ViewWriter {
  std::vector<std::byte> bytes;

  template <class T>
  void operator()(const T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    const auto* at = reinterpret_cast<const std::byte*>(&value);
    bytes.insert(bytes.end(), at, at + sizeof value);
  }
  void operator()(const std::string& text) {
    (*this)(static_cast<std::uint64_t>(text.size()));
    const auto* at = reinterpret_cast<const std::byte*>(text.data());
    bytes.insert(bytes.end(), at, at + text.size());
  }
  template <class Item, class Put>
  void list(const std::vector<Item>& items, const Put& put) {
    (*this)(static_cast<std::uint64_t>(items.size()));
    for (const Item& item : items) put(item);
  }
};

struct ViewReader {
  std::span<const std::byte> rest;
  bool good = true;

  template <class T>
  void operator()(T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    if (rest.size() < sizeof value) good = false, rest = {};
    if (!good) return;
    std::memcpy(&value, rest.data(), sizeof value);
    rest = rest.subspan(sizeof value);
  }
  void operator()(std::string& text) {
    const std::size_t size = count();
    text.assign(reinterpret_cast<const char*>(rest.data()), size);
    rest = rest.subspan(size);
  }
  template <class Item, class Get>
  void list(std::vector<Item>& items, const Get& get) {
    for (std::size_t n = count(); n > 0 && good; --n) get(items.emplace_back());
  }

 private:
  std::size_t count() {
    std::uint64_t count = 0;
    (*this)(count);
    if (count > rest.size()) good = false;  // no item takes less than a byte
    return good ? static_cast<std::size_t>(count) : 0;
  }
};

}  // namespace

std::optional<FirstView> kept_first_view(const Dataset& first_step) {
  if (first_step.arrays.empty() || first_step.step != 0) return std::nullopt;
  const auto kept = kept_fact(first_step.arrays.front(), kFact);
  if (!kept) return std::nullopt;
  ViewReader reader{*kept};
  std::string by;
  reader(by);
  FirstView view;
  if (by.empty() || by != chooser()) return std::nullopt;
  each_field(reader, view);
  if (!reader.good || !reader.rest.empty()) return std::nullopt;
  return view;
}

void keep_first_view(const Dataset& first_step, const FirstView& view) {
  const std::string by = chooser();
  if (first_step.arrays.empty() || first_step.step != 0 || by.empty()) return;
  ViewWriter writer;
  writer(by);
  each_field(writer, view);
  keep_fact(first_step.arrays.front(), kFact, writer.bytes);
}

}  // namespace isostrata
