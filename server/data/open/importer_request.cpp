#include "data/open/importer_request.h"

#include <algorithm>
#include <charconv>

#include "base/error.h"

namespace isostrata {

// The number, then each text, end with a null; an empty text stands between the words and the variables.
std::string to_packet(const ImporterRequest& request) {
  std::string packet = std::to_string(request.nice) + '\0';
  for (const std::string& word : request.words) (packet += word) += '\0';
  packet += '\0';
  for (const std::string& setting : request.environment) (packet += setting) += '\0';
  if (packet.size() > kMostRequest)
    throw Error(ErrorCode::invalid_argument, "names of files and folders take " + std::to_string(packet.size()) + " bytes; at most " +
                                                 std::to_string(kMostRequest) + " can be passed to the reader");
  return packet;
}

ImporterRequest from_packet(std::string_view packet) {
  ImporterRequest request;
  const std::string_view nice = packet.substr(0, packet.find('\0'));
  std::from_chars(nice.data(), nice.data() + nice.size(), request.nice);
  packet.remove_prefix(std::min(nice.size() + 1, packet.size()));
  for (auto* to = &request.words; !packet.empty();) {
    const std::string_view text = packet.substr(0, packet.find('\0'));
    if (text.empty() && to == &request.words)
      to = &request.environment;
    else
      to->emplace_back(text);
    packet.remove_prefix(std::min(text.size() + 1, packet.size()));
  }
  return request;
}

}  // namespace isostrata
