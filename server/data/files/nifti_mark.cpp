#include "data/files/nifti_mark.h"

#include <string>
#include <utility>

namespace isostrata {
namespace {

/// The letter is + in one file, i in a header. The header's own size stands before it, in either byte order: 348 of NIfTI 1, 540 of NIfTI 2.
bool has_mark(std::string_view head, char letter) {
  using namespace std::string_view_literals;
  if (head.size() < 348) return false;
  const std::string_view size = head.substr(0, 4);
  const auto mark = [&](std::size_t at, char version) { return head.substr(at, 4) == std::string{'n', letter, version, '\0'}; };
  return ((size == "\x5c\x01\0\0"sv || size == "\0\0\x01\x5c"sv) && mark(344, '1')) || ((size == "\x1c\x02\0\0"sv || size == "\0\0\x02\x1c"sv) && mark(4, '2'));
}

}  // namespace

bool begins_as_nifti(std::string_view head) { return has_mark(head, '+'); }
bool begins_as_nifti_pair(std::string_view head) { return has_mark(head, 'i'); }

std::filesystem::path other_of_nifti_pair(const std::filesystem::path& file) {
  const std::string ending = file.extension().string();
  for (const auto& [one, other] : {std::pair{".hdr", ".img"}, std::pair{".img", ".hdr"}, std::pair{".HDR", ".IMG"}, std::pair{".IMG", ".HDR"}})
    if (ending == one) return std::filesystem::path(file).replace_extension(other);
  return {};
}

}  // namespace isostrata
