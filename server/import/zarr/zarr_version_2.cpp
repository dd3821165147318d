#include <algorithm>
#include <numeric>

#include "import/zarr/zarr_json.h"
#include "import/zarr/zarr_metadata.h"

namespace isostrata {

namespace json = boost::json;

void take_version_2(ZarrArray& array, const json::object& of) {
  if (const json::value* format = member(of, "zarr_format"); !format || *format != 2) bad(array, "expected 'zarr_format' 2");
  array.shape = zarr_sizes(array, of, "shape");
  array.chunk = zarr_sizes(array, of, "chunks");
  const json::value* dtype = member(of, "dtype");
  if (!dtype) bad(array, "expected 'dtype', such as \"<u2\"");
  const std::string type = text_in(of, "dtype");
  if (type.size() != 3 || std::string_view("<>|=").find(type[0]) == std::string_view::npos) unsupported(array, "an array of type " + shown(*dtype) + "; expected one number in each point, such as \"<u2\"");
  take_zarr_type(array, std::string_view(type).substr(1));
  array.swap = type[0] == '>' && array.stored_width() > 1;
  take_zarr_fill(array, member(of, "fill_value"));
  const json::object none;
  const json::array* filters = array_in(of, "filters");
  for (const json::value& filter : filters ? *filters : json::array{}) {
    const json::object& settings = filter.is_object() ? filter.get_object() : none;
    const std::string id = filter.is_object() ? text_in(settings, "id") : shown(filter);
    if (array.codecs.empty() && take_zarr_filter(array, id, settings)) continue;
    if (id == "shuffle") array.codecs.push_back(zarr_codec(id, settings, array.file));
    else unsupported(array, "its values went through the filter '" + id.substr(0, 60) + "'; expected fixedscaleoffset, quantize, bitround, delta and shuffle, in this order, or none");
  }
  if (const json::value* compressor = member(of, "compressor")) {
    const json::object* named = compressor->if_object();
    array.codecs.push_back(zarr_codec(named ? text_in(*named, "id") : shown(*compressor), named ? *named : none, array.file));
  }
  const std::string order = text_in(of, "order"), separator = text_in(of, "dimension_separator");
  if (order != "C" && order != "F") bad(array, "'order' is '" + order.substr(0, 20) + "'; expected C or F");
  if (!separator.empty() && separator != "." && separator != "/") bad(array, "'dimension_separator' is '" + separator.substr(0, 20) + "'; expected . or /");
  if (!separator.empty()) array.separator = separator[0];
  array.order.resize(array.shape.size());
  std::iota(array.order.begin(), array.order.end(), std::size_t{0});
  if (order == "F") std::reverse(array.order.begin(), array.order.end());
}

}  // namespace isostrata
