// Secrets and names that cannot be guessed.
#pragma once

#include <cstddef>
#include <string>

namespace isostrata {

/// bits / 4 hexadecimal digits from the kernel's generator; bits must be a multiple of 8 and at most 2048. Throws unavailable.
std::string random_token(std::size_t bits);

/// SHA-256 of a secret that random_token made: what is kept where the secret itself must not be. 32 bytes.
std::string secret_hash(const std::string& secret);

/// HMAC-SHA-256, RFC 2104, of the text under the secret, as 64 hexadecimal digits: shows that whoever made it knew the secret, and does
/// not tell it.
std::string proof_of(const std::string& secret, const std::string& text);

/// Takes as long for every pair of texts of the same length, so that the time tells nothing of a secret.
bool equal_in_constant_time(const std::string& a, const std::string& b);

}  // namespace isostrata
