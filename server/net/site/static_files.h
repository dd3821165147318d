// The page's files from one directory.
#pragma once

#include <filesystem>

#include "net/http/http_message.h"
#include "net/http/request_target.h"

namespace isostrata {

/// Files with an ETag; those under assets/ carry their content's hash in their names and are cached for good. Where NAME.br or
/// NAME.gz lies beside NAME, a client that takes that coding gets it in NAME's place. Nothing outside the directory is served,
/// links that lead out of it included. Files over 64 MiB are not served.
class StaticFiles {
 public:
  /// A root that has no index.html serves a page that says how to build it.
  explicit StaticFiles(std::filesystem::path root);

  bool built() const;
  HttpResponse get(const HttpRequest& request, const std::vector<std::string>& segments) const;

 private:
  const std::filesystem::path root_;  // canonical; empty: none
};

/// A small page with a title and a sentence.
HttpResponse message_page(int status, const std::string& title, const std::string& text);

/// Where the page is: `wanted` if given, else beside the installed program or in the source tree it was built in; empty where
/// there is none.
std::filesystem::path find_web_root(const std::filesystem::path& wanted);

}  // namespace isostrata
