#include "import/dataset/write_dataset.h"

#include <fcntl.h>

#include <boost/json.hpp>
#include <cerrno>
#include <cmath>
#include <map>
#include <set>
#include <type_traits>

#include "base/utf8.h"
#include "data/open/import_door.h"
#include "import/bytes/mapped_file.h"
#include "import/bytes/write_behind.h"
#include "import/dataset/append_blocks.h"
#include "import/dataset/average_cells.h"

namespace isostrata {
namespace {

namespace json = boost::json;

class Writer {
 public:
  Writer(std::filesystem::path directory, const ReadRequest& request) : directory_(std::move(directory)), request_(request) {}
  ~Writer() {
    try {
      wait();
    } catch (const Error&) {
    }
  }
  Writer(const Writer&) = delete;
  Writer& operator=(const Writer&) = delete;

  /// The bytes must stay until wait(), or as long as `storage`.
  void file(const std::string& name, std::span<const std::byte> bytes, std::shared_ptr<const void> storage = nullptr) {
    total_ += bytes.size();
    check_bytes(request_, total_, request_.file.filename().string());
    written_.insert(name);
    if (const auto place = MappedFile::place_of(bytes); place && place->offset == 0 && place->file == directory_ / name) return;  // its reader wrote it
    std::error_code none_there;
    std::filesystem::remove(directory_ / name, none_there);  // another array may be mapped from a file of this name: that stays as it is
    const int out = open((directory_ / name).c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
    if (out < 0) throw_system_error("cannot write to a temporary file", errno);
    last_ = write_behind(Hurry::none, out, bytes, true, std::move(storage));
  }
  /// Until all files are written.
  void wait() { wait_for_written(last_); }
  /// Where the server itself can map an array's bytes: a large one, as it lies in a file beside the one that was asked for, or below.
  std::optional<FilePlace> in_place(std::span<const std::byte> bytes, std::size_t element) const {
    if (bytes.size() < kLeastInPlace) return std::nullopt;
    std::optional<FilePlace> place = MappedFile::place_of(bytes);
    if (!place || place->offset % element != 0) return std::nullopt;
    const auto below = [&](const std::filesystem::path& folder) {
      const auto relative = place->file.lexically_normal().lexically_relative(folder.lexically_normal());
      return relative.empty() || *relative.begin() == ".." ? std::filesystem::path() : relative;
    };
    const auto in_folder = below(request_.file.parent_path());
    if (in_folder.empty() || !below(request_.scratch).empty()) return std::nullopt;  // what was unpacked goes with us
    place->file = in_folder;
    return place;
  }
  template <class T>
  void values(const std::string& name, std::span<const T> span) {
    file(name, std::as_bytes(span));
  }

  /// What readers have left in the folder beside these files.
  void sweep() const {
    std::error_code ignored;
    for (const auto& entry : std::filesystem::directory_iterator(directory_, ignored))
      if (!written_.contains(entry.path().filename().string())) std::filesystem::remove(entry.path(), ignored);
  }

 private:
  std::filesystem::path directory_;
  const ReadRequest& request_;
  std::set<std::string> written_;
  std::uint64_t total_ = 0;
  WriteCall last_{Hurry::none};
};

/// Names travel as JSON: what is not UTF-8, or is a control character, becomes '?'.
std::string printable(const std::string& text, std::size_t most) {
  std::string out;
  for (std::size_t i = 0; i < text.size() && out.size() < most;) {
    const std::size_t length = utf8_length(text, i);
    const bool good = length > 0 && static_cast<unsigned char>(text[i]) >= 32 && text[i] != 127;
    if (good && out.size() + length > most) break;
    out += good ? text.substr(i, length) : "?";
    i += good ? length : 1;
  }
  return out;
}

json::array write_points(const PointSpan& points, Writer& writer) {
  std::visit([&](auto span) { writer.values("points.bin", span); }, points);
  return {points.index() == 0 ? "float32" : "float64",
          std::visit([](auto span) { return static_cast<std::int64_t>(span.size()); }, points)};
}

void write_grid(const Block& block, Writer& writer, json::object& manifest) {
  if (block.like) {
    manifest["grid"] = "like";
    return;
  }
  const Grid& grid = block.grid;
  manifest["grid"] = grid.kind_name();
  if (grid.structured()) {
    const auto d = grid.dims();
    manifest["dims"] = json::array{d[0], d[1], d[2]};
  }
  if (const auto* uniform = std::get_if<UniformGrid>(&grid.shape)) {
    // As bytes: a decimal in between would have to be exact.
    const std::array<double, 6> placement{uniform->origin.x,  uniform->origin.y,  uniform->origin.z,
                                          uniform->spacing.x, uniform->spacing.y, uniform->spacing.z};
    writer.values("placement.bin", std::span<const double>(placement));
  } else if (const auto* rectilinear = std::get_if<RectilinearGrid>(&grid.shape)) {
    const char* const names[3] = {"axis_x.bin", "axis_y.bin", "axis_z.bin"};
    for (std::size_t a = 0; a < 3; ++a) writer.values(names[a], std::span<const double>(rectilinear->axes[a]));
  } else if (const auto* curvilinear = std::get_if<CurvilinearGrid>(&grid.shape)) {
    manifest["points"] = write_points(curvilinear->points, writer);
  } else {
    const auto& unstructured = std::get<UnstructuredGrid>(grid.shape);
    manifest["points"] = write_points(unstructured.points, writer);
    manifest["cells"] = unstructured.types.size();
    manifest["connectivity"] = unstructured.connectivity.size();
    writer.values("types.bin", unstructured.types);
    writer.values("offsets.bin", unstructured.offsets);
    writer.values("connectivity.bin", unstructured.connectivity);
  }
  manifest["hidden_cells"] = !grid.hidden_cells.empty();
  if (!grid.hidden_cells.empty()) writer.values("hidden.bin", grid.hidden_cells);
}

std::string array_file(std::size_t number) { return "array_" + std::to_string(number) + ".bin"; }

/// Writes the arrays one by one and lists them in the manifest.
class ArrayWriter {
 public:
  ArrayWriter(Writer& writer, json::array& list) : writer_(writer), list_(list) {}

  /// How many places of the list the array takes: its own, or its magnitude's and its components'.
  static std::size_t places(const FileArray& array) { return array.components == 1 ? 1 : 1 + static_cast<std::size_t>(array.components); }

  /// Values on cells, whose means take this place of the list and the next ones. Before the means, so that they are written while those are found.
  void add_cells(const FileArray& cells, std::size_t place) {
    add_parts(cells, "", [&](const std::string&, const std::string&, ScalarType type, std::span<const std::byte> bytes) {
      json::object& entry = of_cells_[place];
      entry["cell_type"] = to_string(type);
      if (json::object there; put_in_place(bytes, type, there))
        entry["cells"] = std::move(there);
      else
        writer_.file("cells_" + std::to_string(place) + ".bin", bytes, cells.storage);
      ++place;
    });
  }

  void add(const FileArray& array, const std::string& base) {
    add_parts(array, base, [&](std::string name, const std::string& component, ScalarType type, std::span<const std::byte> bytes) {
      write(array, std::move(name), component, type, bytes);
    });
  }

 private:
  /// put(name, component, type, values) for the array, or for its magnitude and each component.
  template <class Put>
  void add_parts(const FileArray& array, const std::string& base, const Put& put) {
    if (array.components == 1) {
      put(base, "", array.type, array.values);
      return;
    }
    const auto put_away = [&](const std::string& name, const std::string& component, ScalarType type, std::span<const std::byte> bytes) {
      put(name, component, type, bytes);
      writer_.wait();
    };
    static constexpr const char* kAxes[3] = {"x", "y", "z"};
    std::visit(
        [&](auto values) {
          using T = typename decltype(values)::value_type;
          const auto components = static_cast<std::size_t>(array.components);
          const std::size_t n = values.size() / components;
          // The magnitude keeps single precision for float32 and for integers that it holds exactly.
          if constexpr (sizeof(T) <= 2 || std::is_same_v<T, float>)
            put_away(base, "magnitude", ScalarType::float32, std::as_bytes(std::span<const float>(magnitude<float>(values, components))));
          else
            put_away(base, "magnitude", ScalarType::float64, std::as_bytes(std::span<const double>(magnitude<double>(values, components))));
          std::vector<T> one(n);
          for (std::size_t c = 0; c < components; ++c) {
            for (std::size_t p = 0; p < n; ++p) one[p] = values[p * components + c];
            const std::string component = components <= 3 ? kAxes[c] : std::to_string(c);
            put_away(base + "_" + component, component, array.type, std::as_bytes(std::span<const T>(one)));
          }
        },
        scalar_span(array.type, array.values));
  }

  template <class Out, class T>
  std::vector<Out> magnitude(std::span<const T> values, std::size_t components) {
    std::vector<Out> out(values.size() / components);
    for (std::size_t p = 0; p < out.size(); ++p) {
      double sum = 0;
      for (std::size_t c = 0; c < components; ++c) {
        const auto value = static_cast<double>(values[p * components + c]);
        sum += value * value;
      }
      out[p] = static_cast<Out>(std::sqrt(sum));
    }
    return out;
  }

  void write(const FileArray& array, std::string name, const std::string& component, ScalarType type,
             std::span<const std::byte> bytes) {
    for (int n = 2; !names_.insert(name).second; ++n) name = name.substr(0, name.rfind(" #")) + " #" + std::to_string(n);
    json::object entry{{"name", name},
                       {"association", array.on_cells ? "cell_averaged" : "point"},
                       {"components", array.components},
                       {"component", component},
                       {"unit", valid_utf8(array.unit.substr(0, 100))},
                       {"type", to_string(type)}};
    if (!put_in_place(bytes, type, entry)) writer_.file(array_file(list_.size()), bytes, array.storage);
    if (const auto cells = of_cells_.find(list_.size()); cells != of_cells_.end()) entry.insert(cells->second.begin(), cells->second.end());
    list_.push_back(std::move(entry));
  }

  /// Says in `entry` where they lie; false if they have to be written.
  bool put_in_place(std::span<const std::byte> bytes, ScalarType type, json::object& entry) const {
    const auto place = writer_.in_place(bytes, size_of(type));
    if (!place || valid_utf8(place->file.string()) != place->file.string()) return false;
    entry["in_file"] = place->file.string();
    entry["offset"] = place->offset;
    return true;
  }

  Writer& writer_;
  json::array& list_;
  std::set<std::string> names_;
  std::map<std::size_t, json::object> of_cells_;  // by places of the list
};

}  // namespace

void write_dataset(Imported imported, const ReadRequest& request, const std::filesystem::path& directory) {
  const bool like = imported.blocks.size() == 1 && imported.blocks.front().like;
  const Block block = like ? std::move(imported.blocks.front()) : append_blocks(imported, request);
  Writer writer(directory, request);
  json::object manifest;
  manifest["format"] = 1;
  write_grid(block, writer, manifest);

  std::set<std::string> point_names;
  for (const FileArray& array : block.arrays)
    if (!array.on_cells) point_names.insert(array.name);
  json::array arrays;
  ArrayWriter array_writer(writer, arrays);
  std::size_t place = 0;
  for (const FileArray& array : block.arrays) {
    if (array.on_cells) array_writer.add_cells(array, place);
    place += ArrayWriter::places(array);
  }
  CellMeans means(block, request);
  std::size_t done = 0;
  for (const FileArray& array : block.arrays) {
    const std::string name =
        printable(array.on_cells && point_names.contains(array.name) ? array.name + " (cell)" : array.name, 200);
    array_writer.add(array.on_cells ? means.next(array.components == 1 ? array_file(arrays.size()) : "means.bin") : array, name);
    request.progress(0.5 + 0.5 * static_cast<double>(++done) / static_cast<double>(block.arrays.size()));
  }
  manifest["arrays"] = std::move(arrays);
  json::array axes;
  for (const Axis& axis : imported.axes)
    axes.push_back(json::object{{"name", printable(axis.name, 100)}, {"unit", printable(axis.unit, 100)}, {"downward", axis.downward}});
  manifest["axes"] = std::move(axes);

  writer.values("times.bin", std::span<const double>(imported.times));
  manifest["times"] = imported.times.size();
  manifest["step"] = request.step;
  json::array notes;
  for (const std::string& note : imported.notes)
    if (notes.size() < 100) notes.push_back(json::string(printable(note, 400)));
  manifest["notes"] = std::move(notes);
  const std::string text = json::serialize(manifest);
  writer.sweep();
  writer.wait();
  writer.values("manifest.json", std::span<const char>(text));  // last: without it the rest means nothing
  writer.wait();
}

}  // namespace isostrata
