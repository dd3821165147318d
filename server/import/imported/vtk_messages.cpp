#include "import/imported/vtk_messages.h"

#include <unistd.h>
#include <vtkObjectFactory.h>
#include <vtkOutputWindow.h>
#include <vtkSmartPointer.h>

#include <algorithm>
#include <csignal>
#include <cstring>

#include "base/error.h"

namespace isostrata {
namespace {

constexpr std::size_t kMostMessages = 20;

/// What VTK writes before it ends the process because memory is missing (9.4 and newer, as distributions build it).
constexpr const char* kNoMemory = "Unable to allocate";
volatile std::sig_atomic_t out_of_memory = 0;
/// In place of what VTK says of a reader that failed. Why it failed may be in a warning before it.
const std::string kGaveUp = "VTK's reader cannot read it";
std::string said_then;

/// abort after that says the same as every other want of memory; any other is a crash.
void on_abort(int) {
  std::signal(SIGABRT, SIG_DFL);
  if (!out_of_memory) return;  // abort goes on
  [[maybe_unused]] const ssize_t written = write(STDERR_FILENO, said_then.data(), said_then.size());
  _exit(1);
}

/// "vtkXMLReader (0x55)" -> "vtkXMLReader"
void erase_addresses(std::string& text) {
  for (auto at = text.find("(0x"); at != std::string::npos; at = text.find("(0x", at)) {
    const auto end = text.find_first_not_of("0123456789abcdef", at + 3);
    if (end == std::string::npos || text[end] != ')') {
      at += 3;
      continue;
    }
    const bool blank = at > 0 && text[at - 1] == ' ';
    text.erase(at - blank, end + 1 - at + blank);
  }
}

/// "ERROR: In FILE, line N\nvtkXMLDataReader (0x55): What happened.\n\n" -> "What happened."
std::string plain(std::string text) {
  if (text.find(" returned failure for request: ") != std::string::npos) return kGaveUp;  // what follows are its objects, as they lie in memory
  if (const auto header = text.find(", line "); header != std::string::npos)
    if (const auto end = text.find('\n', header); end != std::string::npos) text.erase(0, end + 1);
  if (text.starts_with("vtk"))
    if (const auto colon = text.find("): "); colon != std::string::npos && colon < 100) text.erase(0, colon + 3);
  erase_addresses(text);
  std::replace_if(
      text.begin(), text.end(), [](unsigned char c) { return c < 32 || c > 126; }, ' ');
  while (!text.empty() && text.back() == ' ') text.pop_back();
  return text.substr(0, 300);
}

class Messages : public vtkOutputWindow {
 public:
  static Messages* New();
  vtkTypeMacro(Messages, vtkOutputWindow)

      void DisplayText(const char*) override {}
  void DisplayErrorText(const char* text) override {
    const std::string line = plain(text ? text : "");
    if (std::none_of(passed_over.begin(), passed_over.end(), [&](const std::string& beginning) { return line.starts_with(beginning); })) keep(errors, text);
  }
  void DisplayWarningText(const char* text) override { keep_warning(text); }
  void DisplayGenericWarningText(const char* text) override { keep_warning(text); }

  std::vector<std::string> errors, warnings, passed_over;

 private:
  /// The legacy readers only warn of "Error reading ascii data" where a file ends within its numbers, and go on with zeros.
  void keep_warning(const char* text) {
    // A key of the program that wrote the file, which this one has no class for. There is nothing of the data in it.
    if (text && std::strstr(text, "Could not locate key ")) return;
    const bool lost_data =
        text && (std::strstr(text, "Error reading") || std::strstr(text, "rror parsing") || std::strstr(text, "ismatch"));
    keep(lost_data ? errors : warnings, text);
  }
  static void keep(std::vector<std::string>& messages, const char* text) {
    if (text && std::strstr(text, kNoMemory)) out_of_memory = 1;
    if (!text || messages.size() >= kMostMessages) return;
    std::string line = plain(text);
    if (std::find(messages.begin(), messages.end(), line) == messages.end()) messages.push_back(std::move(line));
  }
};

vtkStandardNewMacro(Messages);

vtkSmartPointer<Messages> messages;

}  // namespace

void collect_vtk_messages(const std::string& name) {
  said_then = "error too_large " + name + ": needs more memory than the import is allowed\n";
  messages = vtkSmartPointer<Messages>::New();
  vtkOutputWindow::SetInstance(messages);
  std::signal(SIGABRT, on_abort);
}

void throw_on_vtk_error(const std::string& name) {
  if (!messages || messages->errors.empty()) return;
  const std::string& first = messages->errors.front();
  const std::string why = first == kGaveUp && !messages->warnings.empty() ? ": " + messages->warnings.back() : "";
  throw Error(ErrorCode::bad_data, name + ": " + first + why);
}

std::vector<std::string> take_vtk_errors(const std::string& beginning) {
  std::vector<std::string> taken;
  if (!messages) return taken;
  std::erase_if(messages->errors, [&](const std::string& error) {
    if (!error.starts_with(beginning)) return false;
    taken.push_back(error.substr(beginning.size()));
    return true;
  });
  return taken;
}

void pass_over_vtk_errors(const std::string& beginning) {
  if (messages) messages->passed_over.push_back(beginning);
}

std::vector<std::string> vtk_warnings() { return messages ? messages->warnings : std::vector<std::string>{}; }

}  // namespace isostrata
