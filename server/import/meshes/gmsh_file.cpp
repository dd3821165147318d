#include "import/meshes/gmsh_file.h"

#include <algorithm>
#include <cstring>

#include "import/bytes/swap_bytes.h"

namespace isostrata {
namespace {

GmshForm form_of(std::string_view section, const std::string& name) {
  TextNumbers words(section, name);
  const double version = words.number("the version of the format");
  GmshForm form;
  form.version = static_cast<int>(std::clamp(version, 0.0, 9.0));
  if (!(version >= 2 && version < 3) && version != 4.1)
    throw Error(ErrorCode::unsupported, name + ": is of version " + std::string(section.substr(0, section.find(' ')).substr(0, 16)) + " of Gmsh's format; expected 2.2 or 4.1: gmsh IN.msh -save -format msh41 -o OUT.msh");
  form.binary = words.integer("whether it is binary", 1) == 1;
  if (words.integer("the size of a number", 64) != 8) throw Error(ErrorCode::unsupported, name + ": its numbers do not have 8 bytes; expected 8");
  if (!form.binary) return form;
  words.skip_line();
  std::int32_t one = 0;
  const std::string_view bytes = words.take(sizeof one, "the number 1 that says its byte order");
  std::memcpy(&one, bytes.data(), sizeof one);
  form.swapped = one == 1 << 24;
  if (one != 1 && !form.swapped) throw Error(ErrorCode::bad_data, name + ": the number that says its byte order is " + std::to_string(one) + "; expected 1");
  return form;
}

}  // namespace

std::int64_t GmshNumbers::count(std::int64_t said, std::size_t least_bytes, const char* what) const {
  if (said < 0 || static_cast<std::uint64_t>(said) > words_.left() / least_bytes)
    throw Error(ErrorCode::bad_data, words_.name() + ": " + std::to_string(said) + " " + what + " declared, and " + std::to_string(words_.left()) + " bytes left for them");
  return said;
}

template <class T>
T GmshNumbers::binary(const char* what) {
  T value{};
  std::memcpy(&value, words_.take(sizeof value, what).data(), sizeof value);
  if (form_.swapped) swap_bytes(std::as_writable_bytes(std::span(&value, 1)), sizeof value);
  return value;
}

template std::int32_t GmshNumbers::binary(const char*);
template std::uint64_t GmshNumbers::binary(const char*);
template double GmshNumbers::binary(const char*);

GmshFile::GmshFile(std::string_view text, const std::string& name) {
  for (std::size_t at = text.find('$'); at < text.size(); at = text.find('$', at)) {
    const auto line = std::min(text.find('\n', at), text.size());
    std::string_view called = text.substr(at + 1, std::min<std::size_t>(line - at - 1, 64));
    called = called.substr(0, called.find_last_not_of(" \t\r") + 1);
    const std::string end = "$End" + std::string(called);
    const auto close = text.find(end, line);
    if (called.empty() || close == std::string_view::npos) throw Error(ErrorCode::bad_data, name + ": is cut off, or damaged: expected " + end);
    sections.emplace_back(called, text.substr(line + 1, close - line - 1));
    if (sections.size() > 1'000'000) throw Error(ErrorCode::too_large, name + ": has more than a million sections");
    at = close + end.size();
  }
  form = form_of(section("MeshFormat"), name);
}

std::string_view GmshFile::section(std::string_view of) const {
  const auto at = std::find_if(sections.begin(), sections.end(), [&](const auto& one) { return one.first == of; });
  return at == sections.end() ? std::string_view() : at->second;
}

}  // namespace isostrata
