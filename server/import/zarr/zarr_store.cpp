#include "import/zarr/zarr_store.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <boost/json/parse.hpp>
#include <cerrno>
#include <cstring>
#include <string_view>

#include "base/descriptor.h"
#include "base/error.h"
#include "data/files/beneath.h"

namespace isostrata {
namespace {

namespace fs = std::filesystem;
namespace json = boost::json;

bool is_inside(const fs::path& path, const fs::path& folder) { return std::mismatch(folder.begin(), folder.end(), path.begin(), path.end()).first == folder.end(); }

/// Python writes numbers that JSON has not as bare words; here they become texts, as the specification has them.
std::string with_quoted_words(std::string_view text) {
  std::string out;
  bool quoted = false;
  for (std::size_t at = 0; at < text.size();) {
    std::size_t length = 1;
    if (quoted && text[at] == '\\') length = 2;
    if (text[at] == '"') quoted = !quoted;
    for (const std::string_view word : {"NaN", "-Infinity", "Infinity"})
      if (!quoted && text.substr(at).starts_with(word)) length = word.size();
    const bool word = !quoted && length > 1;
    out.append(word ? "\"" : "").append(text.substr(at, length)).append(word ? "\"" : "");
    at += length;
  }
  return out;
}

}  // namespace

ZarrStore::ZarrStore(const fs::path& folder) {
  std::error_code error;
  const fs::path plain = plain_folder(folder);
  name_ = plain.filename().string();
  folder_ = fs::canonical(plain, error);
  if (error) throw Error(ErrorCode::not_found, name_ + ": cannot be opened: " + error.message());
}

std::optional<std::uint64_t> ZarrStore::size_of(const std::string& file) const {
  std::error_code error;
  const std::uint64_t bytes = fs::file_size(folder_ / file, error);
  return error ? std::nullopt : std::optional(bytes);
}

bool ZarrStore::has(const std::string& file) const {
  std::error_code error;
  return fs::exists(folder_ / file, error);
}

std::vector<std::string> ZarrStore::parts(std::size_t most_parts) const {
  std::vector<std::string> names;
  std::error_code error;
  int most = 1000;
  for (fs::directory_iterator it(folder_, error), end; !error && it != end && --most > 0 && names.size() < most_parts; it.increment(error))
    if (const std::string name = it->path().filename().string(); has(name + "/.zarray") || has(name + "/.zgroup") || has(name + "/zarr.json")) names.push_back(name);
  std::sort(names.begin(), names.end());
  return names;
}

Descriptor ZarrStore::open_file(const std::string& file, std::uint64_t& size) {
  const auto bad = [&](ErrorCode code, const std::string& why) { return Error(code, name_of(file) + ": " + why); };
  fs::path path = folder_ / file;
  std::error_code error;
  const auto look = [&](const fs::path& at) {
    const fs::path real = fs::canonical(at, error);
    if (!error && !is_inside(real, folder_)) throw bad(ErrorCode::bad_data, "lies outside of the folder, by a link; expected a file in it");
    return real;
  };
  if (path.parent_path() != inside_) {
    look(path.parent_path());
    if (error) return Descriptor();
    inside_ = path.parent_path();
  }
  constexpr int kFlags = O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC;
  Descriptor opened(open(path.c_str(), kFlags));
  if (opened.get() < 0 && errno == ELOOP) {
    const fs::path real = look(path);
    opened = Descriptor(error ? -1 : open(real.c_str(), kFlags));
  }
  if (opened.get() < 0 && (errno == ENOENT || errno == ENOTDIR)) return Descriptor();
  struct stat about {};
  if (opened.get() < 0 || fstat(opened.get(), &about) != 0) throw bad(ErrorCode::unavailable, std::string("cannot be read: ") + std::strerror(errno));
  if (!S_ISREG(about.st_mode)) throw bad(ErrorCode::bad_data, "is not a regular file");
  size = static_cast<std::uint64_t>(about.st_size);
  return opened;
}

void ZarrStore::read_bytes(const std::string& file, const Descriptor& from, std::uint64_t at, std::vector<std::byte>& bytes) const {
  for (std::size_t done = 0; done < bytes.size();) {
    const ssize_t got = pread(from.get(), bytes.data() + done, bytes.size() - done, static_cast<off_t>(at + done));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) throw Error(ErrorCode::unavailable, name_of(file) + ": " + (got < 0 ? std::string("cannot be read: ") + std::strerror(errno) : "became shorter while it was read"));
    done += static_cast<std::size_t>(got);
  }
}

bool ZarrStore::read(const std::string& file, std::size_t most, std::vector<std::byte>& bytes) {
  std::uint64_t size = 0;
  const Descriptor opened = open_file(file, size);
  if (opened.get() < 0) return false;
  if (size > most) throw Error(ErrorCode::bad_data, name_of(file) + ": has " + std::to_string(size) + " bytes; expected at most " + std::to_string(most));
  bytes.resize(static_cast<std::size_t>(size));
  read_bytes(file, opened, 0, bytes);
  return true;
}

bool ZarrStore::read_part(const std::string& file, std::uint64_t from, std::size_t count, std::vector<std::byte>& bytes) {
  std::uint64_t size = 0;
  const Descriptor opened = open_file(file, size);
  if (opened.get() < 0) return false;
  if (from > size || count > size - from) throw Error(ErrorCode::bad_data, name_of(file) + ": is cut off: has " + std::to_string(size) + " bytes; expected " + std::to_string(count) + " from " + std::to_string(from) + " on");
  bytes.resize(count);
  read_bytes(file, opened, from, bytes);
  return true;
}

std::optional<json::object> ZarrStore::read_json(const std::string& file) {
  constexpr std::size_t kMost = std::size_t{16} << 20;
  std::vector<std::byte> bytes;
  if (!read(file, kMost, bytes)) return std::nullopt;
  boost::system::error_code error;
  json::value document = json::parse(with_quoted_words({reinterpret_cast<const char*>(bytes.data()), bytes.size()}), error);
  if (error) throw Error(ErrorCode::bad_data, name_of(file) + ": is not valid JSON: " + error.message());
  if (!document.is_object()) throw Error(ErrorCode::bad_data, name_of(file) + ": expected an object of JSON, {...}");
  return std::move(document.as_object());
}

}  // namespace isostrata
