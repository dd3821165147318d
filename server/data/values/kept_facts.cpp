#include "data/values/kept_facts.h"

#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <iterator>
#include <map>
#include <mutex>
#include <system_error>

namespace isostrata {
namespace {

namespace fs = std::filesystem;

struct Place {
  std::weak_ptr<const void> storage;
  fs::path folder;
  std::string prefix;
};

std::mutex mutex;  // guards `places`
std::map<const void*, Place>& places() {
  static auto* const all = new std::map<const void*, Place>;
  return *all;
}

std::optional<fs::path> file_of(const PointArray& array, const std::string& name) {
  const std::lock_guard lock(mutex);
  const auto at = array.storage ? places().find(array.storage.get()) : places().end();
  if (at == places().end() || at->second.storage.lock() != array.storage) return std::nullopt;
  return at->second.folder / (at->second.prefix + name);
}

/// FNV-1a by words: G. Fowler, L. C. Noll, K.-P. Vo.
std::uint64_t checksum(std::span<const std::byte> bytes) {
  std::uint64_t hash = 0xcbf29ce484222325u;
  for (std::size_t at = 0; at < bytes.size(); at += 8) {
    std::uint64_t word = bytes.size();
    std::memcpy(&word, bytes.data() + at, std::min<std::size_t>(8, bytes.size() - at));
    hash = (hash ^ word) * 0x100000001b3u;
  }
  return hash;
}

}  // namespace

void set_place_of_facts(const std::shared_ptr<const void>& storage, fs::path folder, std::string prefix) {
  if (!storage) return;
  const std::lock_guard lock(mutex);
  std::erase_if(places(), [](const auto& of) { return of.second.storage.expired(); });
  places()[storage.get()] = {storage, std::move(folder), std::move(prefix)};
}

std::optional<std::vector<std::byte>> read_checked(const fs::path& file) {
  std::error_code error;
  const auto size = fs::file_size(file, error);
  std::uint64_t sum = 0;
  if (error || size < sizeof sum) return std::nullopt;
  std::ifstream in(file, std::ios::binary);
  std::vector<std::byte> bytes(size - sizeof sum);
  in.read(reinterpret_cast<char*>(&sum), sizeof sum);
  in.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  if (!in || checksum(bytes) != sum) return std::nullopt;
  return bytes;
}

bool write_checked(const fs::path& file, std::span<const std::byte> bytes) {
  const std::uint64_t sum = checksum(bytes);
  std::ofstream out(file, std::ios::binary);
  out.write(reinterpret_cast<const char*>(&sum), sizeof sum);
  out.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  out.flush();
  return bool(out);
}

std::optional<std::vector<std::byte>> kept_fact(const PointArray& array, const std::string& name) {
  const auto file = file_of(array, name);
  return file ? read_checked(*file) : std::nullopt;
}

void keep_fact(const PointArray& array, const std::string& name, std::span<const std::byte> bytes) {
  const auto file = file_of(array, name);
  std::error_code error;
  if (!file || fs::space(file->parent_path(), error).available < 2 * bytes.size() || error) return;
  const fs::path part = file->string() + ".part-" + std::to_string(getpid()) + '-' + std::to_string(reinterpret_cast<std::uintptr_t>(bytes.data()));
  if (!write_checked(part, bytes)) error = std::make_error_code(std::errc::io_error);
  if (!error) fs::rename(part, *file, error);
  if (error) fs::remove(part, error);
}

}  // namespace isostrata
