#include "import/imported/imported.h"

#include <algorithm>
#include <cstddef>
#include <string_view>

namespace isostrata {
namespace {

bool is_address(std::string_view name) {
  constexpr std::string_view kBegin = "Array 0x";
  return name.size() > kBegin.size() && name.starts_with(kBegin) && name.find_first_not_of("0123456789abcdefABCDEF", kBegin.size()) == std::string_view::npos;
}

}  // namespace

std::string name_or_place(const std::string& name, std::size_t place) { return name.empty() || is_address(name) ? "array " + std::to_string(place) : name; }

void check_bytes(const ReadRequest& request, std::uint64_t bytes, const std::string& what) {
  if (bytes > request.max_bytes)
    throw Error(ErrorCode::too_large,
                what + ": needs " + std::to_string(bytes) + " bytes, the limit is " + std::to_string(request.max_bytes));
}

std::int64_t checked_product(std::initializer_list<std::int64_t> sizes, const std::string& what) {
  std::int64_t product = 1;
  for (const std::int64_t size : sizes)
    if (size < 0 || __builtin_mul_overflow(product, size, &product) || product > (std::int64_t{1} << 62))
      throw Error(ErrorCode::bad_data, what + ": a size of " + std::to_string(size) + " makes no sense");
  return product;
}

void check_step(const ReadRequest& request, std::size_t steps) {
  if (request.step >= 0 && static_cast<std::size_t>(request.step) < steps) return;
  throw Error(ErrorCode::not_found, request.file.filename().string() + ": no step " + std::to_string(request.step) + "; it has " +
                                        (steps == 1 ? "one, step 0" : "steps 0 to " + std::to_string(steps - 1)));
}

void check_name_below(const std::filesystem::path& from, const std::string& name) {
  const std::filesystem::path wanted = std::filesystem::path(name).lexically_normal();
  if (wanted.is_absolute() || (!wanted.empty() && *wanted.begin() == ".."))
    throw Error(ErrorCode::bad_data, from.filename().string() + ": refers to '" + name + "'; expected a file below its own directory");
}

std::filesystem::path referred_file(const std::filesystem::path& from, const std::string& name) {
  namespace fs = std::filesystem;
  const fs::path directory = fs::weakly_canonical(from.parent_path());
  const fs::path wanted(name);
  const std::string refusal = from.filename().string() + ": refers to '" + name + "'";
  if (name.empty()) throw Error(ErrorCode::bad_data, from.filename().string() + ": refers to a file without a name");
  std::error_code ignored;
  const fs::path resolved = fs::weakly_canonical(directory / wanted, ignored);
  const auto [end, at] = std::mismatch(directory.begin(), directory.end(), resolved.begin(), resolved.end());
  if (resolved.empty() || end != directory.end())
    throw Error(ErrorCode::bad_data, refusal + "; expected a file below its own directory");
  if (!fs::is_regular_file(resolved, ignored)) throw Error(ErrorCode::not_found, refusal + ", which is not there");
  return resolved;
}

void add_note(std::vector<std::string>& notes, const std::string& note) {
  const auto digits = [](const std::string& text) { return text.find_first_not_of("0123456789"); };
  const auto at = digits(note);
  if (at == 0 || at > 15 || at == std::string::npos) {
    if (std::find(notes.begin(), notes.end(), note) == notes.end()) notes.push_back(note);
    return;
  }
  for (std::string& other : notes)
    if (const auto there = digits(other); there != 0 && there <= 15 && other.substr(there) == note.substr(at)) {
      other = std::to_string(std::stoll(other) + std::stoll(note)) + note.substr(at);
      return;
    }
  notes.push_back(note);
}

}  // namespace isostrata
