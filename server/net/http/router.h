// Finds the route of a request.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "net/http/route.h"

namespace isostrata {

/// Immutable once made.
class Router {
 public:
  /// Throws internal if two routes have the same method and path.
  explicit Router(std::vector<Route> routes);

  struct Match {
    const Route* route = nullptr;             // null: no route, or another method
    std::string allowed;                      // "GET, HEAD, OPTIONS": of the path; empty if there is no such path
    std::map<std::string, std::string> path;  // the template's names
  };
  /// path: decoded segments below api/v1. HEAD is found as GET. A literal segment goes before a name.
  Match find(const std::string& method, const std::vector<std::string>& path) const;

  const std::vector<Route>& routes() const { return routes_; }

 private:
  std::vector<Route> routes_;
  std::vector<std::vector<std::string>> segments_;  // of each route's path
};

/// "/a/{b}" as "a", "{b}".
std::vector<std::string> path_segments(const std::string& path);

}  // namespace isostrata
