// Taking values out of JSON that others wrote, with errors that name the file and the member.
#pragma once

#include <boost/json/value.hpp>
#include <string>
#include <string_view>

#include "base/error.h"

namespace isostrata {

/// The member, or null if there is none or it is JSON's null.
inline const boost::json::value* member(const boost::json::object& of, std::string_view name) {
  const boost::json::value* value = of.if_contains(name);
  return value && !value->is_null() ? value : nullptr;
}
inline const boost::json::object* object_in(const boost::json::object& of, std::string_view name) {
  const boost::json::value* value = member(of, name);
  return value ? value->if_object() : nullptr;
}
inline const boost::json::array* array_in(const boost::json::object& of, std::string_view name) {
  const boost::json::value* value = member(of, name);
  return value ? value->if_array() : nullptr;
}
/// Empty if there is none, or it is not text.
inline std::string text_in(const boost::json::object& of, std::string_view name) {
  const boost::json::value* value = member(of, name);
  return value && value->is_string() ? std::string(value->get_string()) : std::string();
}

}  // namespace isostrata
