// NumPy's .npz: a ZIP archive of .npy files. The largest array and all that have its axes.
//
// ".ZIP File Format Specification", PKWARE, 6.3: directory at the end, ZIP64, stored and deflated files.
#include <zlib.h>

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <string_view>

#include "import/bytes/mapped_file.h"
#include "import/imported/read_own.h"

namespace isostrata {
namespace {

constexpr std::size_t kNotFound = std::string_view::npos;

struct ZipMember {
  std::string name;
  std::uint64_t packed = 0, size = 0, header = 0;
  int method = 0;  // 0: stored, 8: deflated
};

class ZipArchive {
 public:
  ZipArchive(std::span<const std::byte> bytes, std::string name) : bytes_(reinterpret_cast<const char*>(bytes.data()), bytes.size()), name_(std::move(name)) {
    const std::size_t tail = bytes_.size() - std::min<std::size_t>(bytes_.size(), 65'557), end = bytes_.rfind("PK\5\6");
    if (end == kNotFound || end < tail) bad("has no directory at its end; is it cut off?");
    std::uint64_t count = number(end + 10, 2), at = number(end + 16, 4);
    if (end >= 20 && bytes_.substr(end - 20, 4) == std::string_view("PK\6\7")) {
      const std::uint64_t wide = number(end - 12, 8);
      count = number(wide + 32, 8);
      at = number(wide + 48, 8);
    }
    if (count > 100'000) bad("has " + std::to_string(count) + " files; expected at most 100000");
    for (; count > 0; --count) at = take(at);
  }
  const std::vector<ZipMember>& members() const { return members_; }

  /// Where what is stored of one begins.
  std::string_view stored(const ZipMember& of) const {
    if (number(of.header, 4) != 0x04034b50) bad("'" + of.name + "' is not where the directory says");
    const std::uint64_t begin = of.header + 30 + number(of.header + 26, 2) + number(of.header + 28, 2);
    if (begin > bytes_.size() || of.packed > bytes_.size() - begin) bad("ends within '" + of.name + "'");
    return bytes_.substr(begin, of.packed);
  }
  [[noreturn]] void bad(const std::string& why) const { throw Error(ErrorCode::bad_data, name_ + ": " + why); }

 private:
  std::uint64_t number(std::uint64_t at, int bytes) const {
    if (at > bytes_.size() || static_cast<std::uint64_t>(bytes) > bytes_.size() - at) bad("ends within its directory");
    std::uint64_t value = 0;
    for (int b = bytes - 1; b >= 0; --b) value = value << 8 | static_cast<unsigned char>(bytes_[at + static_cast<std::uint64_t>(b)]);
    return value;
  }
  std::uint64_t take(std::uint64_t at) {
    if (number(at, 4) != 0x02014b50) bad("has a damaged directory");
    ZipMember of;
    of.method = static_cast<int>(number(at + 10, 2));
    of.packed = number(at + 20, 4);
    of.size = number(at + 24, 4);
    of.header = number(at + 42, 4);
    const std::uint64_t name = number(at + 28, 2), extra = number(at + 30, 2), comment = number(at + 32, 2), next = at + 46 + name + extra + comment;
    if (number(at + 8, 2) & 1) throw Error(ErrorCode::unsupported, name_ + ": is encrypted");
    if (next > bytes_.size()) bad("ends within its directory");
    of.name = bytes_.substr(at + 46, name);
    for (std::uint64_t e = at + 46 + name; e + 4 <= at + 46 + name + extra; e += 4 + number(e + 2, 2)) {
      if (number(e, 2) != 1) continue;
      std::uint64_t field = e + 4;  // of those that do not fit, in this order
      for (std::uint64_t* value : {&of.size, &of.packed, &of.header})
        if (*value == 0xffffffffu) *value = number(field, 8), field += 8;
      break;
    }
    members_.push_back(std::move(of));
    return next;
  }

  std::string_view bytes_;
  std::string name_;
  std::vector<ZipMember> members_;
};

/// A file of the scratch folder that goes with it; what was mapped of it stays.
class Extracted {
 public:
  Extracted(const ZipArchive& archive, const ZipMember& member, const ReadRequest& request) : path_(request.scratch / "member.npy") {
    std::FILE* const out = std::fopen(path_.c_str(), "wb");
    const bool written = out && (member.method == 0 ? put(out, archive.stored(member)) : inflate_to(out, archive, member));
    if ((out && std::fclose(out) != 0) || !written) {
      std::remove(path_.c_str());
      throw Error(ErrorCode::unavailable, "cannot write to a temporary file: no room");
    }
  }
  ~Extracted() { std::remove(path_.c_str()); }
  Extracted(const Extracted&) = delete;
  Extracted& operator=(const Extracted&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  static bool put(std::FILE* out, std::string_view bytes) { return std::fwrite(bytes.data(), 1, bytes.size(), out) == bytes.size(); }
  static bool inflate_to(std::FILE* out, const ZipArchive& archive, const ZipMember& member) {
    std::string_view from = archive.stored(member);
    z_stream stream{};
    if (inflateInit2(&stream, -15) != Z_OK) return false;
    std::string room(1 << 20, '\0');
    std::uint64_t made = 0;
    int state = Z_OK;
    bool written = true;
    while (state == Z_OK && written && made <= member.size) {
      const std::size_t in = std::min(from.size(), std::size_t{1} << 30);
      stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(from.data()));
      stream.avail_in = static_cast<uInt>(in);
      stream.next_out = reinterpret_cast<Bytef*>(room.data());
      stream.avail_out = static_cast<uInt>(room.size());
      state = inflate(&stream, Z_NO_FLUSH);
      from.remove_prefix(in - stream.avail_in);
      const std::size_t got = room.size() - stream.avail_out;
      made += got;
      written = put(out, std::string_view(room).substr(0, got));
    }
    inflateEnd(&stream);
    if (written && (state != Z_STREAM_END || made != member.size)) archive.bad("'" + member.name + "' is damaged");
    return written;
  }

  std::filesystem::path path_;
};

}  // namespace

Imported read_npz(const ReadRequest& request) {
  const std::string name = request.file.filename().string();
  check_step(request, 1);
  const MappedFile file(request.file);
  const ZipArchive archive(file.bytes(), name);
  std::vector<ZipMember> members = archive.members();
  std::stable_sort(members.begin(), members.end(), [](const ZipMember& a, const ZipMember& b) { return a.size > b.size; });
  Imported imported;
  std::string skipped;
  std::uint64_t bytes = 0;
  for (const ZipMember& member : members) {
    const std::string of = member.name.ends_with(".npy") ? member.name.substr(0, member.name.size() - 4) : member.name;
    ReadRequest inner = request;
    try {
      if (member.method != 0 && member.method != 8) throw Error(ErrorCode::unsupported, name + ": '" + member.name + "' is packed by method " + std::to_string(member.method));
      check_bytes(request, bytes += std::min(member.size, request.max_bytes + 1), name);
      const Extracted extracted(archive, member, request);
      inner.file = extracted.path();
      Imported one = read_numpy(inner);
      Block& block = one.blocks.front();
      block.arrays.front().name = of;
      if (imported.blocks.empty()) imported = std::move(one);
      else if (block.grid.dims() == imported.blocks.front().grid.dims()) imported.blocks.front().arrays.push_back(std::move(block.arrays.front()));
      else skipped += (skipped.empty() ? "" : ", ") + of;
    } catch (const Error& error) {
      if (error.code() != ErrorCode::unsupported) throw Error(error.code(), name + ", '" + of.substr(0, 80) + "': " + error.what());
      skipped += (skipped.empty() ? "" : ", ") + of;
    }
  }
  if (imported.blocks.empty()) throw Error(ErrorCode::unsupported, name + ": no array of one to three axes of whole or real numbers" + (skipped.empty() ? "" : "; it has " + skipped.substr(0, 200)));
  if (!skipped.empty()) imported.notes.push_back("skipped, of other axes or types: " + skipped.substr(0, 200));
  return imported;
}

}  // namespace isostrata
