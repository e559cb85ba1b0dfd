// SPDX-License-Identifier: Apache-2.0
/// SHA-256 digests (FIPS 180-4), computed by OpenSSL. They identify records, models and files.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

struct evp_md_ctx_st;  // OpenSSL's EVP_MD_CTX

namespace gyrotherm {

using Digest = std::array<std::uint8_t, 32>;

/// Computes digests of bytes that arrive in pieces. Reuse one object for many digests: creating an object takes longer
/// than computing the digest of a database row.
class Sha256 {
 public:
  Sha256();
  void add(std::string_view bytes);
  /// Returns the digest of the bytes added since construction or since the previous call, and starts the next digest.
  [[nodiscard]] Digest digest();

 private:
  struct Free {
    void operator()(evp_md_ctx_st* context) const;
  };
  std::unique_ptr<evp_md_ctx_st, Free> context_;
};

/// Returns a digest as 64 hexadecimal digits.
[[nodiscard]] std::string hex(const Digest& digest);

/// Returns the digest of a text, as 64 hexadecimal digits.
[[nodiscard]] std::string sha256(std::string_view text);

}  // namespace gyrotherm
