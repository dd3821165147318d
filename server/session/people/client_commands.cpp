#include "session/people/client_commands.h"

#include <algorithm>
#include <iterator>

namespace isostrata {

const ClientCommands::Newest* ClientCommands::find(const std::string& client) const {
  if (client.empty()) return nullptr;
  const auto it = std::ranges::find_if(all_, [&](const Newest& of) { return of.command.client == client; });
  return it == all_.end() ? nullptr : &*it;
}

bool ClientCommands::done_before(const CommandNumber& command, bool guest) {
  if (command.number == 0 || command.client.empty()) return false;
  if (command.number <= last(command.client)) return true;
  std::erase_if(all_, [&](const Newest& of) { return of.command.client == command.client; });
  const auto alike = [&](const Newest& of) { return of.guest == guest; };
  if (static_cast<std::size_t>(std::ranges::count_if(all_, alike)) >= kMostClients)
    all_.erase(std::prev(std::find_if(all_.rbegin(), all_.rend(), alike).base()));
  all_.push_front({command, guest});
  return false;
}

void ClientCommands::note_refused(const CommandNumber& command, const v1::Error& error) {
  for (Newest& of : all_)
    if (!command.client.empty() && of.command == command) of.error = error;
}

std::uint64_t ClientCommands::last(const std::string& client) const {
  const Newest* newest = find(client);
  return newest ? newest->command.number : 0;
}

const v1::Error* ClientCommands::last_error(const std::string& client) const {
  const Newest* newest = find(client);
  return newest && newest->error ? &*newest->error : nullptr;
}

}  // namespace isostrata
