#include "import/zarr/zarr_fields.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "import/netcdf/cf_axes.h"
#include "import/netcdf/cf_curved.h"
#include "import/zarr/zarr_array.h"
#include "import/zarr/zarr_block.h"
#include "import/zarr/zarr_chunks.h"
#include "import/zarr/zarr_json.h"

namespace isostrata {
namespace {

constexpr std::size_t kMostArrays = 1000;

struct Variable {
  std::string name;
  ZarrArray array;
  std::vector<int> dimensions;
};

class Fields : private CfVariables {
 public:
  Fields(ZarrStore& store, const ReadRequest& request) : store_(store), request_(request) { find(); }

  std::optional<Imported> read() {
    std::vector<CfField> fields;
    std::vector<const Variable*> of;
    for (const Variable& one : variables_)
      if (const auto field = cf_field(one.dimensions, [&](int d) { return length(d); }, [&](int d) { return is_cf_time(axis(d)); })) {
        fields.push_back(*field);
        of.push_back(&one);
      }
    const std::vector<std::size_t> best = best_cf_fields(fields);
    if (best.empty()) return std::nullopt;
    Imported imported;
    const std::vector<std::size_t> order = take_times(fields, best, imported);
    check_step(request_, imported.times.size());
    if (request_.times_only) return imported;
    const auto says = std::find_if(best.begin(), best.end(), [&](std::size_t f) { return !text_in(of[f]->array.attributes, "coordinates").empty(); });
    const std::size_t first = says == best.end() ? best.front() : *says;
    Block& block = imported.blocks.emplace_back();
    const std::array<std::size_t, 3> from = place(*of[first], fields[first], order, block, imported);
    check_size(fields, best, of);
    ZarrCount count;
    for (const std::size_t f : best) {
      const ZarrCount one = add(*of[f], fields[f], from, order, block);
      count.chunks += one.chunks;
      count.missing += one.missing;
    }
    note_missing(count, imported.notes);
    if (const std::size_t others = of.size() - best.size(); others > 0) imported.notes.push_back(std::to_string(others) + " variables over other axes skipped");
    for (const std::string& note : notes_) add_note(imported.notes, note);
    return imported;
  }

 private:
  void find() {
    for (const std::string& name : store_.parts(kMostArrays)) {
      if (is_one_number(name)) continue;  // the name of a projection, say
      try {
        auto array = read_zarr_array(store_, name);
        if (!array || array->names.size() != array->shape.size()) continue;
        std::vector<int> dimensions;
        for (std::size_t a = 0; a < array->names.size(); ++a) dimensions.push_back(number(array->names[a], array->shape[a], array->file));
        if (dimensions.size() > 1) leave_out_fill(*array);  // a coordinate has no gaps
        variables_.push_back({name, std::move(*array), std::move(dimensions)});
      } catch (const Error& error) {
        if (error.code() != ErrorCode::unsupported) throw;
        notes_.push_back("variable '" + name + "' skipped: " + error.what());
      }
    }
  }

  bool is_one_number(const std::string& name) {
    auto of = store_.read_json(name + "/.zarray");
    if (!of) of = store_.read_json(name + "/zarr.json");
    const boost::json::array* shape = of ? array_in(*of, "shape") : nullptr;
    return shape && shape->empty();
  }

  int number(const std::string& name, std::int64_t length, const std::string& file) {
    const auto [known, fresh] = numbers_.try_emplace(name, static_cast<int>(lengths_.size()));
    if (fresh) {
      lengths_.push_back(static_cast<std::size_t>(length));
      names_.push_back(name);
    }
    if (lengths_[static_cast<std::size_t>(known->second)] != static_cast<std::size_t>(length))
      throw Error(ErrorCode::bad_data, file + ": " + std::to_string(length) + " places along '" + name + "'; others have " + std::to_string(lengths_[static_cast<std::size_t>(known->second)]));
    return known->second;
  }
  std::size_t length(int dimension) const override { return lengths_[static_cast<std::size_t>(dimension)]; }

  const Variable* coordinate(int dimension) const {
    const auto at = std::find_if(variables_.begin(), variables_.end(), [&](const Variable& one) { return one.dimensions.size() == 1 && one.dimensions[0] == dimension && one.name == names_[static_cast<std::size_t>(dimension)]; });
    return at == variables_.end() ? nullptr : &*at;
  }
  CfAxis axis(int dimension) const override {
    const Variable* const of = coordinate(dimension);
    if (!of) return {names_[static_cast<std::size_t>(dimension)]};
    return cf_axis(of->name, [&](const char* attribute) { return text_in(of->array.attributes, attribute); });
  }

  std::vector<std::string> names() const override {
    std::vector<std::string> out;
    for (const Variable& one : variables_) out.push_back(one.name);
    return out;
  }
  const Variable* variable(const std::string& name) const {
    const auto at = std::find_if(variables_.begin(), variables_.end(), [&](const Variable& one) { return one.name == name; });
    return at == variables_.end() ? nullptr : &*at;
  }
  std::optional<std::vector<int>> dimensions(const std::string& name) const override {
    const Variable* const of = variable(name);
    return of ? std::optional(of->dimensions) : std::nullopt;
  }
  std::string text(const std::string& name, const char* attribute) const override {
    const Variable* const of = variable(name);
    return of ? text_in(of->array.attributes, attribute) : std::string();
  }
  std::vector<double> values(const std::string& name, const std::vector<std::size_t>& from, const std::vector<std::size_t>& count) const override {
    const Variable* const of = variable(name);
    if (!of) return {};
    std::int64_t bytes = sizeof(double);
    ZarrBox box;
    std::size_t axes = 0;
    for (std::size_t a = 0; a < count.size(); ++a) {
      box.at.push_back(static_cast<std::int64_t>(from[a]));
      if (count[count.size() - 1 - a] == 1) continue;
      if (axes == 3) return {};
      box.axes[axes] = count.size() - 1 - a;
      box.size[axes++] = static_cast<std::int64_t>(count[count.size() - 1 - a]);
      bytes = checked_product({bytes, box.size[axes - 1]}, of->array.file);
    }
    check_bytes(request_, static_cast<std::uint64_t>(bytes), of->array.file);
    check_bytes(request_, of->array.chunk_bytes(), of->array.file + ": one chunk");
    std::vector<double> out;
    read_zarr_box(store_, of->array, box, [&](std::size_t, std::span<const std::byte> values) {
      std::vector<std::byte> aligned(values.begin(), values.end());
      std::visit([&](auto span) { for (const auto value : span) out.push_back(static_cast<double>(value)); }, scalar_span(of->array.type, aligned));
    }, [](double) {});
    return out;
  }
  /// All values of a coordinate; empty if there is none.
  std::vector<double> places(int dimension) const {
    const Variable* const of = coordinate(dimension);
    return of ? values(of->name, {0}, {length(dimension)}) : std::vector<double>{};
  }
  std::size_t place_in_time(const CfField& of, const std::vector<std::size_t>& order) const {
    const auto step = static_cast<std::size_t>(request_.step);
    return of.time && step < order.size() && length(*of.time) == order.size() ? order[step] : 0;
  }

  /// Sets the times, and gives the place along the axis of time of each step.
  std::vector<std::size_t> take_times(const std::vector<CfField>& fields, const std::vector<std::size_t>& best, Imported& imported) {
    const auto timed = std::find_if(best.begin(), best.end(), [&](std::size_t f) { return fields[f].time.has_value(); });
    if (timed == best.end()) return {};
    const int time = *fields[*timed].time;
    std::vector<double> along = places(time);
    if (along.size() != length(time)) {
      along.resize(length(time));
      std::iota(along.begin(), along.end(), 0.0);
    }
    for (std::size_t t = 0; t < along.size(); ++t)
      if (!std::isfinite(along[t])) throw Error(ErrorCode::bad_data, store_.name() + ": time " + std::to_string(t) + " of '" + names_[static_cast<std::size_t>(time)] + "' is not a finite number");
    CfSteps steps = cf_steps(along);
    imported.times = std::move(steps.times);
    if (!steps.sorted) imported.notes.push_back(kTimesWereSorted);
    if (const std::string units = cf_time_units(axis(time)); !units.empty()) imported.notes.push_back("times are in " + units);
    return std::move(steps.order);
  }

  /// Gives which of the axes of space (0: the last) is x, which y and which z.
  std::array<std::size_t, 3> place(const Variable& variable, const CfField& of, const std::vector<std::size_t>& order, Block& block, Imported& imported) {
    if (const auto curved = place_on_curves(block, *this, variable.name, of.space, {of.time, place_in_time(of, order)}, imported.notes)) {
      imported.axes = *curved;
      return {0, 1, 2};
    }
    std::vector<CfAxis> axes;
    for (const int dimension : of.space) axes.push_back(axis(dimension));
    imported.axes = cf_axes(axes);
    const std::array<std::size_t, 3> from = cf_turned(axes).value_or(std::array<std::size_t, 3>{0, 1, 2});
    std::array<std::vector<double>, 3> at{{{0}, {0}, {0}}};
    for (std::size_t a = 0; a < 3; ++a)
      if (from[a] < of.space.size()) {
        const std::size_t s = of.space.size() - 1 - from[a];
        at[a] = cf_places(places(of.space[s]), length(of.space[s]), axes[s], imported.notes);
      }
    place_on_axes(block, std::move(at));
    return from;
  }

  void check_size(const std::vector<CfField>& fields, const std::vector<std::size_t>& best, const std::vector<const Variable*>& of) {
    std::int64_t bytes = 0;
    for (const std::size_t f : best) {
      std::int64_t own = static_cast<std::int64_t>(size_of(of[f]->array.type));
      for (const int dimension : fields[f].space) own = checked_product({own, static_cast<std::int64_t>(length(dimension))}, store_.name());
      if (__builtin_add_overflow(bytes, own, &bytes)) throw Error(ErrorCode::bad_data, store_.name() + ": sizes that make no sense");
    }
    check_bytes(request_, static_cast<std::uint64_t>(bytes), store_.name());
  }

  ZarrCount add(const Variable& of, const CfField& field, const std::array<std::size_t, 3>& from, const std::vector<std::size_t>& order, Block& block) {
    ZarrBox box;
    box.at.assign(of.dimensions.size(), 0);
    for (std::size_t a = 0; a < 3; ++a) {
      if (from[a] >= field.space.size()) continue;
      const int dimension = field.space[field.space.size() - 1 - from[a]];
      box.axes[a] = static_cast<std::size_t>(std::find(of.dimensions.begin(), of.dimensions.end(), dimension) - of.dimensions.begin());
      box.size[a] = static_cast<std::int64_t>(length(dimension));
    }
    if (field.time) {
      const auto at = static_cast<std::size_t>(std::find(of.dimensions.begin(), of.dimensions.end(), *field.time) - of.dimensions.begin());
      box.at[at] = static_cast<std::int64_t>(place_in_time(field, order));
    }
    const ZarrCount count = add_zarr_arrays(store_, of.array, box, request_, [&](std::size_t) { return of.name; }, block);
    block.arrays.back().unit = text_in(of.array.attributes, "units");
    return count;
  }

  ZarrStore& store_;
  const ReadRequest& request_;
  std::vector<Variable> variables_;
  std::map<std::string, int> numbers_;  // of dimensions
  std::vector<std::string> names_;
  std::vector<std::size_t> lengths_;
  std::vector<std::string> notes_;
};

}  // namespace

std::optional<Imported> read_zarr_fields(ZarrStore& store, const ReadRequest& request) { return Fields(store, request).read(); }

}  // namespace isostrata
