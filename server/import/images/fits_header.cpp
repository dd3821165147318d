#include "import/images/fits_header.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "import/bytes/parsed_number.h"
#include "import/imported/imported.h"

namespace isostrata {
namespace {

constexpr std::size_t kCard = 80, kBlock = 2880;

std::string_view without_blanks(std::string_view text) {
  text.remove_prefix(std::min(text.find_first_not_of(' '), text.size()));
  return text.substr(0, text.find_last_not_of(' ') + 1);
}

/// What stands behind "= ": a text between quotes, of which two are one, or a word before the comment.
std::string value_on(std::string_view card) {
  card = without_blanks(card);
  if (!card.starts_with('\'')) return std::string(without_blanks(card.substr(0, card.find('/'))));
  std::string out;
  for (std::size_t i = 1; i < card.size(); ++i) {
    if (card[i] == '\'' && (i + 1 == card.size() || card[++i] != '\'')) break;
    out += card[i];
  }
  return out.substr(0, out.find_last_not_of(' ') + 1);
}

}  // namespace

FitsHeader::FitsHeader(std::span<const std::byte> file, std::size_t at, std::string name) : name_(std::move(name)) {
  const std::string_view all(reinterpret_cast<const char*>(file.data()), file.size());
  bool ended = false;
  for (; !ended; at += kCard) {
    if (at > all.size() || all.size() - at < kCard || cards_.size() > 100'000) throw Error(ErrorCode::bad_data, name_ + ": ends within its header; expected a card END");
    const std::string_view card = all.substr(at, kCard);
    const std::string key(without_blanks(card.substr(0, 8)));
    ended = key == "END";
    if (card.substr(8, 2) == "= ") cards_.emplace(key, value_on(card.substr(10)));
  }
  data_ = (at + kBlock - 1) / kBlock * kBlock;
  take_axes("BITPIX", "NAXIS");
  const std::int64_t extra = whole("PCOUNT", 0);
  if (extra < 0 || extra > (std::int64_t{1} << 60)) throw Error(ErrorCode::bad_data, name_ + ": PCOUNT " + std::to_string(extra) + " makes no sense");
  if (extra > 0 && bytes_ > 0) bytes_ += static_cast<std::size_t>(extra) * static_cast<std::size_t>(std::abs(bits_) / 8);
}

FitsHeader FitsHeader::unpacked() const {
  FitsHeader image = *this;
  image.axes_.clear();
  image.take_axes("ZBITPIX", "ZNAXIS");
  if (image.axes_.empty()) throw Error(ErrorCode::bad_data, name_ + ": an image that is packed in tiles has no points");
  return image;
}

/// Of these keywords.
void FitsHeader::take_axes(const std::string& of_bits, const std::string& of_axes) {
  bits_ = static_cast<int>(whole(of_bits, 8));
  const std::int64_t axes = whole(of_axes, 0);
  const bool known = std::ranges::any_of(std::array{8, 16, 32, 64, -32, -64}, [&](int bits) { return bits == bits_; });
  if (!known || axes < 0 || axes > 999) throw Error(ErrorCode::bad_data, name_ + ": " + of_bits + " " + std::to_string(bits_) + ", " + of_axes + " " + std::to_string(axes) + "; expected 8, 16, 32, 64, -32 or -64 bits, 0 to 999 axes");
  std::int64_t values = axes > 0;
  for (std::int64_t a = 1; a <= axes; ++a) {
    axes_.push_back(whole(of_axes + std::to_string(a), -1));
    values = checked_product({values, axes_.back()}, name_);
  }
  bytes_ = static_cast<std::size_t>(checked_product({values, std::abs(bits_) / 8}, name_));
  if (values == 0) axes_.clear();
}

std::size_t FitsHeader::next() const { return data_ + (bytes_ + kBlock - 1) / kBlock * kBlock; }

std::string FitsHeader::text(const std::string& key) const {
  const auto at = cards_.find(key);
  return at == cards_.end() ? std::string() : at->second;
}

std::optional<double> FitsHeader::real(const std::string& key) const {
  std::string word = text(key);
  std::replace(word.begin(), word.end(), 'D', 'E');
  if (word.starts_with('+')) word.erase(0, 1);
  const std::optional<double> value = parsed_number<double>(word);
  return value && std::isfinite(*value) ? value : std::nullopt;
}

std::int64_t FitsHeader::whole(const std::string& key, std::int64_t otherwise) const {
  std::string word = text(key);
  if (word.empty()) return otherwise;
  if (word.starts_with('+')) word.erase(0, 1);
  const std::optional<std::int64_t> value = parsed_number<std::int64_t>(word);
  if (!value) throw Error(ErrorCode::bad_data, name_ + ": " + key + " is '" + word.substr(0, 20) + "'; expected a whole number");
  return *value;
}

}  // namespace isostrata
