#include "session/wire/random_token.h"

#include <openssl/evp.h>
#include <openssl/hmac.h>
#include <unistd.h>

#include <array>
#include <span>

#include "base/error.h"

namespace isostrata {

namespace {

std::string hexadecimal(std::span<const unsigned char> bytes) {
  std::string text;
  for (const unsigned char byte : bytes)
    for (const int digit : {byte >> 4, byte & 15}) text += "0123456789abcdef"[digit];
  return text;
}

}  // namespace

std::string random_token(std::size_t bits) {
  std::array<unsigned char, 256> bytes{};
  if (bits / 8 > bytes.size() || getentropy(bytes.data(), bits / 8) != 0)
    throw Error(ErrorCode::unavailable, "the system gave no random numbers for a token");
  return hexadecimal({bytes.data(), bits / 8});
}

std::string proof_of(const std::string& secret, const std::string& text) {
  std::array<unsigned char, EVP_MAX_MD_SIZE> hash{};
  unsigned size = 0;
  if (!HMAC(EVP_sha256(), secret.data(), static_cast<int>(secret.size()), reinterpret_cast<const unsigned char*>(text.data()), text.size(),
            hash.data(), &size))
    throw Error(ErrorCode::internal, "OpenSSL has no HMAC-SHA-256");
  return hexadecimal({hash.data(), size});
}

std::string secret_hash(const std::string& secret) {
  std::array<unsigned char, EVP_MAX_MD_SIZE> hash{};
  unsigned size = 0;
  if (EVP_Digest(secret.data(), secret.size(), hash.data(), &size, EVP_sha256(), nullptr) != 1)
    throw Error(ErrorCode::internal, "OpenSSL has no SHA-256");
  return {reinterpret_cast<const char*>(hash.data()), size};
}

bool equal_in_constant_time(const std::string& a, const std::string& b) {
  if (a.size() != b.size()) return false;
  volatile unsigned char difference = 0;
  for (std::size_t i = 0; i < a.size(); ++i)
    difference = static_cast<unsigned char>(difference | (static_cast<unsigned char>(a[i]) ^ static_cast<unsigned char>(b[i])));
  return difference == 0;
}

}  // namespace isostrata
