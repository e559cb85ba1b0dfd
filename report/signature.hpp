// SPDX-License-Identifier: Apache-2.0
/// Signatures of a laboratory over a certificate (XML, by xmlsec1) and over a PDF (by pdfsig), and whether they hold.
/// What the key is and whose, is judged by openssl in both. None of these functions uses the network.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "core/result.hpp"

namespace gyrotherm::report {

/// What a laboratory signs with: RSA, in PEM.
struct SigningKey {
  std::string key_file{};
  std::string certificate_file{};  ///< its own first, then those between it and its authority
  std::string password_file{};     ///< whose first line the key is locked with; empty: it is not, or openssl asks
};

/// Whom the verifier trusts.
struct Trust {
  std::string certificates_file{};      ///< PEM: of authorities, or of the laboratory itself
  std::optional<std::string> on_day{};  ///< "2026-11-25": on which certificates must be valid; nothing: today
};

/// Who signed, by the certificate of the key.
struct Signer {
  std::string subject{}, issuer{};  ///< as RFC 2253 writes names
  std::string serial_number{};      ///< hexadecimal
  std::string fingerprint{};        ///< SHA-256 of the certificate
  std::string not_after{};          ///< last moment of the certificate, as openssl writes it
  bool operator==(const Signer&) const = default;
};

/// The signed certificate: enveloped RSA-SHA256 over the whole document, with the key's certificates inside. Fails with
/// bad_file if key and certificate do not belong together or cannot be read, if a program is not installed, or if the
/// signature does not hold when it is looked at afterwards.
[[nodiscard]] Result<std::string> sign_dcc(std::string_view dcc, const SigningKey& key);

/// A signed certificate without its signature: the text that was signed. Fails with bad_file if it has none, more than
/// one, or one of another form than sign_dcc() gives it.
[[nodiscard]] Result<std::string> without_signature(std::string_view signed_dcc, const std::string& file);

/// Who signed a certificate. Fails with bad_file if it is not signed, was changed in any byte, or is signed by nobody
/// who is trusted.
[[nodiscard]] Result<Signer> verify_dcc(std::string_view signed_dcc, const std::string& file, const Trust& trust);

/// Signs a PDF into another file (adbe.pkcs7.detached, SHA-256). `reason` is ASCII. Fails with bad_file as sign_dcc(),
/// and if the PDF is signed already.
[[nodiscard]] Result<void> sign_pdf(const std::string& path, const std::string& signed_path, const SigningKey& key,
                                    const std::string& reason);

/// Who signed a PDF. Fails with bad_file if it is not signed exactly once, over all of it, by somebody who is trusted,
/// or was changed.
[[nodiscard]] Result<Signer> verify_pdf(const std::string& path, const Trust& trust);

}  // namespace gyrotherm::report
