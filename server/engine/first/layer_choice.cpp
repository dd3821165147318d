#include "engine/first/layer_choice.h"

namespace isostrata {

const char* to_string(FieldKind kind) {
  switch (kind) {
    case FieldKind::labels:
      return "labels";
    case FieldKind::image:
      return "image";
    case FieldKind::two_valued:
      return "two-valued";
    case FieldKind::waves:
      return "waves";
    case FieldKind::level_set:
      return "level set";
    case FieldKind::noise:
      return "noise";
    case FieldKind::sheet:
      return "sheet";
    case FieldKind::field:
      break;
  }
  return "field";
}

}  // namespace isostrata
