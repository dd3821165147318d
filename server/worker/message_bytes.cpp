#include "worker/message_bytes.h"

#include <array>
#include <boost/pfr.hpp>
#include <cstring>
#include <filesystem>
#include <map>
#include <optional>
#include <type_traits>
#include <utility>
#include <vector>

namespace isostrata {
namespace {

template <class E>
constexpr E last_of = E::there_is_no_last_value_of_this_enum_here;
template <>
constexpr CatalogueNews last_of<CatalogueNews> = CatalogueNews::gone;
template <>
constexpr OnDisk last_of<OnDisk> = OnDisk::gone;
template <>
constexpr ErrorCode last_of<ErrorCode> = ErrorCode::internal;
template <>
constexpr SceneMode last_of<SceneMode> = SceneMode::smear;
template <>
constexpr ColorSpan last_of<ColorSpan> = ColorSpan::own;
template <>
constexpr Integral last_of<Integral> = Integral::table2d;
template <>
constexpr TimeMode last_of<TimeMode> = TimeMode::spacetime;
template <>
constexpr FieldValues last_of<FieldValues> = FieldValues::whole;
template <>
constexpr Triangulation last_of<Triangulation> = Triangulation::strict;
template <>
constexpr Codec last_of<Codec> = Codec::vp9_444;
template <>
constexpr StillFormat last_of<StillFormat> = StillFormat::exr;
template <>
constexpr FacetLabel last_of<FacetLabel> = FacetLabel::domain;
template <>
constexpr RangeOperator last_of<RangeOperator> = RangeOperator::exclusive_or;
template <>
constexpr ProbeEnd last_of<ProbeEnd> = ProbeEnd::eye;
template <>
constexpr RenderMode last_of<RenderMode> = RenderMode::prioritized;

class Writer {
 public:
  MessageBytes bytes;

  template <class T>
  void put(const T& value) {
    if constexpr (std::is_same_v<T, bool>) {
      bytes.body += value ? '\1' : '\0';
    } else if constexpr (std::is_enum_v<T>) {
      static_assert(last_of<T> >= T{});
      put(static_cast<std::underlying_type_t<T>>(value));
    } else if constexpr (std::is_arithmetic_v<T>) {
      bytes.body.append(reinterpret_cast<const char*>(&value), sizeof value);
    } else {
      write(value);
    }
  }

 private:
  void write(const std::string& text) {
    put<std::uint64_t>(text.size());
    bytes.body += text;
  }
  void write(const std::filesystem::path& path) { write(path.string()); }
  void write(const std::shared_ptr<const Bytes>& picture) { bytes.picture = picture; }
  void write(const Bytes& of) {
    put<std::uint64_t>(of.size());
    bytes.body.append(reinterpret_cast<const char*>(of.data()), of.size());
  }
  template <class T>
  void write(const std::shared_ptr<const T>& shared) {
    put(shared != nullptr);
    if (shared) put(*shared);
  }
  template <class T>
  void write(const std::optional<T>& value) {
    put(value.has_value());
    if (value) put(*value);
  }
  template <class T>
  void write(const std::vector<T>& list) {
    put<std::uint64_t>(list.size());
    for (const T& item : list) put(item);
  }
  template <class K, class V>
  void write(const std::map<K, V>& map) {
    put<std::uint64_t>(map.size());
    for (const auto& [key, value] : map) {
      put(key);
      put(value);
    }
  }
  template <class T, std::size_t n>
  void write(const std::array<T, n>& items) {
    for (const T& item : items) put(item);
  }
  template <class... T>
  void write(const std::variant<T...>& value) {
    static_assert(sizeof...(T) < 256);
    put(static_cast<std::uint8_t>(value.index()));
    std::visit([this](const auto& of) { put(of); }, value);
  }
  template <class T>
  void write(const T& aggregate) {
    boost::pfr::for_each_field(aggregate, [this](const auto& field) { put(field); });
  }
};

class Reader {
 public:
  explicit Reader(const MessageBytes& bytes) : rest_(bytes.body), picture_(bytes.picture) {}

  template <class T>
  T message() {
    T message;
    get(message);
    if (!rest_.empty()) fail();
    return message;
  }

 private:
  [[noreturn]] static void fail() { throw Error(ErrorCode::bad_data, "a message between processes of this program makes no sense"); }

  template <class T>
  void get(T& value) {
    if constexpr (std::is_same_v<T, bool>) {
      const auto byte = take<std::uint8_t>();
      if (byte > 1) fail();
      value = byte == 1;
    } else if constexpr (std::is_enum_v<T>) {
      const auto number = take<std::underlying_type_t<T>>();
      if (number < 0 || number > static_cast<std::underlying_type_t<T>>(last_of<T>)) fail();
      value = static_cast<T>(number);
    } else if constexpr (std::is_arithmetic_v<T>) {
      value = take<T>();
    } else {
      read(value);
    }
  }
  template <class T>
  T take() {
    T value;
    if (rest_.size() < sizeof value) fail();
    std::memcpy(&value, rest_.data(), sizeof value);
    rest_.remove_prefix(sizeof value);
    return value;
  }
  // No item takes less than a byte, so no count is believed that is larger than the rest.
  std::size_t count() {
    const auto count = take<std::uint64_t>();
    if (count > rest_.size()) fail();
    return static_cast<std::size_t>(count);
  }

  void read(std::string& text) {
    const std::size_t size = count();
    text = rest_.substr(0, size);
    rest_.remove_prefix(size);
  }
  void read(std::filesystem::path& path) {
    std::string text;
    read(text);
    path = text;
  }
  void read(std::shared_ptr<const Bytes>& picture) { picture = std::exchange(picture_, nullptr); }
  void read(Bytes& bytes) {
    const std::size_t size = count();
    bytes.assign(rest_.begin(), rest_.begin() + static_cast<std::ptrdiff_t>(size));
    rest_.remove_prefix(size);
  }
  template <class T>
  void read(std::shared_ptr<const T>& shared) {
    bool there = false;
    get(there);
    if (!there) return shared.reset();
    auto value = std::make_shared<T>();
    get(*value);
    shared = std::move(value);
  }
  template <class T>
  void read(std::optional<T>& value) {
    bool there = false;
    get(there);
    value.reset();
    if (there) get(value.emplace());
  }
  template <class T>
  void read(std::vector<T>& list) {
    list.clear();
    // One by one: a count that lies ends the message before it takes memory.
    for (std::size_t n = count(); n > 0; --n) get(list.emplace_back());
  }
  template <class K, class V>
  void read(std::map<K, V>& map) {
    map.clear();
    for (std::size_t n = count(); n > 0; --n) {
      K key;
      get(key);
      get(map[std::move(key)]);
    }
  }
  template <class T, std::size_t n>
  void read(std::array<T, n>& items) {
    for (T& item : items) get(item);
  }
  template <class... T>
  void read(std::variant<T...>& value) {
    alternative<0>(value, take<std::uint8_t>());
  }
  template <std::size_t i, class... T>
  void alternative(std::variant<T...>& value, std::size_t index) {
    if constexpr (i == sizeof...(T)) {
      fail();
    } else if (index == i) {
      get(value.template emplace<i>());
    } else {
      alternative<i + 1>(value, index);
    }
  }
  template <class T>
  void read(T& aggregate) {
    boost::pfr::for_each_field(aggregate, [this](auto& field) { get(field); });
  }

  std::string_view rest_;
  std::shared_ptr<const Bytes> picture_;
};

template <class T>
MessageBytes written(const T& message) {
  Writer writer;
  writer.put(message);
  return std::move(writer.bytes);
}

}  // namespace

MessageBytes to_bytes(const ToWorker& message) { return written(message); }
MessageBytes to_bytes(const FromWorker& message) { return written(message); }
MessageBytes to_bytes(const RankOrder& message) { return written(message); }
MessageBytes to_bytes(const RankReply& message) { return written(message); }
ToWorker to_worker(const MessageBytes& bytes) { return Reader(bytes).message<ToWorker>(); }
FromWorker from_worker(const MessageBytes& bytes) { return Reader(bytes).message<FromWorker>(); }
RankOrder to_rank_order(const MessageBytes& bytes) { return Reader(bytes).message<RankOrder>(); }
RankReply to_rank_reply(const MessageBytes& bytes) { return Reader(bytes).message<RankReply>(); }

}  // namespace isostrata
