// SPDX-License-Identifier: Apache-2.0
/// Checks which parts of a document an XML signature covers, before a program verifies the signature itself.
#pragma once

#include <string>
#include <vector>

#include "core/result.hpp"
#include "report/xml_reader.hpp"

namespace gyrotherm::report {

struct XmlSignature {
  std::int64_t line{};
  /// Base64 without blanks, in the order of the document; at least one.
  std::vector<std::string> certificates{};
};

/// Returns the signature of a document. Fails with bad_file at file:line unless the document has exactly one signature,
/// as a child of its root, that covers the whole document: one reference is empty and has only the transforms of an
/// enveloped signature and of the canonical form. Every other reference must be to the signed properties of XAdES.
/// Digests and signature must use SHA-256, SHA-384 or SHA-512, and RSA or ECDSA.
[[nodiscard]] Result<XmlSignature> find_whole_signature(const XmlElement& root, const std::string& file);

}  // namespace gyrotherm::report
