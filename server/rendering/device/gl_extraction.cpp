#include "rendering/device/gl_extraction.h"

#include "base/error.h"

namespace isostrata {

/// Everything that lives in one context.
class GlExtraction::State {
 public:
  explicit State(std::string_view device) : device_(open_context(device)), extractor_(device_) {}
  ~State() {
    try {
      device_.make_current();  // the objects are deleted in their own context
    } catch (const Error&) {
      // a lost context: the driver has dropped them already
    }
  }

  ComputeDevice& device() { return device_; }
  GlExtractor& extractor() { return extractor_; }

  template <class Elements>
  void read(const ComputeBuffer& buffer, std::int64_t count, Elements& out, const Task& task) {
    device_.make_current();
    out.resize(static_cast<std::size_t>(count));
    if (count > 0) device_.read(buffer, 0, std::as_writable_bytes(std::span(out)), task);
  }

 private:
  ComputeDevice device_;
  GlExtractor extractor_;
};

GlExtraction::GlExtraction(std::string_view device) : wanted_(device), state_(std::make_unique<State>(device)) {
  device_ = state_->device().context().device();
  software_ = state_->device().context().software();
}

GlExtraction::~GlExtraction() = default;

GlLoadTimes GlExtraction::load(const Grid& grid, const PointArray& array, const Task& task) {
  try {
    if (!state_) state_ = std::make_unique<State>(wanted_);
    state_->device().make_current();
    state_->device().set_budget(budget_);
    state_->extractor().load(grid, array, largest_part_, task);
    const GlField& field = *state_->extractor().field();
    return {field.upload_ms, field.index_ms};
  } catch (...) {
    drop_after_error();
    throw;
  }
}

/// Called while an exception is handled. What the device itself may have suffered from makes the next load start from a fresh
/// context; making one takes time, so a cancelled drag does not.
void GlExtraction::drop_after_error() {
  try {
    throw;
  } catch (const Error& error) {
    for (const ErrorCode harmless : {ErrorCode::cancelled, ErrorCode::invalid_argument, ErrorCode::unsupported})
      if (error.code() == harmless) return;
  } catch (...) {
    // such as std::bad_alloc
  }
  state_.reset();
}

GlCounts GlExtraction::extract(std::span<const Interval> intervals, GlExtent extent, const Task& task) {
  if (!state_ || !state_->extractor().field())
    throw Error(ErrorCode::invalid_argument,
                "extraction on a device: no field is loaded (after an error it has to be loaded again)");
  try {
    return state_->extractor().extract(intervals, extent, task);
  } catch (...) {
    drop_after_error();
    throw;
  }
}

GlExtraction::State& GlExtraction::state() const {
  if (!state_ || !state_->extractor().has_records())
    throw Error(ErrorCode::invalid_argument, "extraction on a device: nothing has been extracted that could be read");
  return *state_;
}

std::vector<CellCase> GlExtraction::read_records(const Task& task) {
  State& s = state();
  const GlExtractor& made = s.extractor();
  std::vector<shaders::CellRecord> records;
  s.read(made.records(), made.counts().records, records, task);
  std::vector<CellCase> out;
  out.reserve(records.size());
  for (const shaders::CellRecord& r : records)
    out.push_back({r.cell, static_cast<std::uint16_t>(r.case_interval >> RECORD_INTERVAL_SHIFT),
                   static_cast<std::uint16_t>(r.case_interval & RECORD_CASE_MASK)});
  return out;
}

std::vector<std::array<float, 4>> GlExtraction::read_positions(const Task& task) {
  State& s = state();
  std::vector<std::array<float, 4>> positions;
  s.read(s.extractor().positions(), s.extractor().counts().points, positions, task);
  return positions;
}

GlMeshParts GlExtraction::read_mesh(const Task& task) {
  State& s = state();
  const GlExtractor& made = s.extractor();
  if (!made.has_mesh())
    throw Error(ErrorCode::invalid_argument, "extraction on a device: records were extracted; expected tetrahedra");
  GlMeshParts parts;
  s.read(made.records(), made.counts().records, parts.records, task);
  s.read(made.first_tetrahedron(), made.counts().records, parts.first_tetrahedron, task);
  s.read(made.tetrahedra(), made.counts().tetrahedra, parts.tetrahedra, task);
  s.read(made.origins(), made.counts().points, parts.origins, task);
  parts.left_handed = made.left_handed();
  return parts;
}

Vec3d GlExtraction::anchor() const { return state().extractor().field()->anchor; }

}  // namespace isostrata
