#include "extraction/files/write_vtkhdf.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <limits>
#include <utility>
#include <vector>

#include "base/error.h"

namespace isostrata {
namespace {

constexpr std::uint64_t kNowhere = std::numeric_limits<std::uint64_t>::max();

/// B. Jenkins, lookup3.c, hashlittle(): what HDF5 checks its metadata by.
std::uint32_t lookup3(const std::string& bytes) {
  std::size_t left = bytes.size(), at = 0;
  std::uint32_t a = 0xdeadbeef + static_cast<std::uint32_t>(left), b = a, c = a;
  std::string padded = bytes;
  padded.append(12, '\0');
  const auto word = [&](std::size_t offset) {
    std::uint32_t value = 0;
    std::memcpy(&value, padded.data() + at + offset, sizeof value);
    return value;
  };
  if (left == 0) return c;
  for (; left > 12; left -= 12, at += 12) {
    a += word(0), b += word(4), c += word(8);
    a -= c, a ^= std::rotl(c, 4), c += b;
    b -= a, b ^= std::rotl(a, 6), a += c;
    c -= b, c ^= std::rotl(b, 8), b += a;
    a -= c, a ^= std::rotl(c, 16), c += b;
    b -= a, b ^= std::rotl(a, 19), a += c;
    c -= b, c ^= std::rotl(b, 4), b += a;
  }
  a += word(0), b += word(4), c += word(8);  // zeros behind the end add nothing
  c ^= b, c -= std::rotl(b, 14);
  a ^= c, a -= std::rotl(c, 11);
  b ^= a, b -= std::rotl(a, 25);
  c ^= b, c -= std::rotl(b, 16);
  a ^= c, a -= std::rotl(c, 4);
  b ^= a, b -= std::rotl(a, 14);
  c ^= b, c -= std::rotl(b, 24);
  return c;
}

template <class T>
void put(std::string& to, T value) {
  to.append(reinterpret_cast<const char*>(&value), sizeof value);
}
void put8(std::string& to, unsigned value) { to += static_cast<char>(value); }

/// "IV.A.2.d. The Datatype Message", of VTK's name of a type.
std::string datatype(const std::string& type) {
  const auto bytes = static_cast<std::uint32_t>(type.ends_with("64") ? 8 : type.ends_with("32") ? 4 : 1);
  const bool real = type.starts_with("Float"), wide = bytes == 8;
  std::string out;
  put8(out, real ? 0x11 : 0x10);                                          // version 1, class: floating-point or fixed-point
  put8(out, real ? 0x20 : type.starts_with("UInt") ? 0x00 : 0x08);  // little-endian; the leading bit is implied, or signed
  put8(out, real ? 8 * bytes - 1 : 0);                                    // where the sign is
  put8(out, 0);
  put(out, bytes);
  put(out, std::uint16_t{0});
  put(out, static_cast<std::uint16_t>(8 * bytes));
  if (!real) return out;
  put8(out, wide ? 52 : 23), put8(out, wide ? 11 : 8);  // exponent
  put8(out, 0), put8(out, wide ? 52 : 23);              // mantissa
  put(out, std::uint32_t{wide ? 1023u : 127u});
  return out;
}
std::string text_type(std::size_t length) {
  std::string out;
  put8(out, 0x13), put8(out, 1), put8(out, 0), put8(out, 0);  // a string padded with nulls, ASCII
  put(out, static_cast<std::uint32_t>(length));
  return out;
}

/// Of no dimension: one value.
std::string dataspace(const std::vector<std::uint64_t>& dims) {
  std::string out;
  put8(out, 2), put8(out, static_cast<unsigned>(dims.size())), put8(out, 0), put8(out, dims.empty() ? 0 : 1);
  for (const std::uint64_t n : dims) put(out, n);
  return out;
}

/// The messages of an object header of version 2.
class ObjectHeader {
 public:
  void add(unsigned type, const std::string& message) {
    put8(messages_, type);
    put(messages_, static_cast<std::uint16_t>(message.size()));
    put8(messages_, 0);
    messages_ += message;
  }
  void attribute(const std::string& name, const std::string& type, const std::string& space, const std::string& value) {
    std::string out;
    put8(out, 3), put8(out, 0);
    for (const std::size_t size : {name.size() + 1, type.size(), space.size()}) put(out, static_cast<std::uint16_t>(size));
    put8(out, 0);
    out += name + '\0' + type + space + value;
    add(0x0c, out);
  }
  /// Returns if it is.
  std::uint64_t write(OutputFile& out) const {
    const std::uint64_t at = out.size();
    std::string header = "OHDR";
    put8(header, 2), put8(header, 2);  // the size that follows has 4 bytes
    put(header, static_cast<std::uint32_t>(messages_.size()));
    header += messages_;
    put(header, lookup3(header));
    out.text(header);
    return at;
  }

 private:
  std::string messages_;
};

using Links = std::vector<std::pair<std::string, std::uint64_t>>;  // names and where the objects are

ObjectHeader group_of(const Links& links) {
  ObjectHeader group;
  std::string info;
  put8(info, 0), put8(info, 0);
  put(info, kNowhere), put(info, kNowhere);  // links lie in the header itself
  group.add(0x02, info);
  group.add(0x0a, std::string(2, '\0'));
  for (const auto& [name, at] : links) {
    std::string link;
    put8(link, 1), put8(link, 0x11), put8(link, 1);  // a hard link; its name is UTF-8, the length has 2 bytes
    put(link, static_cast<std::uint16_t>(name.size()));
    link += name;
    put(link, at);
    group.add(0x06, link);
  }
  return group;
}

class Hdf5Writer {
 public:
  Hdf5Writer(OutputFile& out, const Task& task) : out_(out), task_(task) { out_.text(std::string(kSuperblock, '\0')); }

  /// Writes the array and its header; returns where the header is.
  std::uint64_t array(const VtkArray& array) {
    align();
    const std::uint64_t at = out_.size(), bytes = array.count * array.item_bytes;
    write_plain(out_, array, task_);
    ObjectHeader header;
    std::vector<std::uint64_t> dims{array.count * (array.components > 1 ? 1 : array.item_bytes / size_of(array.type))};
    if (array.components > 1) dims.push_back(static_cast<std::uint64_t>(array.components));
    header.add(0x01, dataspace(dims));
    header.add(0x03, datatype(array.type));
    header.add(0x05, {3, 0x0a});  // no fill value
    std::string layout;
    put8(layout, 3), put8(layout, 1);  // contiguous
    put(layout, bytes > 0 ? at : kNowhere), put(layout, bytes);
    header.add(0x08, layout);
    align();
    return header.write(out_);
  }
  std::uint64_t header(const ObjectHeader& header) {
    align();
    return header.write(out_);
  }
  void finish(std::uint64_t root) {
    std::string block = "\x89HDF\r\n\x1a\n";
    put8(block, 2), put8(block, 8), put8(block, 8), put8(block, 0);
    put(block, std::uint64_t{0}), put(block, kNowhere), put(block, out_.size()), put(block, root);
    put(block, lookup3(block));
    out_.patch(0, std::as_bytes(std::span(block)));
  }

 private:
  static constexpr std::size_t kSuperblock = 48;
  static std::uint64_t size_of(const std::string& type) { return type.ends_with("64") ? 8 : type.ends_with("32") ? 4 : 1; }
  void align() { out_.text(std::string((8 - out_.size() % 8) % 8, '\0')); }

  OutputFile& out_;
  const Task& task_;
};

/// A slash would lead into a group.
std::string link_name(std::string name, const Links& taken) {
  std::replace(name.begin(), name.end(), '/', '_');
  if (name.empty() || name == "." || name.size() > 60000) name = "array";
  const auto is_taken = [&](const std::string& candidate) {
    return std::any_of(taken.begin(), taken.end(), [&](const auto& link) { return link.first == candidate; });
  };
  for (int n = 2; is_taken(name); ++n) name = name.substr(0, name.rfind(" #")) + " #" + std::to_string(n);
  return name;
}

VtkArray numbers(std::string name, std::uint64_t count, std::function<std::int64_t(std::uint64_t)> value) {
  return {"Int64", std::move(name), 1, count, sizeof(std::int64_t), [value = std::move(value)](std::uint64_t first, std::uint64_t last, std::byte* to) {
            for (std::uint64_t i = first; i < last; ++i, to += sizeof(std::int64_t)) {
              const std::int64_t of = value(i);
              std::memcpy(to, &of, sizeof of);
            }
          }};
}

}  // namespace

void write_vtkhdf(OutputFile& out, const IntervalMesh& mesh, const std::string& array_name, std::span<const MeshArray> more, const Task& task) {
  const std::vector<VtkSection> sections = mesh_sections(mesh, array_name, more);
  const VtkArray &connectivity = sections[3].arrays[0], &types = sections[3].arrays[2];
  const std::uint64_t np = mesh.positions.size(), cells = types.count;
  const std::uint64_t corners = mesh.tetrahedra.empty() && !mesh.facets.empty() ? 3 : 4;

  Hdf5Writer file(out, task);
  Links links;
  const auto add = [&](const VtkArray& array, const char* name) { links.emplace_back(name, file.array(array)); };
  const auto one = [](std::uint64_t value) { return numbers("", 1, [value](std::uint64_t) { return static_cast<std::int64_t>(value); }); };
  add(one(np), "NumberOfPoints");
  add(one(cells), "NumberOfCells");
  add(one(corners * cells), "NumberOfConnectivityIds");
  add(sections[2].arrays[0], "Points");
  add(connectivity, "Connectivity");
  if (connectivity.type == "Int32") {
    VtkArray offsets = numbers("", cells + 1, [corners](std::uint64_t i) { return static_cast<std::int64_t>(corners * i); });
    offsets.type = "Int32", offsets.item_bytes = sizeof(std::int32_t);  // both of one type
    offsets.fill = [corners](std::uint64_t first, std::uint64_t last, std::byte* to) {
      for (std::uint64_t i = first; i < last; ++i, to += sizeof(std::int32_t)) {
        const auto of = static_cast<std::int32_t>(corners * i);
        std::memcpy(to, &of, sizeof of);
      }
    };
    add(offsets, "Offsets");
  } else {
    add(numbers("", cells + 1, [corners](std::uint64_t i) { return static_cast<std::int64_t>(corners * i); }), "Offsets");
  }
  add(types, "Types");
  for (const std::size_t s : {0, 1}) {
    Links arrays;
    for (const VtkArray& array : sections[s].arrays) {
      const std::uint64_t at = file.array(array);
      arrays.emplace_back(link_name(array.name, arrays), at);
    }
    links.emplace_back(sections[s].tag, file.header(group_of(arrays)));
  }
  ObjectHeader group = group_of(links);
  std::string version;
  put(version, std::int64_t{1}), put(version, std::int64_t{0});
  group.attribute("Version", datatype("Int64"), dataspace({2}), version);
  const std::string type = "UnstructuredGrid";
  group.attribute("Type", text_type(type.size()), dataspace({}), type);
  const std::uint64_t at = file.header(group);
  const std::uint64_t root = file.header(group_of({{"VTKHDF", at}}));
  file.finish(root);
}

}  // namespace isostrata
