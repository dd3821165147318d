#include "session/journal/protobuf_log.h"

#include <google/protobuf/stubs/logging.h>

#include <chrono>
#include <mutex>
#include <utility>

#include "base/line_budget.h"

namespace isostrata {
namespace {

constexpr std::size_t kMostCharacters = 300;

// The handler is a plain function, so what it writes to is the process's. `mutex` guards both.
struct Lines {
  std::mutex mutex;
  std::function<void(const std::string&)> log;
  LineBudget budget{kProtobufLinesAMinute, std::chrono::minutes(1)};
};

Lines& lines() {
  static Lines* const lines = new Lines;  // threads may parse while the process ends
  return *lines;
}

void handle(google::protobuf::LogLevel, const char*, int, const std::string& message) {
  Lines& to = lines();
  const std::lock_guard lock(to.mutex);
  if (!to.log) return;
  const auto left_out = to.budget.take(std::chrono::steady_clock::now());
  if (!left_out) return;
  std::string text = "protobuf: " + message.substr(0, kMostCharacters);
  for (char& c : text)
    if (static_cast<unsigned char>(c) < ' ') c = ' ';
  if (*left_out > 0) text += " (" + std::to_string(*left_out) + " such lines before it were left out)";
  to.log(text);
}

}  // namespace

void set_protobuf_log(std::function<void(const std::string&)> log) {
  {
    Lines& to = lines();
    const std::lock_guard lock(to.mutex);
    to.log = std::move(log);
  }
  google::protobuf::SetLogHandler(handle);
}

}  // namespace isostrata
