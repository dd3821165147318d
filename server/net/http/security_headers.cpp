#include "net/http/security_headers.h"

namespace isostrata {

HttpHeaders security_headers(const HttpResponse& response) {
  const bool page = response.content_type.starts_with("text/html");
  return {
      {"X-Content-Type-Options", "nosniff"},
      {"Referrer-Policy", "no-referrer"},
      {"Cross-Origin-Resource-Policy", "same-origin"},
      {"X-Frame-Options", "SAMEORIGIN"},
      {"Content-Security-Policy",
       page ? "default-src 'none'; script-src 'self'; style-src 'self' 'sha256-ybGBFUfNbq1Yf3a5OY1HoEaYm7XwZb6wI2G0NxrIYK4='; "
              "img-src 'self' blob: data:; connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'self'"
            : "default-src 'none'; frame-ancestors 'self'"}};
}

}  // namespace isostrata
