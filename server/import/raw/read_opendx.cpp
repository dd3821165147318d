#include <algorithm>
#include <array>
#include <cctype>

#include "data/files/recognise.h"
#include "import/bytes/mapped_file.h"
#include "import/bytes/text_numbers.h"
#include "import/bytes/trimmed.h"
#include "import/imported/place_image.h"
#include "import/imported/read_own.h"

namespace isostrata {
namespace {

/// The words of a line, without the quotes around them.
std::vector<std::string> words_of(std::string_view line) {
  std::vector<std::string> words;
  for (;;) {
    line.remove_prefix(std::min(line.find_first_not_of(" \t\r,"), line.size()));
    if (line.empty()) return words;
    const auto end = std::min(line.find_first_of(" \t\r,"), line.size());
    std::string word(line.substr(0, end));
    std::erase(word, '"');
    words.push_back(small_letters(word));
    line.remove_prefix(end);
  }
}

class OpenDx {
 public:
  explicit OpenDx(const ReadRequest& request) : request_(request), name_(request.file.filename().string()) {}

  Imported read() {
    const MappedFile file(request_.file);
    TextNumbers text({reinterpret_cast<const char*>(file.bytes().data()), file.bytes().size()}, name_);
    Imported imported;
    for (std::string_view line = text.next_line(); !line.empty(); line = text.next_line()) {
      const auto words = words_of(line);
      if (words.empty() || words[0].starts_with("#")) continue;
      if (words[0] == "origin") numbers(words, 3, origin_.data(), "origin");
      if (words[0] == "delta" && deltas_ < 3) numbers(words, 3, delta_[deltas_++].data(), "delta");
      const bool positions = has(words, "gridpositions");
      if (positions && dims_[0] == 0) {
        std::array<double, 3> counts{};
        numbers({words.begin() + (std::find(words.begin(), words.end(), "counts") - words.begin()), words.end()}, 3, counts.data(), "counts");
        for (std::size_t a = 0; a < 3; ++a) {
          dims_[a] = static_cast<std::int64_t>(counts[a]);
          if (!(counts[a] >= 1 && counts[a] < 1e12) || static_cast<double>(dims_[a]) != counts[a])
            throw Error(ErrorCode::bad_data, name_ + ": " + std::to_string(counts[a]) + " points along an axis; expected a whole number of at least 1");
        }
      }
      if (has(words, "array") && has(words, "items")) {
        arrays_.push_back(values(words, text));
        break;  // what follows says how they belong together
      }
    }
    if (arrays_.empty()) throw Error(ErrorCode::bad_data, name_ + ": has no array with data behind it");
    Block block;
    place_image(block, dims_, origin_, delta_, name_);
    block.arrays = std::move(arrays_);
    imported.blocks.push_back(std::move(block));
    return imported;
  }

 private:
  static bool has(const std::vector<std::string>& words, const char* word) { return std::find(words.begin(), words.end(), word) != words.end(); }
  std::string after(const std::vector<std::string>& words, const char* word) const {
    const auto at = std::find(words.begin(), words.end(), word);
    return at == words.end() || at + 1 == words.end() ? "" : *(at + 1);
  }
  void numbers(const std::vector<std::string>& words, std::size_t count, double* to, const char* what) const {
    for (std::size_t i = 0; i < count; ++i) {
      const auto value = i + 1 < words.size() ? parsed_number<double>(words[i + 1]) : std::nullopt;
      if (!value) throw Error(ErrorCode::bad_data, name_ + ": expected " + std::to_string(count) + " numbers behind " + what);
      to[i] = *value;
    }
  }

  /// z is the fastest of the file, x of ours.
  FileArray values(const std::vector<std::string>& words, TextNumbers& text) const {
    if (dims_[0] == 0 || deltas_ < 3)
      throw Error(ErrorCode::unsupported, name_ + ": expected a regular grid: 'gridpositions counts NX NY NZ', an origin and three deltas before the array");
    if (has(words, "binary") || has(words, "ieee") || has(words, "file"))
      throw Error(ErrorCode::unsupported, name_ + ": its values are binary or in another file; expected text, as APBS and VMD write it");
    const std::int64_t points = checked_product({dims_[0], dims_[1], dims_[2]}, name_);
    const auto items = parsed_number<std::int64_t>(after(words, "items"));
    if (!items || *items != points)
      throw Error(ErrorCode::bad_data, name_ + ": an array of " + after(words, "items") + " items; the grid has " + std::to_string(points) + " points");
    const bool vectors = after(words, "rank") == "1";
    const auto shape = vectors ? parsed_number<std::int64_t>(after(words, "shape")) : std::optional<std::int64_t>(1);
    if (!shape || *shape < 1 || *shape > 256 || (after(words, "rank") != "0" && has(words, "rank") && !vectors))
      throw Error(ErrorCode::unsupported, name_ + ": an array of rank " + after(words, "rank") + " and shape " + after(words, "shape") + "; expected scalars or vectors");
    const auto components = static_cast<std::size_t>(*shape);
    // A number and the blank behind it take two bytes.
    if (static_cast<std::uint64_t>(points) > text.left() || components > text.left() / static_cast<std::uint64_t>(points))
      throw Error(ErrorCode::bad_data, name_ + ": ends within the values of its array");
    check_bytes(request_, static_cast<std::uint64_t>(points) * components * sizeof(float), name_);
    FileArray array;
    array.name = "values";
    array.components = static_cast<int>(components);
    auto [storage, to] = allocate<float>(static_cast<std::size_t>(points) * components);
    const auto nx = static_cast<std::size_t>(dims_[0]), ny = static_cast<std::size_t>(dims_[1]), nz = static_cast<std::size_t>(dims_[2]);
    for (std::size_t i = 0; i < nx; ++i)
      for (std::size_t j = 0; j < ny; ++j)
        for (std::size_t k = 0; k < nz; ++k)
          for (std::size_t c = 0; c < components; ++c) to[(i + nx * (j + ny * k)) * components + c] = static_cast<float>(text.number("a value"));
    array.values = std::as_bytes(std::span<const float>(to));
    array.storage = storage;
    return array;
  }

  const ReadRequest& request_;
  const std::string name_;
  std::array<std::int64_t, 3> dims_{};
  std::array<double, 3> origin_{};
  std::array<std::array<double, 3>, 3> delta_{};
  std::size_t deltas_ = 0;
  std::vector<FileArray> arrays_;
};

}  // namespace

// OpenDX's native format, as APBS and VMD write it: "Native Data Files" of the OpenDX User's Guide.
Imported read_opendx(const ReadRequest& request) {
  check_step(request, 1);
  return OpenDx(request).read();
}

}  // namespace isostrata
