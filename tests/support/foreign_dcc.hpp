// SPDX-License-Identifier: Apache-2.0
/// Certificates of an invented laboratory, and their signatures.
#pragma once

#include <string>

#include "tests/support/folder.hpp"

namespace gyrotherm::report {

/// Returns an unsigned certificate of five temperatures, in PTB's form for thermometers. Its item has the serial number
/// T-0417. Each correction is 0.01 K more than the previous one, from −0.02 K at −40 °C to 0.02 K at 60 °C; U = 0.02 K.
[[nodiscard]] std::string foreign_dcc();

/// Replaces a text that occurs exactly once.
[[nodiscard]] std::string with_replaced(std::string text, const std::string& what, const std::string& with);

/// Keys of two authorities and their laboratories. Signs certificates with xmlsec1.
class ForeignKeys {
 public:
  ForeignKeys();
  /// Path of "authority.pem", "other-authority.pem", "laboratory.pem" or another file.
  [[nodiscard]] std::string operator/(const std::string& name) const { return folder_ / name; }
  /// Makes a key and its certificate, signed by an authority. `algorithm` is openssl's: "rsa:2048", "ec".
  void issue(const std::string& name, const std::string& authority, const std::string& algorithm,
             const std::string& days);
  /// Returns the certificate with an enveloped signature. `certificates` are base64 and precede the signer's own.
  [[nodiscard]] std::string sign(const std::string& dcc, const std::string& name = "laboratory",
                                 const std::string& method = "rsa-sha256") const;
  /// Returns the text of a PEM certificate in base64.
  [[nodiscard]] std::string certificate(const std::string& name) const;
  /// Signs a document that contains an empty signature template.
  [[nodiscard]] std::string sign_template(const std::string& document, const std::string& name) const;

 private:
  tests::TestFolder folder_;
};

/// Returns the empty signature for sign_template().
[[nodiscard]] std::string signature_template(const std::string& method, const std::string& certificate);

}  // namespace gyrotherm::report
