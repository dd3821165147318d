#include "session/wire/dataset_list.h"

#include <algorithm>
#include <charconv>
#include <map>
#include <optional>
#include <sstream>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "base/unix_time.h"
#include "data/files/recognise.h"

namespace isostrata {
namespace {

v1::DatasetNews to_wire(CatalogueNews news) {
  switch (news) {
    case CatalogueNews::appeared: return v1::DATASET_NEWS_APPEARED;
    case CatalogueNews::grown: return v1::DATASET_NEWS_GROWN;
    case CatalogueNews::changed: return v1::DATASET_NEWS_CHANGED;
    case CatalogueNews::gone: return v1::DATASET_NEWS_GONE;
    case CatalogueNews::none: break;
  }
  return v1::DATASET_NEWS_UNSPECIFIED;
}

std::vector<std::string> words_of(const std::string& text) {
  std::istringstream in(small_letters(text));
  std::vector<std::string> words;
  for (std::string word; in >> word;) words.push_back(std::move(word));
  return words;
}

/// Whether the word is in the name; the star of a series stands for a number, so that the word may be of one of its files: "wave_0042" is in "wave_*.vtu".
bool is_in(std::string_view word, std::string_view name) {
  constexpr std::string_view kNumber = "0123456789.+-e";
  if (name.find(word) != std::string_view::npos) return true;
  if (name.find('*') == std::string_view::npos || word.find_first_not_of(kNumber) == std::string_view::npos) return false;  // a number alone is in every series
  std::vector<bool> matched(word.size() + 1), next;  // how many letters of the word the name can have matched up to here
  for (const char c : name) {
    matched[0] = true;
    next.assign(word.size() + 1, false);
    for (std::size_t i = 0; i < word.size(); ++i) {
      if (!matched[i]) continue;
      if (word[i] == c) next[i + 1] = true;
      if (c != '*' || !(word[i] == '-' || (word[i] >= '0' && word[i] <= '9'))) continue;
      for (std::size_t end = i; end < word.size() && kNumber.find(word[end]) != std::string_view::npos; ++end) next[end + 1] = true;
    }
    matched.swap(next);
    if (matched.back()) return true;
  }
  return false;
}

bool is_digit(char c) { return c >= '0' && c <= '9'; }

/// Of a word that is nothing but a number.
std::optional<std::uint64_t> number_of(std::string_view word) {
  std::uint64_t number = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), number);
  return error == std::errc() && end == word.data() + word.size() ? std::optional(number) : std::nullopt;
}

/// Which of a series' files the word names, from 0: by its whole number with the letters around it, "wave_0042" or "0042.vtu", or by the number alone. -1: none.
int place_of_file(std::string_view word, std::string_view name, const CatalogueEntry& entry) {
  if (const auto number = number_of(word)) return entry.numbers.place_of(*number, entry.files);
  for (std::size_t i = 0; i < word.size(); ++i) {
    if (!is_digit(word[i]) || (i > 0 && is_digit(word[i - 1]))) continue;
    std::size_t end = i;
    while (end < word.size() && is_digit(word[end])) ++end;
    const std::string_view run = word.substr(i, end - i);
    const auto number = number_of(run);
    const bool whole = number && run.size() == std::max(std::to_string(*number).size(), static_cast<std::size_t>(entry.numbers.digits));
    if (!whole || name.find(std::string(word.substr(0, i)) + '*' + std::string(word.substr(end))) == std::string_view::npos) continue;
    if (const int place = entry.numbers.place_of(*number, entry.files); place >= 0) return place;
  }
  return -1;
}

struct Found {
  const CatalogueEntry* entry;
  int step;  // from 0, of the file that a word names; -1: none does
};

/// Whether each word is in the name, or, if numbers_too, is the number of one of its files.
std::optional<Found> found_by(const std::vector<std::string>& words, const CatalogueEntry& entry, std::string_view below, bool numbers_too) {
  const std::string name = small_letters(std::string(below));
  Found found{&entry, -1};
  for (const std::string& word : words) {
    const int place = entry.files > 1 ? place_of_file(word, name, entry) : -1;
    const bool there = is_in(word, name);
    if (!there && !(numbers_too && place >= 0)) return std::nullopt;
    if (place >= 0 && !(there && number_of(word))) found.step = place;
  }
  if (entry.one_step) found.step = -1;
  return found;
}

/// What is said of all folders.
void add_all(const Catalogue& catalogue, v1::DatasetList& out) {
  out.set_all(static_cast<std::uint32_t>(catalogue.entries().size()));
  for (const PassedOver& passed : catalogue.passed_over()) {
    v1::PassedOver& to = *out.add_passed_over();
    to.set_reason(passed.reason);
    to.set_files(static_cast<std::uint64_t>(passed.files));
    for (const std::string& example : passed.examples) to.add_examples(example);
  }
  out.set_cut_off(catalogue.cut_off());
  out.set_now_unix_ms(static_cast<double>(unix_ms_now()));
}

}  // namespace

v1::DatasetEntry to_wire(const CatalogueEntry& entry) {
  v1::DatasetEntry out;
  out.set_id(entry.id);
  out.set_name(entry.name);
  out.set_kind(entry.kind);
  out.set_bytes(entry.bytes);
  out.set_changed_unix_ms(static_cast<double>(entry.changed_unix_ms));
  out.set_files(static_cast<std::uint32_t>(std::max(entry.files, 1)));
  const int steps = entry.one_step ? 1 : std::max(entry.files, entry.parts);
  if (steps > 1) out.set_steps(static_cast<std::uint32_t>(steps));
  out.set_news(to_wire(entry.news));
  out.set_noticed_unix_ms(static_cast<double>(entry.noticed_unix_ms));
  out.set_writing(entry.writing);
  return out;
}

v1::DatasetList list_datasets(const Catalogue& catalogue, const v1::ListDatasets& wanted, std::uint32_t most) {
  v1::DatasetList out;
  std::string folder = wanted.folder();
  while (folder.ends_with('/')) folder.pop_back();
  out.set_folder(folder);
  out.set_search(wanted.search());
  const std::string prefix = folder.empty() ? "" : folder + "/";
  const std::vector<std::string> words = words_of(wanted.search());
  std::map<std::string_view, v1::DatasetFolder> folders;
  std::vector<Found> entries;
  const auto search = [&](bool numbers_too) {
    for (const CatalogueEntry& entry : catalogue.entries())
      if (entry.name.starts_with(prefix))
        if (const auto found = found_by(words, entry, std::string_view(entry.name).substr(prefix.size()), numbers_too)) entries.push_back(*found);
  };
  if (!words.empty()) {
    search(false);
    if (entries.empty()) search(true);  // else a number would find every series that is long enough, beside the names that have it
  }
  for (const CatalogueEntry& entry : catalogue.entries()) {
    if (!words.empty()) break;
    if (!entry.name.starts_with(prefix)) continue;
    const std::string_view rest = std::string_view(entry.name).substr(prefix.size());
    const auto slash = rest.find('/');
    if (slash == std::string_view::npos) {
      entries.push_back({&entry, -1});
      continue;
    }
    v1::DatasetFolder& inner = folders[std::string_view(entry.name).substr(0, prefix.size() + slash)];
    inner.set_datasets(inner.datasets() + 1);
    inner.set_news(inner.news() + (entry.news != CatalogueNews::none));
    inner.set_changed_unix_ms(std::max(inner.changed_unix_ms(), static_cast<double>(entry.changed_unix_ms)));
  }
  std::stable_sort(entries.begin(), entries.end(), [](const Found& a, const Found& b) { return a.entry->name < b.entry->name; });
  out.set_first(wanted.first());
  out.set_total(static_cast<std::uint32_t>(folders.size() + entries.size()));
  std::uint64_t left = std::min(wanted.most() == 0 ? 100u : wanted.most(), most), skip = wanted.first();
  for (const auto& [name, inner] : folders) {
    if (skip > 0) {
      --skip;
    } else if (left > 0) {
      --left;
      v1::DatasetFolder& to = *out.add_folders();
      to = inner;
      to.set_name(std::string(name));
    }
  }
  for (std::uint64_t i = skip; i < entries.size() && left > 0; ++i, --left) {
    v1::DatasetEntry& to = *out.add_datasets();
    to = to_wire(*entries[i].entry);
    to.set_found_step(static_cast<std::uint32_t>(entries[i].step + 1));
  }
  add_all(catalogue, out);
  return out;
}

v1::DatasetList all_datasets(const Catalogue& catalogue, std::uint32_t first, std::uint32_t most) {
  v1::DatasetList out;
  const auto& entries = catalogue.entries();
  out.set_first(first);
  out.set_total(static_cast<std::uint32_t>(entries.size()));
  for (std::size_t i = first; i < entries.size() && i < std::size_t{first} + most; ++i) *out.add_datasets() = to_wire(entries[i]);
  add_all(catalogue, out);
  return out;
}

}  // namespace isostrata
