#include "import/zarr/zarr_image.h"

#include <algorithm>
#include <cmath>

#include "data/files/recognise.h"
#include "import/imported/imported.h"
#include "import/zarr/zarr_json.h"

namespace isostrata {
namespace {

namespace json = boost::json;

/// The attributes of a group in which OME-Zarr's stand, and the file that has them.
struct Attributes {
  json::object of;
  std::string file;
};

Attributes attributes_of(ZarrStore& store, const std::string& folder) {
  if (auto of = store.read_json(folder + ".zattrs")) return {std::move(*of), store.name_of(folder + ".zattrs")};
  Attributes out{{}, store.name_of(folder + "zarr.json")};
  const std::optional<json::object> node = store.read_json(folder + "zarr.json");
  const json::object* all = node ? object_in(*node, "attributes") : nullptr;
  const json::object* ome = all ? object_in(*all, "ome") : nullptr;
  if (all) out.of = ome ? *ome : *all;
  return out;
}

ZarrRole role_of(const std::string& name, const std::string& type) {
  const std::string word = small_letters(type.empty() ? name : type);
  if (word == "time" || (type.empty() && word == "t")) return ZarrRole::time;
  if (word == "channel" || (type.empty() && word == "c")) return ZarrRole::channel;
  return type.empty() || word == "space" ? ZarrRole::space : ZarrRole::other;
}

std::vector<ZarrAxis> axes_of(const json::object& scales, const std::string& file) {
  std::vector<ZarrAxis> axes;
  const json::value* given = member(scales, "axes");
  if (!given) return axes;
  for (const json::value& axis : given->is_array() ? given->get_array() : json::array{}) {
    const json::object* of = axis.if_object();
    const std::string name = axis.is_string() ? std::string(axis.get_string()) : of ? text_in(*of, "name") : std::string();
    if (name.empty()) throw Error(ErrorCode::bad_data, file + ": an axis has no name");
    axes.push_back({name, role_of(name, of ? text_in(*of, "type") : std::string()), of ? text_in(*of, "unit") : std::string()});
  }
  if (axes.empty() || axes.size() > 8) throw Error(ErrorCode::bad_data, file + ": 'axes' is not a list of 1 to 8 axes");
  return axes;
}

/// place = translation + scale * index, then once more what `of` says.
void transform(std::vector<ZarrAxis>& axes, const json::object& of, const std::string& file) {
  const json::array* list = array_in(of, "coordinateTransformations");
  for (const json::value& one : list ? *list : json::array{}) {
    const json::object* step = one.if_object();
    const std::string type = step ? text_in(*step, "type") : std::string();
    if (type == "identity") continue;
    if (type != "scale" && type != "translation") throw Error(ErrorCode::unsupported, file + ": a coordinate transformation '" + type.substr(0, 40) + "'; expected scale or translation");
    const json::array* numbers = array_in(*step, type);
    if (!numbers || numbers->size() != axes.size())
      throw Error(ErrorCode::bad_data, file + ": the coordinate transformation '" + type + "' has no list of " + std::to_string(axes.size()) + " numbers, one for each axis");
    for (std::size_t a = 0; a < axes.size(); ++a) {
      boost::system::error_code error;
      const double number = (*numbers)[a].to_number<double>(error);
      if (error || !std::isfinite(number)) throw Error(ErrorCode::bad_data, file + ": the coordinate transformation '" + type + "' has something that is not a number");
      if (type == "scale") {
        axes[a].scale *= number;
        axes[a].translation *= number;
      } else {
        axes[a].translation += number;
      }
    }
  }
}

std::vector<std::string> channels_of(const json::object& attributes) {
  std::vector<std::string> labels;
  const json::object* omero = object_in(attributes, "omero");
  const json::array* channels = omero ? array_in(*omero, "channels") : nullptr;
  for (const json::value& channel : channels ? *channels : json::array{}) labels.push_back(channel.is_object() ? text_in(channel.get_object(), "label") : std::string());
  return labels;
}

}  // namespace

std::vector<ZarrAxis> axes_by_name(const ZarrArray& array) {
  std::vector<ZarrAxis> axes(array.shape.size());
  for (std::size_t a = 0; a < array.names.size(); ++a) {
    axes[a].name = array.names[a];
    axes[a].role = role_of(array.names[a], "");
  }
  return axes;
}

std::optional<ZarrImage> read_zarr_image(ZarrStore& store, const std::string& level) {
  ZarrImage image;
  Attributes attributes = attributes_of(store, "");
  std::string below;  // the folder of the image
  if (!array_in(attributes.of, "multiscales") && member(attributes.of, "bioformats2raw.layout")) {
    below = "0/";
    attributes = attributes_of(store, below);
    image.notes.push_back("the first image of the folder, '0'; others are opened by their folders, " + store.name() + "/1");
  }
  const json::array* all = array_in(attributes.of, "multiscales");
  if (!all || all->empty()) return std::nullopt;
  const auto& file = attributes.file;
  const json::object none;
  const json::object& scales = all->front().is_object() ? all->front().get_object() : none;
  const json::array* levels = array_in(scales, "datasets");
  if (!levels || levels->empty()) throw Error(ErrorCode::bad_data, file + ": 'multiscales' has no 'datasets'; expected a list with the 'path' of each level");
  std::size_t number = 0;
  const auto path_of = [&](std::size_t l) { return (*levels)[l].is_object() ? text_in((*levels)[l].get_object(), "path") : std::string(); };
  while (number < levels->size() && !level.empty() && path_of(number) != level) ++number;
  if (number == levels->size()) return std::nullopt;
  const std::string path = path_of(number);
  if (path.empty()) throw Error(ErrorCode::bad_data, file + ": a level has no 'path'");
  check_name_below(file, path);
  image.level = below + path;
  image.axes = axes_of(scales, file);
  if (!image.axes.empty()) {
    transform(image.axes, (*levels)[number].get_object(), file);
    transform(image.axes, scales, file);
  }
  image.channels = channels_of(attributes.of);
  if (levels->size() > 1)
    image.notes.push_back("level " + std::to_string(number + 1) + " of " + std::to_string(levels->size()) + ", '" + path + "'; another is opened by its folder, " +
                          store.name() + "/" + below + path_of(number == 0 ? 1 : 0));
  if (all->size() > 1) image.notes.push_back(std::to_string(all->size() - 1) + " other images of the folder skipped: the first is read");
  return image;
}

void refuse_zarr_group(ZarrStore& store) {
  const Attributes attributes = attributes_of(store, "");
  if (member(attributes.of, "plate") || member(attributes.of, "well"))
    throw Error(ErrorCode::unsupported, store.name() + ": a plate of wells, or one well; open one of its images, such as PLATE.zarr/A/1/0");
  std::string arrays;
  for (const std::string& name : store.parts(8)) arrays += (arrays.empty() ? "" : ", ") + store.name() + "/" + name;
  if (!arrays.empty()) throw Error(ErrorCode::unsupported, store.name() + ": a group, of whose parts none says what it means; open one of them: " + arrays);
  if (store.has(".zgroup") || store.has(".zattrs") || store.has("zarr.json"))
    throw Error(ErrorCode::bad_data, attributes.file + ": has no 'multiscales'; expected an OME-Zarr image, or an array");
  throw Error(ErrorCode::bad_data, store.name() + ": expected .zarray, .zattrs or zarr.json in it, as a Zarr array or image has");
}

}  // namespace isostrata
