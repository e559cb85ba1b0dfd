// SPDX-License-Identifier: Apache-2.0
/// The purposes that the certificate of a signer permits.
#pragma once

#include <string>
#include <string_view>

#include "core/result.hpp"

namespace gyrotherm::report {

/// Returns why a certificate with these extensions may not sign a report; empty if it may. `extensions` is what openssl
/// prints of basicConstraints, keyUsage and extendedKeyUsage. A signer is not an authority (RFC 5280, 4.2.1.9), its
/// key usage names digitalSignature or nonRepudiation (4.2.1.3), and its extended key usage, where it has one, names
/// documentSigning (RFC 9336), emailProtection, or the signing of documents after Adobe or Microsoft (4.2.1.12).
[[nodiscard]] std::string usage_refusal(std::string_view extensions);

/// Checks the first certificate of a PEM file by usage_refusal(). Fails with bad_file at `where` if it may not sign a
/// report, or if openssl is not installed or does not read the certificate.
[[nodiscard]] Result<void> check_usage(const std::string& certificate, const std::string& where);

}  // namespace gyrotherm::report
