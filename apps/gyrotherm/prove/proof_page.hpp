// SPDX-License-Identifier: Apache-2.0
/// The protocol of proof tests as a printable page, in English and in German, and its signature.
#pragma once

#include <string>

#include "core/result.hpp"
#include "report/signature.hpp"
#include "report/words.hpp"
#include "sequencer/prove/proof.hpp"

namespace gyrotherm::app {

/// Returns the page. `signer` is the subject of the signature; empty: the page says that the protocol is unsigned.
[[nodiscard]] std::string proof_page(const prove::Proof& proof, const std::string& sha256, const std::string& signer,
                                     report::Language language);

/// Writes proof.json and its pages into a folder that exists. Fails with storage.
[[nodiscard]] Result<void> write_proof(const std::string& folder, const prove::Proof& proof);

/// Returns whether a folder contains a protocol of proof tests and no calibration report.
[[nodiscard]] bool is_proof_folder(const std::string& folder);
/// Signs the protocol of a folder and renders its pages again. Fails with usage if it is signed already, with bad_file
/// if a page was changed, and like report::sign_bytes().
[[nodiscard]] Result<void> sign_proof(const std::string& folder, const report::SigningKey& key);
/// Verifies the signature of a protocol, and that its pages are those of the protocol. Returns the signer. Fails with
/// bad_file.
[[nodiscard]] Result<report::Signer> verify_proof(const std::string& folder, const report::Trust& trust);

}  // namespace gyrotherm::app
