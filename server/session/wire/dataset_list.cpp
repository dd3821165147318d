#include "session/wire/dataset_list.h"

#include <algorithm>
#include <map>
#include <sstream>
#include <string>
#include <string_view>
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
  std::vector<const CatalogueEntry*> entries;
  for (const CatalogueEntry& entry : catalogue.entries()) {
    if (!entry.name.starts_with(prefix)) continue;
    const std::string_view rest = std::string_view(entry.name).substr(prefix.size());
    if (!words.empty()) {
      const std::string name = small_letters(std::string(rest));
      if (std::all_of(words.begin(), words.end(), [&](const std::string& word) { return is_in(word, name); })) entries.push_back(&entry);
      continue;
    }
    const auto slash = rest.find('/');
    if (slash == std::string_view::npos) {
      entries.push_back(&entry);
      continue;
    }
    v1::DatasetFolder& inner = folders[std::string_view(entry.name).substr(0, prefix.size() + slash)];
    inner.set_datasets(inner.datasets() + 1);
    inner.set_news(inner.news() + (entry.news != CatalogueNews::none));
    inner.set_changed_unix_ms(std::max(inner.changed_unix_ms(), static_cast<double>(entry.changed_unix_ms)));
  }
  std::stable_sort(entries.begin(), entries.end(), [](const CatalogueEntry* a, const CatalogueEntry* b) { return a->name < b->name; });
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
  for (std::uint64_t i = skip; i < entries.size() && left > 0; ++i, --left) *out.add_datasets() = to_wire(*entries[i]);
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
