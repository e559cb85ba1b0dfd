// SPDX-License-Identifier: Apache-2.0
/// Folders with a protocol: a JSON file as the only source, a page of it in each language, and a detached signature
/// over the JSON file.
#pragma once

#include <string>

#include "apps/console/command.hpp"
#include "core/result.hpp"
#include "report/signature.hpp"
#include "report/signed_report.hpp"
#include "report/words.hpp"

namespace gyrotherm::app {

/// A protocol as text, and what identifies it on its page.
struct ProtocolText {
  std::string json;
  std::string sha256;  ///< digest of `json`
  std::string signer;  ///< subject of the signer's certificate; empty: the protocol is unsigned
};

/// A kind of protocol: its files and its page.
struct ProtocolKind {
  const char* stem;  ///< "proof": proof.json, proof.en.html, proof.de.html and proof.p7s
  /// Renders the page. Fails with bad_file at `file` if the text is not a protocol of this kind.
  Result<std::string> (*page)(const ProtocolText& protocol, const std::string& file, report::Language language);
};

/// Writes the JSON file and its pages into a folder that exists. Fails with storage.
[[nodiscard]] Result<void> write_protocol(const std::string& folder, const ProtocolKind& kind, const std::string& json);

/// Adds the options --key, --certificate and --password-file to a command that can sign its protocol.
void add_signing_options(CLI::App& command, report::SigningKey& key);
/// Fails with usage if only one of --key and --certificate was given.
[[nodiscard]] Result<void> check_signing_options(const report::SigningKey& key);

/// Returns whether a folder contains a protocol of this kind and no file of a calibration report: a report from which
/// calibration.json was removed is not a protocol.
[[nodiscard]] bool has_protocol(const std::string& folder, const ProtocolKind& kind);

/// Signs the protocol of a folder and renders its pages again. Fails with usage if it is signed already, with bad_file
/// if a page is not the one that this program renders, and like report::sign_bytes().
[[nodiscard]] Result<void> sign_protocol(const std::string& folder, const ProtocolKind& kind,
                                         const report::SigningKey& key);

/// Verifies the signature of a protocol. Returns its signer and a check of each file; the pages and other files are not
/// signed, so their checks never fail. Fails with bad_file if the protocol is not signed by a trusted signer.
[[nodiscard]] Result<report::VerifiedReport> verify_protocol(const std::string& folder, const ProtocolKind& kind,
                                                             const report::Trust& trust);

}  // namespace gyrotherm::app
