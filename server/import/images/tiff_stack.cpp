#include "import/images/tiff_stack.h"

#include <vtkSmartPointer.h>
#include <vtkXMLDataElement.h>
#include <vtkXMLUtilities.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <set>
#include <string_view>

#include "import/bytes/parsed_number.h"
#include "import/imported/xml_arrays.h"

namespace isostrata {
namespace {

constexpr std::int64_t kMostPlanes = 10'000'000;

std::optional<double> real_number(std::string_view text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc{} && std::isfinite(value) ? std::optional(value) : std::nullopt;
}
std::optional<double> positive(std::string_view text) {
  const std::optional<double> value = real_number(text);
  return value && *value != 0 ? std::optional(std::abs(*value)) : std::nullopt;
}
std::int64_t count(std::string_view text, std::int64_t otherwise) {
  const std::optional<std::uint64_t> value = parsed_number<std::uint64_t>(text);
  return value && *value >= 1 && *value <= static_cast<std::uint64_t>(kMostPlanes) ? static_cast<std::int64_t>(*value) : text.empty() ? otherwise : 0;
}
bool too_many(const TiffStack& stack) {
  return stack.channels < 1 || stack.slices < 1 || stack.frames < 1 || stack.channels > kMostPlanes / stack.slices || stack.channels * stack.slices > kMostPlanes / stack.frames;
}
std::size_t plane(const TiffStack& stack, std::int64_t z, std::int64_t c, std::int64_t t) { return static_cast<std::size_t>((t * stack.channels + c) * stack.slices + z); }

std::string counts(const TiffStack& stack) {
  return std::to_string(stack.channels) + " channels, " + std::to_string(stack.slices) + " slices and " + std::to_string(stack.frames) + " frames";
}

/// Java's "\u00B5", of the letters that units have.
std::string unescaped(std::string text) {
  for (const auto& [escaped, letter] : {std::pair{"\\u00B5", "µ"}, std::pair{"\\u00b5", "µ"}, std::pair{"\\u00C5", "Å"}, std::pair{"\xb5", "µ"}})
    if (text.starts_with(escaped)) text.replace(0, std::string_view(escaped).size(), letter);
  return text;
}

std::optional<TiffStack> of_imagej(const TiffDirectory& directory, std::string& why) {
  std::map<std::string, std::string, std::less<>> said;
  std::string_view rest = directory.description;
  while (!rest.empty()) {
    std::string_view line = rest.substr(0, rest.find('\n'));
    rest.remove_prefix(std::min(line.size() + 1, rest.size()));
    if (line.ends_with('\r')) line.remove_suffix(1);
    if (const auto equals = line.find('='); equals != std::string_view::npos) said[std::string(line.substr(0, equals))] = line.substr(equals + 1);
  }
  const auto value = [&](std::string_view key) { const auto at = said.find(key); return at == said.end() ? std::string_view() : std::string_view(at->second); };
  TiffStack stack;
  const std::int64_t images = count(value("images"), 1);
  stack.channels = count(value("channels"), 1);
  stack.frames = count(value("frames"), 1);
  stack.slices = count(value("slices"), stack.channels * stack.frames == 1 ? std::max<std::int64_t>(images, 1) : 1);
  if (too_many(stack) || stack.planes() != images) {
    why = "ImageJ's description says " + std::to_string(images) + " images in " + counts(stack) + ": its pages are read as slices";
    return std::nullopt;
  }
  stack.pages.resize(static_cast<std::size_t>(images));
  for (std::int64_t page = 0; page < images; ++page)
    stack.pages[plane(stack, page / stack.channels % stack.slices, page % stack.channels, page / (stack.channels * stack.slices))] = page;
  stack.unit = unescaped(std::string(value("unit")));
  if (stack.unit == "pixel" || stack.unit == "pixels") stack.unit.clear();
  if ((!stack.unit.empty() || directory.resolution_unit == 1) && directory.x_resolution > 0 && directory.y_resolution > 0) {
    stack.spacing = {1 / directory.x_resolution, 1 / directory.y_resolution, 1};
    stack.placed = true;
  }
  stack.spacing[2] = positive(value("spacing")).value_or(1);
  const std::optional<double> rate = positive(value("fps"));
  stack.interval = positive(value("finterval")).value_or(rate ? 1 / *rate : 0);
  if (stack.interval > 0) stack.time_unit = value("tunit").empty() ? "sec" : unescaped(std::string(value("tunit")));
  stack.pages_in_one = true;
  const std::optional<double> offset = real_number(value("c0")), scale = real_number(value("c1"));
  if (offset && scale && *offset == -32768 && *scale == 1)
    stack.raised = true;
  else if (offset && scale && (*offset != 0 || *scale != 1))
    stack.notes.push_back("values are as they are stored; the file's calibration is " + std::string(value("c0")) + " + " + std::string(value("c1")) + " * value");
  return stack;
}

std::string_view local_name(vtkXMLDataElement* element) {
  std::string_view name = element->GetName() ? element->GetName() : "";
  return name.substr(name.find(':') == std::string_view::npos ? 0 : name.find(':') + 1);
}
std::vector<vtkXMLDataElement*> children(vtkXMLDataElement* of, std::string_view name) {
  std::vector<vtkXMLDataElement*> out;
  for (int i = 0; of && i < of->GetNumberOfNestedElements(); ++i)
    if (local_name(of->GetNestedElement(i)) == name) out.push_back(of->GetNestedElement(i));
  return out;
}

/// Metres of the units that microscopes have; nothing for others, such as pixels.
std::optional<double> metres(std::string_view unit) {
  for (const auto& [name, length] : {std::pair<std::string_view, double>{"µm", 1e-6}, {"μm", 1e-6}, {"um", 1e-6}, {"nm", 1e-9}, {"mm", 1e-3}, {"cm", 1e-2}, {"m", 1}, {"pm", 1e-12}, {"Å", 1e-10}})
    if (unit == name) return length;
  return std::nullopt;
}

void take_places(TiffStack& stack, vtkXMLDataElement* pixels) {
  static constexpr std::array<std::array<const char*, 2>, 3> kNames{{{"PhysicalSizeX", "PhysicalSizeXUnit"}, {"PhysicalSizeY", "PhysicalSizeYUnit"}, {"PhysicalSizeZ", "PhysicalSizeZUnit"}}};
  std::array<std::optional<double>, 3> size;
  for (std::size_t a = 0; a < 3; ++a) {
    if (!(size[a] = positive(attribute(pixels, kNames[a][0])))) continue;
    std::string unit(attribute(pixels, kNames[a][1]));
    if (unit.empty()) unit = "µm";
    if (stack.unit.empty()) stack.unit = unit;
    const std::optional<double> own = metres(unit), first = metres(stack.unit);
    if (unit != stack.unit && own && first) *size[a] *= *own / *first;
    if (unit != stack.unit && !(own && first)) stack.notes.push_back("units of length: " + unit + " beside " + stack.unit + ", which nothing turns into each other");
  }
  stack.placed = size[0] && size[1];
  stack.spacing = {size[0].value_or(1), size[1].value_or(1), size[2].value_or(1)};
  stack.interval = positive(attribute(pixels, "TimeIncrement")).value_or(0);
  stack.time_unit = attribute(pixels, "TimeIncrementUnit").empty() ? "s" : attribute(pixels, "TimeIncrementUnit");
}

/// The place of each plane, as "DimensionOrder" counts them.
std::size_t in_order(const TiffStack& stack, std::string_view order, std::int64_t number) {
  std::int64_t z = 0, c = 0, t = 0;
  for (const char axis : order.substr(2)) {
    const std::int64_t size = axis == 'Z' ? stack.slices : axis == 'C' ? stack.channels : stack.frames;
    (axis == 'Z' ? z : axis == 'C' ? c : t) = number % size;
    number /= size;
  }
  return plane(stack, z, c, t);
}

std::int64_t number_of(const TiffStack& stack, std::string_view order, std::int64_t z, std::int64_t c, std::int64_t t) {
  std::int64_t number = 0, step = 1;
  for (const char axis : order.substr(2)) {
    number += step * (axis == 'Z' ? z : axis == 'C' ? c : t);
    step *= axis == 'Z' ? stack.slices : axis == 'C' ? stack.channels : stack.frames;
  }
  return number;
}

/// False: some of the planes lie in other files, or a place makes no sense.
bool take_pages(TiffStack& stack, vtkXMLDataElement* pixels, std::string_view order, int samples, std::string& why) {
  stack.pages.assign(static_cast<std::size_t>(stack.planes()), -1);
  const std::vector<vtkXMLDataElement*> blocks = children(pixels, "TiffData");
  std::set<std::string> files;
  for (vtkXMLDataElement* block : blocks)
    for (vtkXMLDataElement* of : children(block, "UUID")) files.insert(std::string(attribute(of, "FileName")));
  if (files.size() > 1) {
    why = "one of the " + std::to_string(files.size()) + " files of an OME-TIFF: the pages of this one are read as slices";
    return false;
  }
  if (blocks.empty())
    for (std::int64_t n = 0; n < stack.planes(); ++n) stack.pages[in_order(stack, order, n)] = n;
  for (vtkXMLDataElement* block : blocks) {
    const auto whole = [&](const char* name) { return static_cast<std::int64_t>(std::min<std::uint64_t>(parsed_number<std::uint64_t>(attribute(block, name)).value_or(0), kMostPlanes)); };
    const std::int64_t page = whole("IFD"), z = whole("FirstZ"), c = whole("FirstC") / samples, t = whole("FirstT");
    if (z >= stack.slices || c >= stack.channels || t >= stack.frames) {
      why = "OME-TIFF's description has a plane beyond its own " + counts(stack) + ": its pages are read as slices";
      return false;
    }
    const std::int64_t first = number_of(stack, order, z, c, t);
    const bool one = !attribute(block, "IFD").empty() && attribute(block, "PlaneCount").empty();
    const std::int64_t planes = one ? 1 : attribute(block, "PlaneCount").empty() ? stack.planes() - first : std::min(whole("PlaneCount"), stack.planes() - first);
    for (std::int64_t n = 0; n < planes; ++n) stack.pages[in_order(stack, order, first + n)] = page + n;
  }
  return true;
}

std::optional<TiffStack> of_ome(const TiffDirectory& directory, int samples, std::string& why) {
  const auto root = vtkSmartPointer<vtkXMLDataElement>::Take(vtkXMLUtilities::ReadElementFromString(directory.description.c_str()));
  if (!root || local_name(root) != "OME") return std::nullopt;
  const std::vector<vtkXMLDataElement*> images = children(root, "Image");
  const std::vector<vtkXMLDataElement*> all = images.empty() ? images : children(images.front(), "Pixels");
  if (all.empty()) {
    if (!children(root, "BinaryOnly").empty()) why = "its OME description stands in another file: its pages are read as slices";
    return std::nullopt;
  }
  vtkXMLDataElement* const pixels = all.front();
  TiffStack stack;
  std::string sorted, order(attribute(pixels, "DimensionOrder"));
  sorted = order;
  std::sort(sorted.begin(), sorted.end());
  const std::int64_t components = count(attribute(pixels, "SizeC"), 1);
  stack.channels = components % samples == 0 ? components / samples : components;
  stack.slices = count(attribute(pixels, "SizeZ"), 1);
  stack.frames = count(attribute(pixels, "SizeT"), 1);
  if (too_many(stack) || sorted != "CTXYZ" || !order.starts_with("XY")) {
    why = "OME-TIFF's description makes no sense: DimensionOrder '" + order.substr(0, 20) + "', " + counts(stack) + ": its pages are read as slices";
    return std::nullopt;
  }
  if (!take_pages(stack, pixels, order, samples, why)) return std::nullopt;
  take_places(stack, pixels);
  for (vtkXMLDataElement* channel : children(pixels, "Channel")) stack.names.emplace_back(attribute(channel, "Name"));
  if (images.size() > 1) stack.notes.push_back(std::to_string(images.size() - 1) + " other images of the file skipped: the first is read");
  return stack;
}

}  // namespace

std::optional<TiffStack> describe_tiff_stack(const TiffDirectory& directory, int samples, std::string& why) {
  if (directory.description.starts_with("ImageJ=")) return of_imagej(directory, why);
  if (directory.description.find("<OME") != std::string::npos || directory.description.find(":OME ") != std::string::npos) return of_ome(directory, samples, why);
  return std::nullopt;
}

}  // namespace isostrata
