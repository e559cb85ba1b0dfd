// SPDX-License-Identifier: Apache-2.0
/// The digest SHA-256 (FIPS 180-4), by which records, models and files are known; OpenSSL works it out.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

struct evp_md_ctx_st;  // OpenSSL's EVP_MD_CTX

namespace gyrotherm {

using Digest = std::array<std::uint8_t, 32>;

/// Takes bytes piece by piece; how they are cut makes no difference. Many digests are asked of one: to begin another
/// takes longer than the digest of a row.
class Sha256 {
 public:
  Sha256();
  void add(std::string_view bytes);
  /// The digest of everything that was added since it began, or since the digest before; then it begins anew.
  [[nodiscard]] Digest digest();

 private:
  struct Free {
    void operator()(evp_md_ctx_st* context) const;
  };
  std::unique_ptr<evp_md_ctx_st, Free> context_;
};

/// The digest as 64 hexadecimal digits.
[[nodiscard]] std::string hex(const Digest& digest);

/// The digest of a text, as 64 hexadecimal digits.
[[nodiscard]] std::string sha256(std::string_view text);

}  // namespace gyrotherm
