// How much a message may hold, looked at before it is made: parsing hundreds of thousands of empty elements takes longer than all
// that is done with a message that makes sense.
#pragma once

#include <google/protobuf/descriptor.h>

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace isostrata {

constexpr std::size_t kMaxListed = 1024;          // elements of one list; no command has as many
constexpr std::size_t kMaxMessageValues = 20000;  // fields of a message and of those in it; the fullest state has some 12,000

/// Why bytes of a message of this type hold too much; nothing if they do not. What is not a message is left to the parser to say.
/// In time linear in the bytes, and without memory.
std::optional<std::string> holds_too_much(const google::protobuf::Descriptor& type, std::string_view bytes);

}  // namespace isostrata
