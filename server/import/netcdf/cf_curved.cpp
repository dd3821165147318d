#include "import/netcdf/cf_curved.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <sstream>
#include <string_view>
#include <utility>

namespace isostrata {
namespace {

constexpr double kMostPlace = 1e12;  // what is beyond stands for no value

/// Values over some of the axes of a block.
struct Term {
  std::vector<double> values;
  std::array<std::size_t, 3> stride{};
  std::array<bool, 3> over{};

  double at(const std::array<std::int64_t, 3>& index) const {
    std::size_t place = 0;
    for (std::size_t a = 0; a < 3; ++a) place += stride[a] * static_cast<std::size_t>(index[a]);
    return values[place];
  }
};

class Curves {
 public:
  Curves(const CfVariables& variables, const std::string& name, const std::vector<int>& space, const CfMoment& moment) : variables_(variables), name_(name), space_(space), moment_(moment) {}

  std::optional<Axes> place(Block& block, std::vector<std::string>& notes) {
    std::array<std::int64_t, 3> dims{1, 1, 1};
    for (std::size_t a = 0; a < space_.size(); ++a) dims[a] = static_cast<std::int64_t>(variables_.length(space_[space_.size() - 1 - a]));
    auto x = horizontal({"degrees_east", "degree_east", "degrees_E", "degree_E", "degreesE", "degreeE"}, "longitude");
    auto y = horizontal({"degrees_north", "degree_north", "degrees_N", "degree_N", "degreesN", "degreeN"}, "latitude");
    if (!x || !y || x->over != y->over) return std::nullopt;
    if (unwrap(*x, dims)) notes.push_back("longitudes are continued across 180 or 360 degrees, at which they begin anew");
    const auto [z, height] = vertical(*x, notes);
    fill(block, dims, *x, *y, z);
    return Axes{Axis{"longitude", "degrees_east"}, Axis{"latitude", "degrees_north"}, height};
  }

 private:
  /// Its values over the axes of space at the moment; nothing if it has another axis.
  std::optional<Term> term(const std::string& name) const {
    const auto dimensions = variables_.dimensions(name);
    if (!dimensions) return std::nullopt;
    std::vector<std::size_t> from, count;
    Term out;
    for (const int dimension : *dimensions) {
      const bool in_space = std::find(space_.begin(), space_.end(), dimension) != space_.end();
      if (!in_space && moment_.dimension != dimension && variables_.length(dimension) != 1) return std::nullopt;
      from.push_back(moment_.dimension == dimension ? moment_.place : 0);
      count.push_back(in_space ? variables_.length(dimension) : 1);
    }
    std::size_t step = 1;
    for (std::size_t d = dimensions->size(); d-- > 0; step *= count[d]) {
      const auto at = std::find(space_.begin(), space_.end(), (*dimensions)[d]);
      if (at == space_.end()) continue;
      const auto axis = static_cast<std::size_t>(space_.end() - at) - 1;
      out.stride[axis] = step;
      out.over[axis] = true;
    }
    out.values = variables_.values(name, from, count);
    return out.values.size() == step ? std::optional(std::move(out)) : std::nullopt;
  }

  static std::ptrdiff_t axes(const Term& of) { return std::count(of.over.begin(), of.over.end(), true); }

  std::vector<std::string> named() const {
    std::istringstream words(variables_.text(name_, "coordinates"));
    std::vector<std::string> out;
    for (std::string word; words >> word;) out.push_back(word);
    return out;
  }

  /// How many axes of space a variable has, without a look at its values.
  std::ptrdiff_t axes_of(const std::string& name) const {
    const auto dimensions = variables_.dimensions(name);
    if (!dimensions) return 0;
    return std::count_if(dimensions->begin(), dimensions->end(), [&](int dimension) { return std::find(space_.begin(), space_.end(), dimension) != space_.end(); });
  }

  /// Those that the field names, else any over two of its axes.
  std::optional<Term> horizontal(std::initializer_list<std::string_view> units, std::string_view standard_name) const {
    for (const std::vector<std::string>& some : {named(), variables_.names()})
      for (const std::string& name : some) {
        if (axes_of(name) != 2) continue;
        const std::string own = variables_.text(name, "units");
        if (variables_.text(name, "standard_name") != standard_name && std::find(units.begin(), units.end(), own) == units.end()) continue;
        if (auto found = term(name); found && axes(*found) == 2) return found;
      }
    return std::nullopt;
  }

  /// Along the axis that longitude is not over: by a variable over all three, by a formula, by the axis's own coordinate, else counted.
  std::pair<Term, Axis> vertical(const Term& x, std::vector<std::string>& notes) const {
    if (space_.size() < 3) return {Term{{0.0}, {}, {}}, {}};
    for (const std::string& name : named()) {
      const std::string positive = variables_.text(name, "positive"), standard = variables_.text(name, "standard_name");
      const bool upright = positive == "up" || positive == "down" || standard == "depth" || standard == "height" || standard == "altitude" || standard == "geopotential_height";
      if (axes_of(name) != 3 || !upright) continue;
      if (auto found = term(name)) {
        CfAxis of = cf_axis(name, [&](const char* attribute) { return variables_.text(name, attribute); });
        if (positive.empty() && standard == "depth") of.positive = "down";
        if (of.positive == "down")
          for (double& value : found->values) value = -value;
        return {std::move(*found), cf_meaning(of)};
      }
    }
    const auto axis = static_cast<std::size_t>(std::find(x.over.begin(), x.over.end(), false) - x.over.begin());
    const int dimension = space_[2 - axis];
    if (auto found = by_formula(dimension, axis, notes)) return std::move(*found);
    Term out;
    out.over[axis] = true;
    out.stride[axis] = 1;
    const CfAxis of = variables_.axis(dimension);
    out.values = cf_places(of.has_places ? variables_.values(of.name, {0}, {variables_.length(dimension)}) : std::vector<double>{}, variables_.length(dimension), of, notes);
    return {std::move(out), cf_meaning(of)};
  }

  /// "s: s_rho C: Cs_r eta: zeta depth: h depth_c: hc"
  std::map<std::string, Term> terms_of(const std::string& text) const {
    std::map<std::string, Term> out;
    std::istringstream words(text);
    for (std::string key, name; words >> key >> name;)
      if (key.size() > 1 && key.back() == ':')
        if (auto one = term(name)) out.emplace(key.substr(0, key.size() - 1), std::move(*one));
    return out;
  }

  static std::string depth_name(const std::string& formula) {
    std::istringstream words(formula);
    for (std::string key, name; words >> key >> name;)
      if (key == "depth:") return name;
    return {};
  }

  std::optional<std::pair<Term, Axis>> by_formula(int dimension, std::size_t axis, std::vector<std::string>& notes) const {
    const std::string name = variables_.axis(dimension).name, kind = variables_.text(name, "standard_name");
    const std::string formula = variables_.text(name, "formula_terms");
    const bool sigma = kind == "ocean_sigma_coordinate", g1 = kind == "ocean_s_coordinate_g1", g2 = kind == "ocean_s_coordinate_g2";
    if (formula.empty() || (!sigma && !g1 && !g2)) return std::nullopt;
    const auto terms = terms_of(formula);
    const auto of = [&](const char* key) { return terms.find(key); };
    if (of("eta") == terms.end() || of("depth") == terms.end() || of(sigma ? "sigma" : "s") == terms.end() || (!sigma && (of("C") == terms.end() || of("depth_c") == terms.end()))) {
      notes.push_back("'" + name + "' has a formula of terms that are not all there: z is as it stands");
      return std::nullopt;
    }
    Term out;
    std::array<std::int64_t, 3> dims{};
    std::size_t all = 1;
    for (std::size_t a = 0; a < 3; ++a) {
      dims[a] = static_cast<std::int64_t>(variables_.length(space_[2 - a]));
      out.stride[a] = all;
      out.over[a] = true;
      all *= static_cast<std::size_t>(dims[a]);
    }
    out.values.reserve(all);
    std::array<std::int64_t, 3> at{};
    const auto value = [&](const char* key) { return of(key)->second.at(at); };
    for (at[2] = 0; at[2] < dims[2]; ++at[2])
      for (at[1] = 0; at[1] < dims[1]; ++at[1])
        for (at[0] = 0; at[0] < dims[0]; ++at[0]) {
          const double eta_said = value("eta"), eta = std::isfinite(eta_said) && std::abs(eta_said) < kMostPlace ? eta_said : 0, depth = value("depth");  // on land there is no surface
          if (sigma) {
            out.values.push_back(eta + value("sigma") * (depth + eta));
            continue;
          }
          const double s = value("s"), c = value("C"), critical = value("depth_c");
          const double part = g1 ? critical * s + (depth - critical) * c : (critical * s + depth * c) / (critical + depth);
          out.values.push_back(g1 ? part + eta * (1 + part / depth) : eta + (eta + depth) * part);
        }
    notes.push_back("z is by the formula of '" + name + "' (" + kind + "), upwards" + (axis == 2 ? "" : ", along another axis than the first"));
    return std::pair{std::move(out), Axis{{}, variables_.text(depth_name(formula), "units")}};
  }

  /// Takes jumps by a whole turn out, along the rows and from each row to the next. Whether there were any.
  static bool unwrap(Term& x, const std::array<std::int64_t, 3>& dims) {
    std::array<std::size_t, 2> axes{};
    for (std::size_t a = 0, n = 0; a < 3; ++a)
      if (x.over[a]) axes[n++] = a;
    bool any = false;
    const auto follow = [&](double& value, double before) {
      if (!std::isfinite(value) || !std::isfinite(before) || std::abs(value) > kMostPlace || std::abs(before) > kMostPlace) return;
      const double turns = std::round((before - value) / 360);
      any = any || turns != 0;
      value += 360 * turns;
    };
    for (std::int64_t j = 0; j < dims[axes[1]]; ++j) {
      double* const row = x.values.data() + x.stride[axes[1]] * static_cast<std::size_t>(j);
      if (j > 0) follow(row[0], *(row - x.stride[axes[1]]));
      for (std::int64_t i = 1; i < dims[axes[0]]; ++i) follow(row[x.stride[axes[0]] * static_cast<std::size_t>(i)], row[x.stride[axes[0]] * static_cast<std::size_t>(i - 1)]);
    }
    return any;
  }

  static void fill(Block& block, const std::array<std::int64_t, 3>& dims, const Term& x, const Term& y, const Term& z) {
    const auto count = static_cast<std::size_t>(checked_product({dims[0], dims[1], dims[2]}, "a grid"));
    auto [storage, points] = allocate<Vec3d>(count);
    std::vector<std::size_t> nowhere;
    std::size_t n = 0, placed = count;
    std::array<std::int64_t, 3> at{};
    const auto is_place = [](double value) { return std::isfinite(value) && std::abs(value) <= kMostPlace; };
    for (at[2] = 0; at[2] < dims[2]; ++at[2])
      for (at[1] = 0; at[1] < dims[1]; ++at[1])
        for (at[0] = 0; at[0] < dims[0]; ++at[0], ++n) {
          points[n] = {x.at(at), y.at(at), z.at(at)};
          if (is_place(points[n].x) && is_place(points[n].y) && is_place(points[n].z))
            placed = std::min(placed, n);
          else
            nowhere.push_back(n);
        }
    for (const std::size_t p : nowhere) points[p] = placed < count ? points[placed] : Vec3d{};
    block.grid.shape = CurvilinearGrid{dims, std::span<const Vec3d>(points)};
    block.grid.storage = storage;
    if (nowhere.empty()) return;
    std::vector<bool> gone(count);
    for (const std::size_t p : nowhere) gone[p] = true;
    auto [marks, hidden] = allocate<std::uint8_t>(static_cast<std::size_t>(block.grid.cell_count()));
    std::array<std::int64_t, kMaxCellVertices> ids{};
    for (std::size_t c = 0; c < hidden.size(); ++c) {
      const int corners = block.grid.cell_points(static_cast<std::int64_t>(c), ids);
      hidden[c] = std::any_of(ids.begin(), ids.begin() + corners, [&](std::int64_t id) { return gone[static_cast<std::size_t>(id)]; });
    }
    block.grid.hidden_cells = hidden;
    block.grid.storage = std::make_shared<std::pair<std::shared_ptr<const void>, std::shared_ptr<const void>>>(storage, marks);
  }

  const CfVariables& variables_;
  const std::string& name_;
  const std::vector<int>& space_;
  const CfMoment& moment_;
};

}  // namespace

std::optional<Axes> place_on_curves(Block& block, const CfVariables& variables, const std::string& name, const std::vector<int>& space, const CfMoment& moment, std::vector<std::string>& notes) {
  if (space.size() != 2 && space.size() != 3) return std::nullopt;
  return Curves(variables, name, space, moment).place(block, notes);
}

}  // namespace isostrata
