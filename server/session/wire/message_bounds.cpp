#include "session/wire/message_bounds.h"

#include <google/protobuf/io/coded_stream.h>
#include <google/protobuf/wire_format_lite.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <utility>

namespace isostrata {
namespace {

using google::protobuf::Descriptor;
using google::protobuf::FieldDescriptor;
using google::protobuf::internal::WireFormatLite;
using google::protobuf::io::CodedInputStream;

constexpr int kDeepest = 100;  // as Protobuf's parser

class Counter {
 public:
  explicit Counter(std::string_view bytes)
      : in_(reinterpret_cast<const std::uint8_t*>(bytes.data()), static_cast<int>(bytes.size())) {}

  /// False at the first byte that makes no sense, or where `why` says that it is too much.
  bool count(const Descriptor* type, int depth) {
    Lists lists;
    while (const std::uint32_t tag = in_.ReadTag()) {
      if (++values_ > kMaxMessageValues) return too_much("more than " + std::to_string(kMaxMessageValues) + " fields");
      const int number = WireFormatLite::GetTagFieldNumber(tag);
      const FieldDescriptor* field = type ? type->FindFieldByNumber(number) : nullptr;
      if (field && field->is_repeated() && lists.add(number) > kMaxListed) return too_many(*field);
      if (WireFormatLite::GetTagWireType(tag) != WireFormatLite::WIRETYPE_LENGTH_DELIMITED) {
        if (!WireFormatLite::SkipField(&in_, tag)) return false;
        continue;
      }
      int size = 0;
      if (!in_.ReadVarintSizeAsInt(&size)) return false;
      if (field && field->is_packable() && static_cast<std::size_t>(size) > 10 * kMaxListed) return too_many(*field);
      if (!field || !field->message_type()) {
        if (!in_.Skip(size)) return false;
        continue;
      }
      if (depth >= kDeepest) return false;
      const auto before = in_.PushLimit(size);
      if (!count(field->message_type(), depth + 1)) return false;
      in_.PopLimit(before);
    }
    return true;
  }

  std::optional<std::string> why;

 private:
  /// How often each field came. Messages have few lists; of a field beyond those that are told apart all are counted together.
  struct Lists {
    std::array<std::pair<int, std::size_t>, 8> counts{};
    std::size_t add(int number) {
      auto it = std::find_if(counts.begin(), counts.end() - 1, [&](const auto& c) { return c.first == number || c.first == 0; });
      it->first = number;
      return ++it->second;
    }
  };
  bool too_much(std::string what) {
    why = std::move(what);
    return false;
  }
  bool too_many(const FieldDescriptor& field) {
    return too_much("more than " + std::to_string(kMaxListed) + " elements in '" + std::string(field.name()) + "'");
  }

  CodedInputStream in_;
  std::size_t values_ = 0;
};

}  // namespace

std::optional<std::string> holds_too_much(const Descriptor& type, std::string_view bytes) {
  Counter counter(bytes);
  counter.count(&type, 0);
  return counter.why;
}

}  // namespace isostrata
