#include "net/http/router.h"

#include <algorithm>
#include <set>

#include "base/error.h"

namespace isostrata {
namespace {

bool is_name(const std::string& segment) { return segment.starts_with('{'); }

bool matches(const std::vector<std::string>& pattern, const std::vector<std::string>& path) {
  if (pattern.size() != path.size()) return false;
  for (std::size_t i = 0; i < path.size(); ++i)
    if (!is_name(pattern[i]) && pattern[i] != path[i]) return false;
  return true;
}

}  // namespace

std::vector<std::string> path_segments(const std::string& path) {
  std::vector<std::string> segments;
  for (std::size_t at = 1; at < path.size();) {
    const std::size_t slash = std::min(path.find('/', at), path.size());
    segments.push_back(path.substr(at, slash - at));
    at = slash + 1;
  }
  return segments;
}

Router::Router(std::vector<Route> routes) : routes_(std::move(routes)) {
  std::set<std::string> known;
  for (const Route& route : routes_) {
    if (!known.insert(route.method + " " + route.path).second)
      throw Error(ErrorCode::internal, "the route " + route.method + " " + route.path + " stands twice");
    segments_.push_back(path_segments(route.path));
  }
}

Router::Match Router::find(const std::string& method, const std::vector<std::string>& path) const {
  const std::string wanted = method == "HEAD" ? "GET" : method;
  Match match;
  std::size_t names = path.size() + 1;  // of the best pattern so far
  std::size_t best = routes_.size();    // none
  for (std::size_t i = 0; i < routes_.size(); ++i) {
    if (!matches(segments_[i], path)) continue;
    const auto here = static_cast<std::size_t>(std::count_if(segments_[i].begin(), segments_[i].end(), is_name));
    if (here > names) continue;
    if (here < names) {
      match = {};
      best = routes_.size();
      names = here;
    }
    match.allowed += routes_[i].method + (routes_[i].method == "GET" ? ", HEAD, " : ", ");
    if (routes_[i].method == wanted) best = i;
  }
  if (match.allowed.empty()) return match;
  match.allowed += "OPTIONS";
  if (best == routes_.size()) return match;
  match.route = &routes_[best];
  for (std::size_t i = 0; i < path.size(); ++i)
    if (const std::string& name = segments_[best][i]; is_name(name)) match.path[name.substr(1, name.size() - 2)] = path[i];
  return match;
}

}  // namespace isostrata
