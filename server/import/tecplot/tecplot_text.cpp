// Tecplot's text format: "Tecplot 360 Data Format Guide", chapter "ASCII Data".
#include <cmath>
#include <limits>
#include <map>
#include <optional>

#include "data/files/recognise.h"
#include "import/tecplot/tecplot_words.h"
#include "import/tecplot/tecplot_zone.h"

namespace isostrata {
namespace {

constexpr std::size_t kMostInText = 10'000;
constexpr std::int64_t kMostPoints = std::int64_t{1} << 40;

bool begins_record(const std::string& word) {
  static constexpr std::array kWords{"zone", "title", "variables", "filetype", "text", "geometry", "datasetauxdata", "varauxdata", "customlabels"};
  return std::find(kWords.begin(), kWords.end(), word) != kWords.end();
}

/// The numbers, counted from 1, of "[1-3,5]" or "4", at `at` in a list; `at` is then behind it.
std::vector<int> set_in(const std::string& list, std::size_t& at) {
  std::vector<int> out;
  const bool several = list[at] == '[';
  if (several) ++at;
  for (std::optional<int> first; at < list.size();) {
    if (std::isdigit(static_cast<unsigned char>(list[at]))) {
      int value = 0;
      while (at < list.size() && std::isdigit(static_cast<unsigned char>(list[at])) && value < 1'000'000) value = 10 * value + (list[at++] - '0');
      for (int v = first ? *first + 1 : value; v <= value && out.size() < kMostInText; ++v) out.push_back(v);
      first.reset();
      if (!several) break;
    } else if (list[at] == '-' && !out.empty()) {
      first = out.back();
      ++at;
    } else if (list[at] == ']') {
      ++at;
      break;
    } else {
      ++at;
    }
  }
  return out;
}

class Text {
 public:
  Text(std::string_view text, const std::string& name) : words_(text, 0, name), name_(name) {}

  TecplotFile read() {
    while (words_.peek() != 0) {
      const std::string word = small_letters(words_.word());
      if (word == "title") {
        value();
      } else if (word == "filetype") {
        if (small_letters(value()) != "full") throw Error(ErrorCode::unsupported, name_ + ": has the points or the values alone, the others being in a file beside it; save it as CGNS, or as .vtu (ParaView: Save Data)");
      } else if (word == "variables") {
        variables();
      } else if (word == "zone") {
        zone();
      } else if (begins_record(word)) {  // texts and drawings
        do words_.skip_line();
        while (words_.peek() != 0 && !record_follows());
      } else {
        words_.refuse("expected TITLE, VARIABLES or ZONE, not '" + word.substr(0, 40) + "'");
      }
    }
    return std::move(file_);
  }

 private:
  std::string value() {
    words_.take('=');
    return words_.word();
  }
  bool record_follows() {
    const std::size_t here = words_.at();
    const bool follows = begins_record(small_letters(words_.word()));
    words_.go_back(here);
    return follows;
  }
  void variables() {
    words_.take('=');
    for (char c = 0; (c = words_.peek()) != 0;) {
      if (c != '"' && c != '\'' && record_follows()) break;
      if (file_.variables.size() >= kMostInText) words_.refuse("has more than " + std::to_string(kMostInText) + " variables");
      file_.variables.push_back(words_.word());
    }
  }
  std::int64_t whole(const std::string& key, const std::string& text, std::int64_t least) {
    const auto value = parsed_number<std::int64_t>(text);
    if (!value || *value < least || *value > kMostPoints) words_.refuse(key + " of a zone is '" + text.substr(0, 40) + "'; expected a whole number of at least " + std::to_string(least));
    return *value;
  }

  void zone() {
    if (file_.variables.empty()) words_.refuse("a zone before the list of VARIABLES");
    std::map<std::string, std::string> said;
    while (words_.peek() != 0 && !words_.number_follows()) {
      const std::string key = small_letters(words_.word());
      if (begins_record(key)) words_.refuse("a zone without numbers");
      if (key != "auxdata") said[key] = value();
    }
    const auto of = [&](std::initializer_list<const char*> keys) {
      for (const char* key : keys)
        if (const auto at = said.find(key); at != said.end()) return at->second;
      return std::string();
    };
    TecplotZone out;
    out.name = of({"t"});
    out.values.resize(file_.variables.size());
    const std::string packing = small_letters(of({"datapacking", "f"})), type = small_letters(of({"zonetype"})), element = small_letters(of({"et"}));
    const bool mesh = packing == "fepoint" || packing == "feblock" || (!type.empty() && type != "ordered");
    take_kind(out, mesh ? (type.empty() ? "fe" + (element.empty() ? "triangle" : element) : type) : "ordered");
    if (mesh) {
      out.points = whole("the number of points", of({"n", "nodes"}), 0);
      out.cells = whole("the number of elements", of({"e", "elements"}), 0);
    } else {
      std::array<std::int64_t, 3> dims{1, 1, 1};
      for (std::size_t a = 0; a < 3; ++a)
        if (const std::string size = of({std::array{"i", "j", "k"}[a]}); !size.empty()) dims[a] = whole(std::string(1, "IJK"[a]), size, 1);
      if (of({"i"}).empty()) words_.refuse("a zone without I, J and K, and no mesh");
      out.set_ordered(dims, name_);
    }
    if (const std::string time = of({"solutiontime"}); !time.empty()) {
      const auto value = parsed_number<double>(time);
      if (!value || !std::isfinite(*value)) words_.refuse("SOLUTIONTIME is '" + time.substr(0, 40) + "'; expected a finite number");
      out.time = *value;
      out.timed = of({"strandid"}) != "0";
    }
    locations(out, of({"varlocation"}));
    shared(out, of({"varsharelist"}));
    if (const std::string passive = of({"passivevarlist"}); !passive.empty())
      for (std::size_t at = 0; at < passive.size();) for_each_variable(passive, at, [&](int v) { out.values[static_cast<std::size_t>(v)].passive = true; });
    if (const std::string mesh_of = of({"connectivitysharezone"}); !mesh_of.empty()) out.mesh_of = zone_number(mesh_of);
    const bool on_cells = std::any_of(out.values.begin(), out.values.end(), [](const TecplotValues& one) { return one.on_cells; });
    out.by_points = packing.ends_with("point") || (packing.empty() && !on_cells);
    if (out.by_points && on_cells) words_.refuse("a zone with DATAPACKING=POINT and values of cells; expected BLOCK");
    out.at = words_.at();
    std::int64_t numbers = 0;
    for (const TecplotValues& one : out.values)
      if (!one.passive && one.shared_with < 0) numbers += out.count(one);
    words_.skip_numbers(numbers);
    if (mesh && out.mesh_of < 0) words_.skip_numbers(checked_product({out.cells, tecplot_nodes(out.kind)}, name_));
    file_.zones.push_back(std::move(out));
  }

  void take_kind(TecplotZone& out, const std::string& type) {
    static const std::map<std::string, TecplotKind> kKinds{{"ordered", TecplotKind::ordered}, {"felineseg", TecplotKind::line}, {"fetriangle", TecplotKind::triangle}, {"fequadrilateral", TecplotKind::quadrilateral},
                                                           {"fetetrahedron", TecplotKind::tetrahedron}, {"febrick", TecplotKind::brick}};
    const auto kind = kKinds.find(type);
    if (kind == kKinds.end()) throw Error(ErrorCode::unsupported, name_ + ": has a zone of type " + type.substr(0, 40) + ", which is not read in this format; save it as CGNS, or as .vtu (ParaView: Save Data)");
    out.kind = kind->second;
  }
  int zone_number(const std::string& text) {
    const auto number = parsed_number<int>(text);
    if (!number || *number < 1 || *number > std::ssize(file_.zones)) words_.refuse("'" + text.substr(0, 40) + "' as the number of a zone before this one");
    return *number - 1;
  }
  /// use(v) for each variable of a set; `at` is then behind it, and what separates it from the next.
  template <class Use>
  void for_each_variable(const std::string& list, std::size_t& at, const Use& use) {
    while (at < list.size() && list[at] != '[' && !std::isdigit(static_cast<unsigned char>(list[at]))) ++at;
    if (at == list.size()) return;
    for (const int v : set_in(list, at)) {
      if (v < 1 || v > std::ssize(file_.variables)) words_.refuse("variable " + std::to_string(v) + " in '" + list.substr(0, 40) + "'; there are " + std::to_string(file_.variables.size()));
      use(v - 1);
    }
  }
  /// "([4-6]=CELLCENTERED)" or "(NODAL, CELLCENTERED)".
  void locations(TecplotZone& out, const std::string& said) {
    const std::string list = small_letters(said);
    if (list.find('[') == std::string::npos && list.find('=') == std::string::npos) {
      TecplotWords all(list, list.starts_with('(') ? 1 : 0, name_);
      for (std::size_t v = 0; v < out.values.size() && all.peek() != 0; ++v) out.values[v].on_cells = all.word().starts_with("cell");
      return;
    }
    for (std::size_t at = 0; at < list.size();) {
      std::vector<int> set;
      for_each_variable(list, at, [&](int v) { set.push_back(v); });
      if (at >= list.size()) break;
      const std::size_t equals = list.find('=', at);
      const bool cells = equals != std::string::npos && list.compare(list.find_first_not_of(" \t\n", equals + 1), 4, "cell") == 0;
      for (const int v : set) out.values[static_cast<std::size_t>(v)].on_cells = cells;
      at = std::min(list.find_first_of("[", at), list.size());
    }
  }
  /// "([1-3]=1, [5]=2)".
  void shared(TecplotZone& out, const std::string& list) {
    for (std::size_t at = 0; at < list.size();) {
      std::vector<int> set;
      for_each_variable(list, at, [&](int v) { set.push_back(v); });
      if (set.empty()) break;
      int with = 0;
      if (const std::size_t equals = list.find_first_not_of(" \t\n", at); equals != std::string::npos && list[equals] == '=') {
        at = equals + 1;
        while (at < list.size() && std::isspace(static_cast<unsigned char>(list[at]))) ++at;
        if (at == list.size()) break;
        const std::vector<int> zone = set_in(list, at);
        with = zone_number(zone.empty() ? list : std::to_string(zone.front()));
      } else if (file_.zones.empty()) {
        words_.refuse("shares values, and no zone is before it");
      }
      for (const int v : set) out.values[static_cast<std::size_t>(v)].shared_with = with;
    }
  }

  TecplotWords words_;
  const std::string& name_;
  TecplotFile file_;
};

}  // namespace

TecplotFile tecplot_text(std::string_view text, const std::string& name) { return Text(text, name).read(); }

TecplotNumbers load_tecplot_text(std::string_view text, const TecplotFile& file, const TecplotZone& zone, const std::string& name) {
  TecplotWords words(text, zone.at, name);
  TecplotNumbers out;
  out.values.resize(file.variables.size());
  std::vector<std::span<double>> own;
  for (std::size_t v = 0; v < file.variables.size(); ++v) {
    const TecplotValues& of = zone.values[v];
    if (of.passive || of.shared_with >= 0) continue;
    auto [storage, values] = allocate<double>(static_cast<std::size_t>(zone.count(of)));
    out.values[v].on_cells = of.on_cells;
    out.values[v].type = ScalarType::float64;
    out.values[v].values = std::as_bytes(values);
    out.values[v].storage = storage;
    own.push_back(values);
  }
  if (zone.by_points) {
    std::size_t at = 0, variable = 0;
    words.numbers(checked_product({zone.points, std::ssize(own)}, name), [&](double value) {
      own[variable][at] = value;
      if (++variable == own.size()) variable = 0, ++at;
    });
  } else {
    for (std::span<double> values : own) {
      auto to = values.begin();
      words.numbers(std::ssize(values), [&](double value) { *to++ = value; });
    }
  }
  if (zone.kind == TecplotKind::ordered || zone.mesh_of >= 0) return out;
  out.nodes.reserve(static_cast<std::size_t>(zone.cells) * static_cast<std::size_t>(tecplot_nodes(zone.kind)));
  words.numbers(zone.cells * tecplot_nodes(zone.kind), [&](double node) { out.nodes.push_back(std::abs(node) < 1e15 ? static_cast<std::int64_t>(node) - 1 : -1); });
  return out;
}

}  // namespace isostrata
