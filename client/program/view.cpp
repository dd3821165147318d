// view: a server started where the data are, the way to it, and the browser here, in one command.
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <random>
#include <thread>

#include "arguments.h"
#include "child.h"
#include "forward.h"

namespace isostrata::client {
namespace {

constexpr std::size_t kLastWords = 1000;  // bytes: what a server says at its end

struct ViewArguments {
  std::string path;
  std::string program;  // there; empty: isostrata by the PATH of a login, else the download in the home directory
  std::string jump;
  int port = 0;
  bool no_browser = false;
};

struct Place {
  std::string host;  // empty: this machine
  std::string path;
};

/// As scp reads it: a colon before any slash ends a host. NAME:NUMBER is a built-in field.
Place place_of(const std::string& what) {
  const auto colon = what.find(':');
  if (colon == std::string::npos || what.find('/') < colon || colon == 0) return {"", what};
  if (colon + 1 < what.size() && what.find_first_not_of("0123456789x", colon + 1) == std::string::npos) return {"", what};
  std::string path = what.substr(colon + 1);
  if (path.starts_with("~/")) path.erase(0, 2);  // ssh begins in the home directory
  return {what.substr(0, colon), path};
}

/// One word for a shell, whatever is in it.
std::string quoted(const std::string& word) {
  std::string text = "'";
  for (const char letter : word) text += letter == '\'' ? std::string(R"('\'')") : std::string(1, letter);
  return text + "'";
}

/// A socket's path there that nobody can guess; the server lets its own user alone open it.
std::string new_socket() {
  std::random_device random;
  std::string name = "/tmp/isostrata-view-";
  for (int i = 0; i < 4; ++i) {
    char part[9];
    std::snprintf(part, sizeof part, "%08x", static_cast<unsigned>(random()));
    name += part;
  }
  return name;
}

/// By bash as at a login: clusters and users put programs into its PATH. The shell that ssh finds there may be any.
std::string command_there(const ViewArguments& arguments, const std::string& path, const std::string& socket) {
  const std::string program = arguments.program.empty() ? R"sh("$(command -v isostrata || echo "$HOME/isostrata/isostrata")")sh" : quoted(arguments.program);
  return "exec bash -lc " + quoted("exec " + program + " serve --socket " + socket + (path.empty() ? "" : " " + quoted(path)));
}

/// What the download's start script names, the program beside this one, or that of the PATH.
std::string program_here() {
  if (const char* named = std::getenv("ISOSTRATA_PROGRAM")) return named;
  std::error_code error;
  const std::filesystem::path beside = std::filesystem::read_symlink("/proc/self/exe", error).parent_path() / "isostrata";
  return !error && std::filesystem::exists(beside, error) ? beside.string() : "isostrata";
}

/// The first address in what a server has printed; empty while there is no whole one.
std::string address_in(const std::string& printed) {
  const auto at = std::min(printed.find("http://"), printed.find("https://"));
  if (at == std::string::npos) return {};
  const auto end = printed.find_first_of(" \r\n", at);
  return end == std::string::npos ? std::string() : printed.substr(at, end - at);
}

std::string last_line(std::string text) {
  std::erase(text, '\r');
  while (text.ends_with('\n')) text.pop_back();
  return text.substr(text.rfind('\n') + 1);
}

ClientError ended(const Place& place, int status, const std::string& printed) {
  const std::string who = place.host.empty() ? "the server" : place.host;
  if (status == 127 && printed.empty()) return {"unavailable", place.host.empty() ? "there is no program 'isostrata' here" : "there is no program 'ssh' here"};
  if (const std::string said = last_line(printed); !said.empty()) return {"connection", who + ": " + said};
  return {"connection", (place.host.empty() ? "the server ended" : "ssh to " + place.host + " ended") + " with status " + std::to_string(status)};
}

/// Of a machine with a desktop, or with $BROWSER.
std::unique_ptr<Child> open_browser(const std::string& url) {
  const auto is_set = [](const char* name) { return std::getenv(name) && *std::getenv(name); };
  if (!is_set("DISPLAY") && !is_set("WAYLAND_DISPLAY") && !is_set("BROWSER")) return nullptr;
  return std::make_unique<Child>(std::vector<std::string>{"xdg-open", url}, true);
}

void view(const Options& options, const ViewArguments& arguments) {
  const Place place = place_of(arguments.path);
  std::vector<std::string> command{program_here(), "serve", "--port", std::to_string(arguments.port)};
  if (!place.path.empty()) command.push_back(place.path);
  int port = arguments.port;
  if (!place.host.empty()) {
    const std::string socket = new_socket();
    port = port ? free_port(port, true) : free_port(8080, false);
    // -tt: the server there ends when the line does. One line for both, so that a password is asked for once.
    command = {"ssh", "-tt", "-o", "ExitOnForwardFailure=yes", "-o", "ServerAliveInterval=30", "-L", "127.0.0.1:" + std::to_string(port) + ":" + socket};
    if (!arguments.jump.empty()) command.insert(command.end(), {"-J", arguments.jump});
    command.insert(command.end(), {"--", place.host, command_there(arguments, place.path, socket)});
  }
  Child server(command, true);
  const auto stopped = [&] { return options.stop && *options.stop; };

  std::string printed, address;
  while (address.empty()) {
    if (stopped()) return;
    const std::optional<std::string> part = server.part();
    if (!part) throw ended(place, server.wait(), printed);
    printed += *part;
    address = address_in(printed);
  }
  Options here = options;
  here.url = place.host.empty() ? address : address_here(address, port);
  for (const auto last = std::chrono::steady_clock::now() + options.timeout; !answers(here);) {
    if (stopped()) return;
    if (const auto status = server.status()) throw ended(place, *status, printed);
    if (std::chrono::steady_clock::now() > last)
      throw ClientError("timeout", "the server runs and does not answer here" +
                                       std::string(place.host.empty() ? "" : ": does ssh there refuse to forward sockets (AllowStreamLocalForwarding)?"));
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
  const std::string what = place.path.empty() ? "a built-in field" : place.path;
  std::printf("%s serves %s until Ctrl-C.\n\nOpen  %s\n\n", place.host.empty() ? "This machine" : place.host.c_str(), what.c_str(), here.url.c_str());
  std::fflush(stdout);
  const std::unique_ptr<Child> browser = arguments.no_browser ? nullptr : open_browser(here.url);
  std::string rest;
  while (!stopped()) {
    const std::optional<std::string> part = server.part();
    if (!part) throw ended(place, server.wait(), rest);
    std::fputs(part->c_str(), stderr);  // what the server says
    rest += *part;
    if (rest.size() > kLastWords) rest.erase(0, rest.size() - kLastWords);
  }
}

}  // namespace

void add_view(CLI::App& app, Options& options) {
  CLI::App* command = app.add_subcommand(
      "view", "Starts a server for a file or a folder, on this machine or by ssh on another, opens the browser here, and stays until Ctrl-C, which ends the server. Needs no URL");
  const auto arguments = std::make_shared<ViewArguments>();
  command->add_option("path", arguments->path, "What the server is to show: a path, or a built-in field such as torus:64; there, from the home directory of the user")->required()->type_name("[[USER@]HOST:]PATH");
  command->add_option("--program", arguments->program, "The program there (default: isostrata, if a login has it in its PATH, else isostrata/isostrata in the home directory)")->type_name("PATH");
  command->add_option("--jump", arguments->jump, "A gate on the way, as ssh -J takes it")->type_name("[USER@]HOST");
  command->add_option("--port", arguments->port, "Port of this machine (default: a free one)")->check(CLI::Range(1, 65535));
  command->add_flag("--no-browser", arguments->no_browser, "Prints the address and opens no browser");
  command->callback([&options, arguments] { view(options, *arguments); });
}

}  // namespace isostrata::client
