#include "engine/first/choose_array.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <set>

#include "engine/first/find_missing.h"

namespace isostrata {
namespace {

std::string lower_case(std::string_view text) {
  std::string out(text);
  for (char& c : out)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return out;
}

template <std::size_t n>
bool has_any(std::string_view text, const std::array<std::string_view, n>& parts) {
  return std::any_of(parts.begin(), parts.end(),
                     [&](std::string_view part) { return text.find(part) != std::string_view::npos; });
}
template <std::size_t n>
bool is_any(std::string_view text, const std::array<std::string_view, n>& names) {
  return std::find(names.begin(), names.end(), text) != names.end();
}

/// Words of a name: "NodeIds" and "node_ids" are node, ids.
std::vector<std::string> words_of(std::string_view name) {
  std::vector<std::string> words(1);
  for (std::size_t i = 0; i < name.size(); ++i) {
    const char c = name[i];
    const bool letter =
        (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || static_cast<unsigned char>(c) > 127;
    const bool hump = i > 0 && c >= 'A' && c <= 'Z' && name[i - 1] >= 'a' && name[i - 1] <= 'z';
    if ((!letter || hump) && !words.back().empty()) words.emplace_back();
    if (letter) words.back() += c;
  }
  if (words.back().empty() && words.size() > 1) words.pop_back();
  for (std::string& word : words) word = lower_case(word);
  return words;
}

/// Bookkeeping, not a field.
bool is_bookkeeping(std::string_view name) {
  static constexpr std::array<std::string_view, 14> kParts{"ghost",      "iblank",    "original",  "error",     "residual",
                                                           "coordinate", "direction", "jacobian",  "partition", "nodeid",
                                                           "cellid",     "objectid",  "elementid", "globalid"};
  static constexpr std::array<std::string_view, 20> kWords{
      "id",      "ids",   "rank", "proc", "procid", "processor", "mask",   "blank", "blanking", "normal",
      "normals", "index", "time", "flag", "flags",  "owner",     "domain", "block", "status",   "visited"};
  const std::string lower = lower_case(name);
  if (has_any(lower, kParts) || lower.starts_with("blank")) return true;
  const std::vector<std::string> words = words_of(name);
  if (is_any(words.back(), kWords)) return true;
  if (words.size() > 1 && (words.back() == "i" || words.back() == "j" || words.back() == "k") &&
      words[words.size() - 2] == "block")
    return true;
  return words.size() > 1 && words[0] == "block";
}

/// The place in the list of what people look at first; 0 is the first.
std::optional<int> place_of(const PointArray& array) {
  const std::string n = lower_case(array.name);
  const std::vector<std::string> words = words_of(array.name);
  const auto has = [&](auto... part) { return ((n.find(part) != std::string::npos) || ...); };
  const auto word = [&](auto... w) { return ((std::find(words.begin(), words.end(), w) != words.end()) || ...); };
  const bool vector = array.components >= 2;
  if (has("mises")) return 0;
  if (has("stress")) return 1;
  if (has("eqps", "plastic", "strain")) return 2;
  if (has("densit") || word("rho")) return 3;
  if (has("temperature") || n == "temp" || n == "t" || n == "theta") return 4;
  if (has("speed", "velocity_mag", "velocity mag", "velocitymag") || n == "velocity" || n == "velocities" || n == "vel" ||
      n == "umag" || n == "u_mag" || n == "vectors" || n == "uvw" || n == "v" || (vector && (n == "u" || has("velocit"))))
    return 5;
  if (n == "scalars" || n == "image" || n == "metaimage" || n == "imagefile" || has("intensity")) return 6;
  if (has("concentration", "fraction", "convected", "species", "alpha.", "saturation") || word("vof", "alpha")) return 7;
  if (has("energy", "enthalpy")) return 8;
  if (has("vorticity", "qcrit", "q-crit", "q_crit", "lambda2", "mach")) return 8;
  if (has("momentum")) return 9;
  if (has("electric")) return 10;
  if (has("magnetic")) return 11;
  if (has("displ")) return 12;
  if (has("pres") || n == "p") return 13;
  if (has("salt", "salin")) return 14;
  return std::nullopt;
}

/// Of about 50,000 values, spread evenly over the array.
struct Spread {
  double entropy = 0;      // of 64 bins over the range, in shares of their logarithm
  double finite = 0;       // share
  bool few_whole = false;  // at most six values, all whole numbers
};

Spread spread_of(const PointArray& array) {
  constexpr std::size_t kLooks = 50'000;
  Spread spread;
  const auto missing = guess_missing(array);
  const double lower = missing ? missing->lower : array.lower, upper = missing ? missing->upper : array.upper;
  std::array<std::int64_t, 64> bins{};
  std::set<double> different;
  std::int64_t looks = 0, finite = 0;
  bool whole = true;
  std::visit(
      [&](auto values) {
        const std::size_t stride = std::max<std::size_t>(1, values.size() / kLooks);
        for (std::size_t i = 0; i < values.size(); i += stride) {
          ++looks;
          const auto v = static_cast<double>(values[i]);
          if (!std::isfinite(v) || (missing && v == missing->value)) continue;
          ++finite;
          const double t = (v / 2 - lower / 2) / (upper / 2 - lower / 2);
          ++bins[static_cast<std::size_t>(std::clamp(static_cast<int>(t * 64), 0, 63))];
          whole = whole && v == std::floor(v);
          if (different.size() <= 6) different.insert(v);
        }
      },
      array.values);
  for (const std::int64_t count : bins)
    if (count > 0) {
      const double p = static_cast<double>(count) / static_cast<double>(finite);
      spread.entropy -= p * std::log2(p) / 6;
    }
  spread.finite = looks ? static_cast<double>(finite) / static_cast<double>(looks) : 0;
  spread.few_whole = whole && different.size() <= 6;
  return spread;
}

const PointArray* find(const Dataset& step, std::string_view name) {
  for (const PointArray& array : step.arrays)
    if (array.name == name) return &array;
  return nullptr;
}

bool varies_anywhere(std::span<const Dataset* const> steps, const std::string& name) {
  double lower = INFINITY, upper = -INFINITY;
  ScalarType type = ScalarType::float32;
  for (const Dataset* step : steps)
    if (const PointArray* array = find(*step, name); array && array->lower <= array->upper)
      lower = std::min(lower, array->lower), upper = std::max(upper, array->upper), type = array->type;
  return varies(lower, upper, type);
}

/// u, v and w beside a speed, or V_x beside V.
bool is_component(const Dataset& step, const PointArray& array) {
  if (!array.component.empty() && array.component != "magnitude") return true;
  const std::string lower = lower_case(array.name);
  std::set<std::string> all;
  for (const PointArray& of : step.arrays) all.insert(lower_case(of.name));
  if (lower.size() > 2 && lower[lower.size() - 2] == '_' && all.count(lower.substr(0, lower.size() - 2))) return true;
  const std::vector<std::string> words = words_of(array.name);  // "Z Velocity"
  for (const std::string& word : {words.front(), words.back()})
    if (words.size() > 1 && (word == "x" || word == "y" || word == "z")) return true;
  if (lower != "u" && lower != "v" && lower != "w") return false;
  if (!all.count("u") || !all.count("v") || !all.count("w")) return false;
  return all.count("speed") || all.count("umag") || all.count("uvw") || all.count("velocity");
}

}  // namespace

double rounding_of(ScalarType type) { return type == ScalarType::float64 ? 1e-9 : 1e-6; }

bool varies(double lower, double upper, ScalarType type) {
  return lower < upper && upper / 2 - lower / 2 > rounding_of(type) / 2 * std::max(std::abs(lower), std::abs(upper));
}

bool rests_at_zero(const PointArray& array) {
  if (!array.component.empty() && array.component != "magnitude") return false;
  if (!(array.lower >= 0)) return false;
  static constexpr std::array<std::string_view, 7> kParts{"speed", "veloc", "umag", "u_mag", "displ", "momentum", "vorticity"};
  const std::string lower = lower_case(array.name);
  return has_any(lower, kParts) || lower.starts_with("vel") || lower == "vectors" ||
         (lower == "u" && array.component == "magnitude");
}

bool belongs_to_a_solid(std::string_view name) {
  static constexpr std::array<std::string_view, 5> kParts{"stress", "strain", "mises", "displ", "eqps"};
  return has_any(lower_case(name), kParts);
}

bool is_level_set(std::string_view name) {
  static constexpr std::array<std::string_view, 5> kParts{"sdf", "signed", "levelset", "level_set", "level set"};
  return has_any(lower_case(name), kParts);
}

std::vector<ArrayChoice> rank_arrays(std::span<const Dataset* const> steps) {
  std::vector<ArrayChoice> ranked;
  const Dataset& shown = *steps.front();
  for (std::size_t i = 0; i < shown.arrays.size(); ++i) {
    const PointArray& array = shown.arrays[i];
    if (!varies_anywhere(steps, array.name)) continue;
    ArrayChoice choice{array.name, -0.01 * static_cast<double>(i), ""};
    const Spread spread = varies(array.lower, array.upper, array.type) ? spread_of(array) : Spread{0, 1, false};
    if (const auto place = place_of(array)) {
      choice.score += 1.5 - 0.1 * *place;
      choice.reason = "a quantity that is looked at first";
    } else {
      choice.reason = "the first that varies well";
    }
    if (is_component(shown, array)) choice.score -= 2, choice.reason = "a component";
    if (array.association == Association::cell_averaged) choice.score -= 0.15;
    choice.score += 0.8 * std::min(spread.entropy, 0.5);
    if (spread.entropy < 0.12) choice.score -= 1.5, choice.reason = "hardly varies, but nothing else does better";
    if (spread.finite < 0.05) choice.score -= 2, choice.reason = "has few values";
    if (spread.few_whole) choice.score -= 4, choice.reason = "a few whole numbers, but nothing else varies";
    if (is_bookkeeping(array.name)) choice.score -= 6, choice.reason = "its name says bookkeeping, but nothing else varies";
    ranked.push_back(std::move(choice));
  }
  std::stable_sort(ranked.begin(), ranked.end(), [](const ArrayChoice& a, const ArrayChoice& b) { return a.score > b.score; });
  if (ranked.size() == 1) ranked.front().reason = "the only array that varies";
  return ranked;
}

}  // namespace isostrata
