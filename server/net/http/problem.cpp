#include "net/http/problem.h"

#include <boost/json/object.hpp>
#include <boost/json/serialize.hpp>

#include "base/utf8.h"

namespace isostrata {
namespace {

int status_of(const std::string& code) {
  if (code == "unauthorized") return 401;
  if (code == "forbidden") return 403;
  if (code == "not_found") return 404;
  if (code == "cancelled") return 409;
  if (code == "precondition_failed") return 412;
  if (code == "too_large") return 413;
  if (code == "bad_data" || code == "unsupported") return 422;
  if (code == "internal") return 500;
  if (code == "unavailable") return 503;
  return 400;
}

const char* hint_of(const std::string& code) {
  if (code == "not_found") return "GET api/v1/datasets and api/v1/sessions list what there is, api/v1/openapi.json every route";
  if (code == "invalid_argument") return "see the field named here; what was not changed is as it was";
  if (code == "malformed") return "the body is one JSON document in Protobuf's canonical form";
  if (code == "precondition_failed") return "GET the state again, apply your change to it, and send its new ETag as If-Match";
  if (code == "unavailable") return "try again later";
  if (code == "too_large") return "ask for less";
  return "";
}

}  // namespace

const char* status_phrase(int status) {
  switch (status) {
    case 400:
      return "Bad Request";
    case 401:
      return "Unauthorized";
    case 403:
      return "Forbidden";
    case 404:
      return "Not Found";
    case 405:
      return "Method Not Allowed";
    case 409:
      return "Conflict";
    case 411:
      return "Length Required";
    case 412:
      return "Precondition Failed";
    case 413:
      return "Content Too Large";
    case 415:
      return "Unsupported Media Type";
    case 422:
      return "Unprocessable Content";
    case 426:
      return "Upgrade Required";
    case 431:
      return "Request Header Fields Too Large";
    case 500:
      return "Internal Server Error";
    case 503:
      return "Service Unavailable";
    default:
      return "Error";
  }
}

HttpResponse problem(int status, const std::string& code, const std::string& message, const std::string& field) {
  boost::json::object document{
      {"type", "about:blank"}, {"title", status_phrase(status)}, {"status", status}, {"detail", message}, {"code", code}};
  if (!field.empty()) document["field"] = field;
  if (const std::string hint = hint_of(code); !hint.empty()) document["hint"] = hint;
  return {status, "application/problem+json", valid_json(boost::json::serialize(document)), {{"Cache-Control", "no-store"}}};
}

HttpResponse problem(const v1::Error& error) {
  return problem(status_of(error.code()), error.code(), error.message(), error.field());
}

}  // namespace isostrata
