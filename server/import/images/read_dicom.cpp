#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <set>
#include <string>
#include <tuple>
#include <type_traits>
#include <vector>

#include "data/files/file_series.h"
#include "data/files/recognise.h"
#include "import/bytes/mapped_file.h"
#include "import/images/dicom_header.h"
#include "import/imported/place_image.h"
#include "import/imported/read_own.h"

namespace isostrata {
namespace {

namespace fs = std::filesystem;
using Place = std::array<double, 3>;

struct Slice {
  const DicomHeader* header = nullptr;
  int frame = 0;
  Place at{};
  double along = 0;  // the normal
};

double dot(const Place& a, const Place& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/// Of a folder, or of a pattern.
std::vector<fs::path> dicom_files(const fs::path& folder) {
  std::vector<fs::path> files;
  std::error_code error, ignored;
  if (is_series_pattern(folder))
    for (const SeriesFile& file : series_files(folder))
      if (is_dicom(file.path)) files.push_back(file.path);
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error))
    if (it->is_regular_file(ignored) && is_dicom(it->path())) files.push_back(it->path());
  if (files.size() > 100'000) throw Error(ErrorCode::too_large, folder.filename().string() + ": more than 100000 DICOM files");
  std::sort(files.begin(), files.end());
  return files;
}

/// Files that can be slices of one volume.
bool same_volume(const DicomHeader& a, const DicomHeader& b) {
  const auto near = [](double x, double y) { return std::abs(x - y) < 1e-4; };
  return a.series == b.series && a.rows == b.rows && a.columns == b.columns && a.bits == b.bits && a.is_signed == b.is_signed &&
         std::equal(a.orientation.begin(), a.orientation.end(), b.orientation.begin(), near) &&
         std::equal(a.spacing.begin(), a.spacing.end(), b.spacing.begin(), near);
}

/// Takes out what is there twice under two names: the same picture by its own number, at the same place. Gives how many those were.
std::size_t leave_out_copies(std::vector<DicomHeader>& headers) {
  const auto key = [](const DicomHeader& h) { return std::tie(h.series, h.instance_uid, h.instance, h.positions, h.pixel_bytes); };
  std::set<std::tuple<std::string, std::string, int, std::vector<Place>, std::size_t>> seen;
  return std::erase_if(headers, [&](const DicomHeader& h) { return !h.instance_uid.empty() && !seen.insert(key(h)).second; });
}

/// Two files of the place that has the most pictures.
std::string fullest_place(const std::vector<Slice>& slices) {
  std::size_t begin = 0, longest = 0;
  for (std::size_t i = 0, first = 0; i < slices.size(); ++i) {
    if (std::abs(slices[i].along - slices[first].along) >= 2e-3) first = i;
    if (i - first > longest) longest = i - first, begin = first;
  }
  return slices[begin].header->file.filename().string() + " and " + slices[begin + 1].header->file.filename().string();
}

void check_pixels(const DicomHeader& h) {
  const std::string name = h.file.filename().string();
  if (h.pixels == 0) throw Error(ErrorCode::unsupported, name + ": DICOM without pixels");
  if (h.pixel_bytes == 0)
    throw Error(ErrorCode::unsupported, name + ": its pixels are compressed (transfer syntax " + h.syntax + "); write them uncompressed: gdcmconv --raw, dcmdjpeg");
  if (h.samples != 1) throw Error(ErrorCode::unsupported, name + ": " + std::to_string(h.samples) + " colours in each pixel; expected one value");
  if (h.rows < 1 || h.columns < 1 || h.frames < 1 || (h.bits != 8 && h.bits != 16 && h.bits != 32) || h.stored < 1 || h.stored > h.bits)
    throw Error(ErrorCode::bad_data, name + ": " + std::to_string(h.columns) + " x " + std::to_string(h.rows) + " pixels of " + std::to_string(h.bits) +
                                         " bits, of which " + std::to_string(h.stored) + " are used; expected 8, 16 or 32 bits");
  if (static_cast<std::size_t>(h.frames) > h.pixel_bytes / h.frame_bytes())
    throw Error(ErrorCode::bad_data, name + ": " + std::to_string(h.frames) + " pictures of " + std::to_string(h.frame_bytes()) + " bytes declared, " +
                                         std::to_string(h.pixel_bytes) + " bytes present");
}

/// Along the normal from the one place that all pictures of the file have.
double offset_of(const DicomHeader& h, int frame) {
  const auto f = static_cast<std::size_t>(frame);
  if (h.offsets.size() == static_cast<std::size_t>(h.frames)) return h.offsets[f] - h.offsets[0];
  if (h.frames > 1 && h.between != 0) return h.between * frame;
  return h.thickness * (h.positions.empty() && h.frames == 1 ? h.instance : frame);
}

/// The pictures of one volume in the order of space; those of several times follow each other at each place.
std::vector<Slice> in_order(const std::vector<const DicomHeader*>& files, const Place& normal) {
  std::vector<Slice> slices;
  for (const DicomHeader* h : files)
    for (int frame = 0; frame < h->frames; ++frame) {
      Slice slice{h, frame, {}, 0};
      const auto f = static_cast<std::size_t>(frame);
      if (f < h->positions.size())
        slice.at = h->positions[f];
      else  // one place for all pictures: one after the other
        for (std::size_t a = 0; a < 3; ++a)
          slice.at[a] = (h->positions.empty() ? 0 : h->positions[0][a]) + normal[a] * offset_of(*h, frame);
      slice.along = dot(slice.at, normal);
      slices.push_back(slice);
    }
  std::stable_sort(slices.begin(), slices.end(), [](const Slice& a, const Slice& b) {
    return std::tuple(std::round(a.along * 1e3), a.header->instance) < std::tuple(std::round(b.along * 1e3), b.header->instance);
  });
  return slices;
}

template <class T>
void copy_pixels(const DicomHeader& h, const std::byte* from, std::span<T> to, std::span<float> scaled) {
  const int unused = static_cast<int>(8 * sizeof(T)) - h.stored;  // bits above the value may be anything
  using U = std::make_unsigned_t<T>;
  for (std::size_t i = 0; i < to.size(); ++i) {
    U bits;
    std::memcpy(&bits, from + i * sizeof(T), sizeof(T));
    to[i] = static_cast<T>(static_cast<T>(static_cast<U>(bits << unused)) >> unused);
    if (!scaled.empty()) scaled[i] = static_cast<float>(static_cast<double>(to[i]) * h.slope + h.intercept);
  }
}

template <class T>
FileArray values_of(const std::vector<Slice>& slices, ScalarType type, const ReadRequest& request) {
  const DicomHeader& first = *slices.front().header;
  const auto size = static_cast<std::size_t>(first.rows) * static_cast<std::size_t>(first.columns);
  const bool scaled = std::any_of(slices.begin(), slices.end(), [](const Slice& s) { return s.header->slope != 1 || s.header->intercept != 0; });
  auto [storage, values] = allocate<T>(size * (scaled ? 1 : slices.size()));
  auto [float_storage, floats] = allocate<float>(scaled ? size * slices.size() : 0);
  for (std::size_t k = 0; k < slices.size(); ++k) {
    const DicomHeader& h = *slices[k].header;
    const MappedFile file(h.file);
    const std::size_t begin = h.pixels + static_cast<std::size_t>(slices[k].frame) * h.frame_bytes();
    if (begin + h.frame_bytes() > file.bytes().size()) throw Error(ErrorCode::bad_data, h.file.filename().string() + ": became shorter while it was read");
    copy_pixels<T>(h, file.bytes().data() + begin, values.subspan(scaled ? 0 : k * size, size), scaled ? floats.subspan(k * size, size) : std::span<float>{});
    request.progress(static_cast<double>(k) / static_cast<double>(slices.size()));
  }
  FileArray array;
  array.name = first.modality == "CT" && (first.rescale_type == "HU" || first.rescale_type.empty()) ? "Hounsfield" : "intensity";
  array.unit = first.dose_unit == "GY" ? "Gy" : array.name == "Hounsfield" ? "HU" : "";
  array.type = scaled ? ScalarType::float32 : type;
  array.values = scaled ? std::as_bytes(floats) : std::as_bytes(values);
  array.storage = scaled ? std::shared_ptr<const void>(float_storage) : std::shared_ptr<const void>(storage);
  return array;
}

FileArray values_of(const std::vector<Slice>& slices, const ReadRequest& request) {
  const DicomHeader& h = *slices.front().header;
  if (h.bits == 8) return h.is_signed ? values_of<std::int8_t>(slices, ScalarType::int8, request) : values_of<std::uint8_t>(slices, ScalarType::uint8, request);
  if (h.bits == 16) return h.is_signed ? values_of<std::int16_t>(slices, ScalarType::int16, request) : values_of<std::uint16_t>(slices, ScalarType::uint16, request);
  return h.is_signed ? values_of<std::int32_t>(slices, ScalarType::int32, request) : values_of<std::uint32_t>(slices, ScalarType::uint32, request);
}

}  // namespace

bool is_dicom_slice(const fs::path& file) {
  if (!is_dicom(file)) return false;
  const DicomHeader header = parse_dicom(MappedFile(file).bytes(), file);
  return header.pixels > 0 && header.frames == 1;
}

Imported read_dicom(const ReadRequest& request) {
  std::error_code error;
  const bool folder = fs::is_directory(request.file, error);
  const bool several = folder || is_series_pattern(request.file);
  const std::string name = request.file.filename().string();
  std::vector<DicomHeader> headers;
  for (const fs::path& path : several ? dicom_files(request.file) : std::vector{request.file}) headers.push_back(parse_dicom(MappedFile(path).bytes(), path));
  if (!several && headers.front().frames == 1 && !headers.front().series.empty())  // the slices beside it
    for (const fs::path& path : dicom_files(request.file.parent_path()))
      if (path != request.file) headers.push_back(parse_dicom(MappedFile(path).bytes(), path));

  const std::size_t copies = leave_out_copies(headers);
  std::vector<std::vector<const DicomHeader*>> volumes;
  for (const DicomHeader& h : headers) {
    const bool own = &h == &headers.front();
    if (several && h.pixels == 0) continue;  // DICOMDIR, reports
    const auto same = std::find_if(volumes.begin(), volumes.end(), [&](const auto& volume) { return same_volume(*volume.front(), h); });
    if (same != volumes.end())
      same->push_back(&h);
    else if (several || own)
      volumes.push_back({&h});
  }
  if (volumes.empty()) throw Error(ErrorCode::unsupported, name + ": DICOM without pixels");
  const auto largest = std::max_element(volumes.begin(), volumes.end(), [](const auto& a, const auto& b) { return a.size() < b.size(); });
  for (const DicomHeader* h : *largest) check_pixels(*h);
  const DicomHeader& h = *largest->front();
  const auto& o = h.orientation;
  const Place normal{o[1] * o[5] - o[2] * o[4], o[2] * o[3] - o[0] * o[5], o[0] * o[4] - o[1] * o[3]};
  std::vector<Slice> slices = in_order(*largest, normal);

  // As many pictures at each place are so many times.
  std::size_t at_first = 1;
  while (at_first < slices.size() && std::abs(slices[at_first].along - slices[0].along) < 2e-3) ++at_first;
  for (std::size_t i = 0; i < slices.size(); ++i)
    if ((i % at_first == 0) != (i == 0 || std::abs(slices[i].along - slices[i - 1].along) >= 2e-3) || slices.size() % at_first != 0)
      throw Error(ErrorCode::unsupported, name + ": some places have more pictures than others (" + fullest_place(slices) + " have one place); expected a volume, or the same number of times at each place");
  Imported imported;
  imported.times.clear();
  for (std::size_t t = 0; t < at_first; ++t) imported.times.push_back(static_cast<double>(t));
  check_step(request, at_first);
  std::vector<Slice> step;
  for (std::size_t i = static_cast<std::size_t>(request.step); i < slices.size(); i += at_first) step.push_back(slices[i]);
  const std::int64_t points = checked_product({h.columns, h.rows, static_cast<std::int64_t>(step.size())}, name);
  check_bytes(request, static_cast<std::uint64_t>(points) * 4, name);

  Block block;
  const std::array<std::int64_t, 3> dims{h.columns, h.rows, static_cast<std::int64_t>(step.size())};
  std::array<Place, 3> by{};
  const double gaps = static_cast<double>(std::max<std::size_t>(step.size() - 1, 1));
  double uneven = 0;
  for (std::size_t a = 0; a < 3; ++a) {
    by[0][a] = o[a] * h.spacing[1];
    by[1][a] = o[3 + a] * h.spacing[0];
    by[2][a] = step.size() > 1 ? (step.back().at[a] - step.front().at[a]) / gaps : normal[a] * (h.thickness > 0 ? h.thickness : 1);
    for (Place* one : {&by[0], &by[1], &by[2]})
      if (std::abs((*one)[a]) < 1e-9) (*one)[a] = 0;
  }
  for (std::size_t k = 0; k < step.size(); ++k)
    uneven = std::max(uneven, std::abs(step[k].along - step[0].along - static_cast<double>(k) / gaps * (step.back().along - step[0].along)));
  place_image(block, dims, step.front().at, by, name);
  if (uneven > 0.01 * std::abs(step.back().along - step[0].along) / gaps) imported.notes.push_back("slices are not evenly spaced: some are up to " + std::to_string(uneven) + " mm from their place; a slice may be missing");
  block.arrays.push_back(values_of(step, request));
  imported.blocks.push_back(std::move(block));
  imported.axes = axes_in("mm");
  imported.notes.push_back("placed in the patient's space: x to the left, y to the back, z up");
  if (copies > 0) imported.notes.push_back(std::to_string(copies) + " files are left out: they are copies of others");
  if (volumes.size() > 1) imported.notes.push_back(std::to_string(volumes.size() - 1) + " other series of the folder skipped: the one of most slices is read");
  return imported;
}

}  // namespace isostrata
