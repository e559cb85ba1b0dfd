// SPDX-License-Identifier: Apache-2.0
/// Signs certificates (XML, with xmlsec1), PDFs (with pdfsig) and other files (with openssl), and verifies the
/// signatures. In all cases openssl verifies the certificate of the key. None of these functions uses the network.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "core/result.hpp"
#include "report/other_program.hpp"
#include "report/xml_reader.hpp"

namespace gyrotherm::report {

/// Signing key of a laboratory: RSA, PEM.
struct SigningKey {
  std::string key_file{};
  /// The key's certificate first, then the intermediate certificates.
  std::string certificate_file{};
  /// File with the password of the key on its first line; empty if the key has no password, or if openssl is to prompt
  /// for it.
  std::string password_file{};
};

/// Trust settings of the verifier.
struct Trust {
  /// PEM file with the certificates of trusted authorities, or of the laboratory itself.
  std::string certificates_file{};
  /// Day for which the certificates must be valid, such as "2026-11-25"; absent for today.
  std::optional<std::string> on_day{};
};

/// Identity of a signer, from the certificate of the key.
struct Signer {
  std::string subject{}, issuer{};  ///< RFC 2253
  std::string serial_number{};      ///< hexadecimal
  std::string fingerprint{};        ///< SHA-256 of the certificate
  int rsa_bits{};                   ///< length of the RSA key; 0: another kind of key
  std::string not_after{};          ///< end of validity, openssl's format
  bool operator==(const Signer&) const = default;
};

/// Fails with bad_file if a key cannot sign: key or certificate cannot be read, do not match, or the certificate is not
/// valid today. A program that signs at the end of a long task calls this at the start.
[[nodiscard]] Result<void> check_signing_key(const SigningKey& key);

/// Does the same as check_signing_key(), but checks only the certificate if openssl would prompt for the password.
[[nodiscard]] Result<void> check_signing_key_without_prompt(const SigningKey& key);

/// Decrypted key for several signatures: openssl prompts at most once for its password. The key is only in memory.
class UnlockedKey {
 public:
  /// Fails like check_signing_key().
  [[nodiscard]] static Result<UnlockedKey> make(const SigningKey& key);

  /// Returns the key without a password. Valid while this object exists.
  [[nodiscard]] const SigningKey& key() const { return key_; }

 private:
  UnlockedKey(MemoryFile memory, SigningKey key) : memory_(std::move(memory)), key_(std::move(key)) {}

  MemoryFile memory_;
  SigningKey key_;
};

/// Fails with bad_file if a file of trusted certificates contains no certificate in PEM.
[[nodiscard]] Result<void> check_trusted_file(const std::string& path);

/// Shortest RSA key that signs, in bits. In verification openssl's security level 2 has the same limit, and also
/// refuses weak keys and SHA-1 in the chain (NIST SP 800-131A Rev. 2).
inline constexpr int kFewestRsaBits = 2048;
/// Shortest RSA key without a warning: 128 bits of security (NIST SP 800-57 Part 1 Rev. 5).
inline constexpr int kEnoughRsaBits = 3072;

/// Returns a warning about an RSA key of less than kEnoughRsaBits bits; empty for other keys.
[[nodiscard]] std::string describe_weak_key(const Signer& signer);

/// Returns the identity in the first certificate of a signing key. Fails with bad_file if it cannot be read.
[[nodiscard]] Result<Signer> read_signer_of(const SigningKey& key);

/// Signs a certificate: an enveloped RSA-SHA256 signature over the whole document that includes the key's certificates.
/// Fails with bad_file if key and certificate do not match or cannot be read, if the key has less than kFewestRsaBits
/// bits, if a program is not installed, or if the new signature does not verify.
[[nodiscard]] Result<std::string> sign_dcc(std::string_view dcc, const SigningKey& key);

/// Returns a signed certificate without its signature: the text that was signed. Fails with bad_file unless it has
/// exactly one signature in the form that sign_dcc() writes.
[[nodiscard]] Result<std::string> remove_signature(std::string_view signed_dcc, const std::string& file);

/// Verifies a certificate and returns its signer. Fails with bad_file if it is not signed, was changed in any byte, or
/// its signer is not trusted.
[[nodiscard]] Result<Signer> verify_dcc(std::string_view signed_dcc, const std::string& file, const Trust& trust);

/// Verifies the signature of a certificate of another laboratory and returns its signer. `root` is the certificate,
/// read from the same bytes. The signer must be trusted, on the day of `trust` or today. Fails with bad_file at
/// file:line as find_whole_signature() does, if the signature is not valid, or if the signer is not trusted. If `trust`
/// names no file, any signer is accepted; the signature must still be valid.
[[nodiscard]] Result<Signer> verify_foreign_dcc(std::string_view dcc, const XmlElement& root, const std::string& file,
                                                const Trust& trust);

/// Signs a PDF into another file (adbe.pkcs7.detached, SHA-256). `reason` is ASCII. Fails with bad_file like
/// sign_dcc(), and if the PDF already has a signature.
[[nodiscard]] Result<void> sign_pdf(const std::string& path, const std::string& signed_path, const SigningKey& key,
                                    const std::string& reason);

/// Verifies a PDF and returns its signer. Fails with bad_file unless it has exactly one signature, the signature covers
/// the whole file, the file is unchanged, and the signer is trusted.
[[nodiscard]] Result<Signer> verify_pdf(const std::string& path, const Trust& trust);

/// Returns the time in the signature of a PDF, from the clock of the signer, such as "2026-11-25T14:03:07Z"; nothing if
/// it has none. Does not verify the signature.
[[nodiscard]] Result<std::optional<std::string>> find_signing_time(const std::string& path);

/// Signs the bytes of a file that is neither a certificate nor a PDF. Returns a detached signature as PEM (CMS of RFC
/// 5652, SHA-256) with the key's certificates. Fails like sign_dcc().
[[nodiscard]] Result<std::string> sign_bytes(std::string_view bytes, const SigningKey& key);

/// Verifies a detached signature and returns its signer. Fails with bad_file at `file` if the bytes were changed, the
/// signature is not one, or its signer is not trusted.
[[nodiscard]] Result<Signer> verify_bytes(std::string_view bytes, std::string_view signature, const std::string& file,
                                          const Trust& trust);

}  // namespace gyrotherm::report
