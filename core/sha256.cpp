// SPDX-License-Identifier: Apache-2.0
#include "core/sha256.hpp"

#include <fmt/format.h>
#include <openssl/evp.h>

#include "core/process.hpp"

namespace gyrotherm {
namespace {

/// Returns OpenSSL's SHA-256. The algorithm is fetched only once, because fetching it takes longer than computing the
/// digest of a database row.
const EVP_MD* openssl_sha256() {
  static const EVP_MD* const found = EVP_MD_fetch(nullptr, "SHA256", nullptr);
  return found;
}

/// Starts a digest. With a null `digest` the context keeps its algorithm.
void begin(EVP_MD_CTX* context, const EVP_MD* digest) {
  ensure(context != nullptr && EVP_DigestInit_ex2(context, digest, nullptr) == 1, "OpenSSL can compute SHA-256");
}

}  // namespace

void Sha256::Free::operator()(evp_md_ctx_st* context) const { EVP_MD_CTX_free(context); }

Sha256::Sha256() : context_(EVP_MD_CTX_new()) { begin(context_.get(), openssl_sha256()); }

void Sha256::add(std::string_view bytes) { EVP_DigestUpdate(context_.get(), bytes.data(), bytes.size()); }

Digest Sha256::digest() {
  Digest digest;
  EVP_DigestFinal_ex(context_.get(), digest.data(), nullptr);
  begin(context_.get(), nullptr);
  return digest;
}

std::string hex(const Digest& digest) {
  std::string text;
  for (const auto byte : digest) text += fmt::format("{:02x}", byte);
  return text;
}

std::string sha256(std::string_view text) {
  Sha256 hash;
  hash.add(text);
  return hex(hash.digest());
}

}  // namespace gyrotherm
