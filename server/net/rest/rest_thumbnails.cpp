// Small pictures for lists of files.
#include <chrono>
#include <cstdio>
#include <functional>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <string_view>

#include "net/http/problem.h"
#include "net/rest/rest_routes.h"
#include "session/wire/wire.h"

namespace isostrata {
namespace {

/// Datasets that have none, and why. A file that cannot be read, or that ends the worker, is not tried again for a while, unless it changes. Lives on
/// the io thread.
class WithoutThumbnail {
 public:
  /// By what is known of the entry.
  static std::string key_of(const CatalogueEntry& of) {
    return version_id(of) + ' ' + std::to_string(of.mark) + ' ' + std::to_string(of.changed_unix_ms) + ' ' + std::to_string(of.bytes);
  }
  const v1::Error* find(const std::string& key) {
    const auto it = why_.find(key);
    if (it == why_.end()) return nullptr;
    if (rest_now() < it->second.until) return &it->second.error;
    why_.erase(it);
    return nullptr;
  }
  void add(const std::string& key, const v1::Error& error) {
    if (error.code() == "cancelled") return;
    if (why_.size() >= kMost) why_.clear();
    why_[key] = {error, rest_now() + kTime};
  }

 private:
  static constexpr std::size_t kMost = 10'000;
  static constexpr auto kTime = std::chrono::minutes(10);
  struct Why {
    v1::Error error;
    TimePoint until;
  };
  std::map<std::string, Why> why_;
};

/// By what is in the picture: one that is drawn again is the same.
HttpResponse picture(const HttpRequest& request, const Bytes& png) {
  std::string body(png.begin(), png.end());
  const std::string tag = "\"thumbnail-" + std::to_string(std::hash<std::string_view>{}(body)) + "\"";
  HttpResponse response{200, "image/png", std::move(body), {{"Cache-Control", "private, no-cache"}}};
  if (request.header("if-none-match") == tag) response = {304, "", "", {}};
  response.headers.emplace_back("ETag", tag);
  return response;
}

/// As a header can say it: what is not a plain letter by its bytes, as in addresses.
std::string plain_letters(const std::string& text) {
  std::string plain;
  char code[4];
  for (const char c : text)
    if (c >= ' ' && c <= '~' && c != '%')
      plain += c;
    else
      plain.append(code, static_cast<std::size_t>(std::snprintf(code, sizeof code, "%%%02X", static_cast<unsigned char>(c))));
  return plain;
}

/// A dataset that has none is not a mistake of whoever asks, and a list of files is full of them.
HttpResponse no_picture(const v1::Error& why) {
  static const std::set<std::string> kOfTheFile{"bad_data", "unsupported", "too_large", "not_found"};  // not_found: a file that it lists
  if (!kOfTheFile.contains(why.code())) return problem(why);
  HttpResponse response{204, "", "", {{"Cache-Control", "no-store"}}};
  response.headers.emplace_back("Isostrata-Reason", plain_letters(why.message().substr(0, 500)));
  return response;
}

void thumbnail(RestContext& context, const std::shared_ptr<WithoutThumbnail>& without, const Call& call) {
  const std::string& id = call.path.at("dataset");
  const CatalogueEntry* const entry = context.sessions.catalogue().find(id);
  if (!entry || entry->news == CatalogueNews::gone)
    return call.reply(problem(wire_error("not_found", "dataset '" + id.substr(0, 100) + (entry ? "': its files are gone" : "': not in this server's catalogue"))));
  if (entry->writing) return call.reply(problem(wire_error("unavailable", entry->name + ": is being written")));
  const std::string key = WithoutThumbnail::key_of(*entry);
  if (const v1::Error* why = without->find(key)) return call.reply(no_picture(*why));
  HttpRequest asked;  // as far as the answer needs it
  asked.headers = call.request.headers;
  give_up_with(call, context, context.sessions.ask(ThumbnailRequest{0, 0, id}, [asked, without, key, reply = call.reply](const EngineEvent& event, TimePoint) {
    if (const auto* failed = std::get_if<RequestFailed>(&event)) {
      const v1::Error error = wire_error(*failed);
      without->add(key, error);
      return reply(no_picture(error));
    }
    const auto* ready = std::get_if<ThumbnailReady>(&event);
    if (!ready || !ready->png) return reply(problem(wire_error("internal", "the process that draws sent no picture")));
    reply(picture(asked, *ready->png));
  }));
}

}  // namespace

void add_thumbnail_routes(std::vector<Route>& routes, RestContext& context) {
  routes.push_back({.method = "GET",
                    .path = "/datasets/{dataset}/thumbnail",
                    .id = "getThumbnail",
                    .tag = "datasets",
                    .summary = "A small picture of what is shown of a dataset first",
                    .description =
                        "192 x 144 pixels. Made in the background, one after the other for the whole server, when somebody asks; the answer waits for it, and "
                        "whoever goes ends it. Of what cannot be opened, has nothing to show, or has more than 128 MiB a step (unless its values lie in the "
                        "file as they are) there is none. An invitation's token suffices.",
                    .answers = {{200, "The picture", "", "image/png"},
                                {204, "There is none; the header Isostrata-Reason says why, in plain letters as an address has them", ""},
                                {304, "It is still that of If-None-Match", ""}},
                    .guests = true,
                    .handler = [&context, without = std::make_shared<WithoutThumbnail>()](Call call) { thumbnail(context, without, call); }});
}

}  // namespace isostrata
