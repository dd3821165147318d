// Tecplot's binary format, version 112: "Tecplot 360 Data Format Guide", appendix "Binary Data File Format".
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>

#include "import/bytes/swap_bytes.h"
#include "import/tecplot/tecplot_zone.h"

namespace isostrata {
namespace {

constexpr float kZone = 299, kGeometry = 399, kText = 499, kLabels = 599, kUser = 699, kData = 799, kVariable = 899, kEndOfHeader = 357;
constexpr std::int32_t kMostVariables = 10'000, kLongestText = 100'000;

class Bytes {
 public:
  Bytes(std::span<const std::byte> bytes, const std::string& name) : bytes_(bytes), name_(name) {}

  template <class T>
  T number() {
    T value{};
    std::memcpy(&value, take(sizeof value).data(), sizeof value);
    if (!swap_) return value;
    std::array<std::byte, sizeof(T)> turned{};
    std::memcpy(turned.data(), &value, sizeof value);
    swap_bytes(turned, sizeof value);
    std::memcpy(&value, turned.data(), sizeof value);
    return value;
  }
  std::int32_t whole(const char* what, std::int32_t least, std::int32_t most) {
    const auto value = number<std::int32_t>();
    if (value < least || value > most) refuse(std::string(what) + " is " + std::to_string(value) + "; expected " + std::to_string(least) + " to " + std::to_string(most));
    return value;
  }
  bool truth(const char* what) { return whole(what, 0, 1) == 1; }
  /// A letter in each whole number, until 0.
  std::string text() {
    std::string out;
    for (std::int32_t letter = 0; (letter = number<std::int32_t>()) != 0;) {
      if (std::ssize(out) >= kLongestText) refuse("a text of more than " + std::to_string(kLongestText) + " letters");
      out += static_cast<char>(letter);
    }
    return out;
  }
  std::span<const std::byte> take(std::size_t count) {
    if (count > bytes_.size() - at_) refuse("is cut off: " + std::to_string(count) + " bytes expected at byte " + std::to_string(at_) + ", " + std::to_string(bytes_.size() - at_) + " present");
    at_ += count;
    return bytes_.subspan(at_ - count, count);
  }
  void find_order() {
    if (number<std::int32_t>() == 1) return;
    swap_ = true;
    at_ -= sizeof(std::int32_t);
    if (number<std::int32_t>() != 1) refuse("expected the whole number 1 behind its version, which tells the order of bytes");
  }
  bool swapped() const { return swap_; }
  std::size_t at() const { return at_; }
  [[noreturn]] void refuse(const std::string& why) const { throw Error(ErrorCode::bad_data, name_ + ": " + why); }
  [[noreturn]] void lack(const std::string& why) const { throw Error(ErrorCode::unsupported, name_ + ": " + why + "; save it as CGNS, or as .vtu (ParaView: Save Data)"); }

 private:
  std::span<const std::byte> bytes_;
  const std::string& name_;
  std::size_t at_ = 0;
  bool swap_ = false;
};

void skip_pairs(Bytes& bytes) {
  while (bytes.truth("whether more is said of a zone")) {
    bytes.text();
    bytes.number<std::int32_t>();
    bytes.text();
  }
}

/// What the header says of a zone, and how many connections of faces follow its numbers.
struct Declared {
  TecplotZone zone;
  bool faces = false;  // of each element the neighbours
  std::int64_t connections = 0;
  std::int32_t mode = 0;
};

Declared declared_zone(Bytes& bytes, std::size_t variables, const std::string& name) {
  Declared out;
  TecplotZone& zone = out.zone;
  zone.name = bytes.text();
  bytes.number<std::int32_t>();  // its parent
  const auto strand = bytes.number<std::int32_t>();
  zone.time = bytes.number<double>();
  if (!std::isfinite(zone.time)) bytes.refuse("the time of a zone is not a finite number");
  zone.timed = strand > 0 || strand == -2;  // -2: Tecplot finds out which
  bytes.number<std::int32_t>();
  const std::int32_t kind = bytes.whole("the type of a zone", 0, 7);
  if (kind > 5) bytes.lack("zone '" + zone.name.substr(0, 40) + "' is of polygons or polyhedra, which are not read in this format");
  zone.kind = static_cast<TecplotKind>(kind);
  zone.values.resize(variables);
  if (bytes.truth("whether variables say where they are"))
    for (TecplotValues& of : zone.values) of.on_cells = bytes.truth("where a variable is");
  out.faces = bytes.truth("whether neighbours are given");
  out.connections = bytes.whole("the number of connections", 0, std::numeric_limits<std::int32_t>::max());
  if (out.connections > 0) {
    out.mode = bytes.whole("the mode of connections", 0, 3);
    if (kind > 0) bytes.number<std::int32_t>();
  }
  constexpr std::int32_t kMost = std::numeric_limits<std::int32_t>::max();
  if (kind == 0) {
    std::array<std::int64_t, 3> dims{};
    for (std::int64_t& size : dims) size = bytes.whole("a size of a zone", 1, kMost);
    zone.set_ordered(dims, name);
  } else {
    zone.points = bytes.whole("the number of points", 0, kMost);
    zone.cells = bytes.whole("the number of elements", 0, kMost);
    for (int unused = 0; unused < 3; ++unused) bytes.number<std::int32_t>();
  }
  skip_pairs(bytes);
  return out;
}

ScalarType type_of(Bytes& bytes) {
  switch (bytes.whole("the type of a variable", 1, 6)) {
    case 1: return ScalarType::float32;
    case 2: return ScalarType::float64;
    case 3: return ScalarType::int32;
    case 4: return ScalarType::int16;
    case 5: return ScalarType::uint8;
    default: bytes.lack("a variable is of bits");
  }
}

/// With the places beside cells: along the last axis alone there is one fewer.
std::int64_t stored_cells(const TecplotZone& zone) {
  if (zone.kind != TecplotKind::ordered) return zone.cells;
  std::array<std::int64_t, 3> size = zone.dims;
  for (std::size_t a = 3; a-- > 0;)
    if (size[a] > 1) {
      --size[a];
      break;
    }
  return checked_product({size[0], size[1], size[2]}, "a zone");
}

void find_numbers(Bytes& bytes, Declared& of, int number, std::size_t zones) {
  TecplotZone& zone = of.zone;
  if (bytes.number<float>() != kZone) bytes.refuse("expected the numbers of zone " + std::to_string(number + 1) + " at byte " + std::to_string(bytes.at()));
  for (TecplotValues& values : zone.values) values.type = type_of(bytes);
  if (bytes.truth("whether variables have no values"))
    for (TecplotValues& values : zone.values) values.passive = bytes.truth("whether a variable has no values");
  if (bytes.truth("whether values are shared"))
    for (TecplotValues& values : zone.values) values.shared_with = bytes.whole("the zone that values are shared with", -1, static_cast<std::int32_t>(zones) - 1);
  zone.mesh_of = bytes.whole("the zone that elements are shared with", -1, static_cast<std::int32_t>(zones) - 1);
  const auto own = [](const TecplotValues& values) { return !values.passive && values.shared_with < 0; };
  for (const TecplotValues& values : zone.values)
    if (own(values)) bytes.take(2 * sizeof(double));  // the least and the greatest
  for (TecplotValues& values : zone.values) {
    if (!own(values)) continue;
    values.at = bytes.at();
    values.stored = static_cast<std::size_t>(values.on_cells ? stored_cells(zone) : zone.points);
    bytes.take(values.stored * size_of(values.type));
  }
  const auto whole = [&](std::int64_t count) { bytes.take(static_cast<std::size_t>(checked_product({count, 4}, "a zone"))); };
  zone.at = bytes.at();
  if (zone.kind != TecplotKind::ordered && zone.mesh_of < 0) {
    whole(checked_product({zone.cells, tecplot_nodes(zone.kind)}, "a zone"));
    constexpr std::array<int, 6> kFaces{0, 2, 3, 4, 4, 6};
    if (of.faces) whole(checked_product({zone.cells, kFaces[static_cast<std::size_t>(zone.kind)]}, "a zone"));
  }
  if (of.connections == 0) return;
  if (of.mode != 0 && of.mode != 2) bytes.lack("faces of zone " + std::to_string(number + 1) + " have several neighbours");
  whole(checked_product({of.connections, of.mode == 0 ? 3 : 4}, "a zone"));
}

/// What stands between the zones of the header.
void skip_record(Bytes& bytes, float mark) {
  if (mark == kLabels) {
    for (std::int32_t count = bytes.whole("the number of labels", 0, kMostVariables); count > 0; --count) bytes.text();
  } else if (mark == kUser) {
    bytes.text();
  } else if (mark == kData || mark == kVariable) {
    if (mark == kVariable) bytes.number<std::int32_t>();
    bytes.text();
    bytes.number<std::int32_t>();
    bytes.text();
  } else if (mark == kGeometry || mark == kText) {
    bytes.lack("has texts or drawings beside its zones");
  } else {
    bytes.refuse("expected a zone or the end of the header at byte " + std::to_string(bytes.at() - sizeof(float)));
  }
}

}  // namespace

TecplotFile tecplot_binary(std::span<const std::byte> all, const std::string& name) {
  Bytes bytes(all, name);
  const auto mark = bytes.take(8);
  const std::string version(reinterpret_cast<const char*>(mark.data()) + 5, 3);
  if (version != "112") bytes.lack("is of version " + version + " of Tecplot's binary format; expected 112, of Tecplot 360 since 2009");
  bytes.find_order();
  if (bytes.whole("the kind of the file", 0, 2) != 0) bytes.lack("has the points or the values alone, the others being in a file beside it");
  bytes.text();
  TecplotFile out;
  for (std::int32_t count = bytes.whole("the number of variables", 0, kMostVariables); count > 0; --count) out.variables.push_back(bytes.text());
  std::vector<Declared> zones;
  for (float next = 0; (next = bytes.number<float>()) != kEndOfHeader;)
    if (next == kZone)
      zones.push_back(declared_zone(bytes, out.variables.size(), name));
    else
      skip_record(bytes, next);
  for (std::size_t z = 0; z < zones.size(); ++z) find_numbers(bytes, zones[z], static_cast<int>(z), zones.size());
  for (Declared& one : zones) out.zones.push_back(std::move(one.zone));
  return out;
}

TecplotNumbers load_tecplot_binary(std::span<const std::byte> bytes, const TecplotFile& file, const TecplotZone& zone, const std::string& name) {
  Bytes order(bytes, name);
  order.take(8);
  order.find_order();
  TecplotNumbers out;
  for (std::size_t v = 0; v < file.variables.size(); ++v) {
    const TecplotValues& of = zone.values[v];
    FileArray& array = out.values.emplace_back();
    if (of.passive || of.shared_with >= 0) continue;
    array.on_cells = of.on_cells;
    array.type = of.type;
    const std::size_t width = size_of(of.type), count = static_cast<std::size_t>(zone.count(of));
    auto [storage, values] = allocate<std::byte>(count * width);
    const std::byte* from = bytes.data() + of.at;
    if (!of.on_cells || zone.kind != TecplotKind::ordered) {
      std::memcpy(values.data(), from, values.size());
    } else {
      std::array<std::size_t, 3> cells{};
      for (std::size_t a = 0; a < 3; ++a) cells[a] = static_cast<std::size_t>(std::max<std::int64_t>(zone.dims[a] - 1, 1));
      const auto i = static_cast<std::size_t>(zone.dims[0]), j = static_cast<std::size_t>(zone.dims[1]);
      const std::size_t row = zone.dims[1] > 1 || zone.dims[2] > 1 ? i : cells[0], sheet = zone.dims[2] > 1 ? row * j : row * cells[1];
      std::byte* to = values.data();
      for (std::size_t k = 0; k < cells[2]; ++k)
        for (std::size_t y = 0; y < cells[1]; ++y, to += cells[0] * width) std::memcpy(to, from + (k * sheet + y * row) * width, cells[0] * width);
    }
    if (order.swapped()) swap_bytes(values, width);
    array.values = values;
    array.storage = storage;
  }
  if (zone.kind == TecplotKind::ordered || zone.mesh_of >= 0) return out;
  const auto nodes = static_cast<std::size_t>(zone.cells) * static_cast<std::size_t>(tecplot_nodes(zone.kind));
  std::vector<std::int32_t> ids(nodes);
  std::memcpy(ids.data(), bytes.data() + zone.at, 4 * nodes);
  if (order.swapped()) swap_bytes(std::as_writable_bytes(std::span(ids)), 4);
  out.nodes.assign(ids.begin(), ids.end());
  return out;
}

}  // namespace isostrata
