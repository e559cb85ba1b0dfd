// SPDX-License-Identifier: Apache-2.0
/// Permitted uses of a certificate: whether its extensions permit it to sign reports.
#pragma once

#include <string>
#include <string_view>

namespace gyrotherm::report {

/// Returns why a certificate with these extensions must not sign a report; empty if it may. `extensions` is openssl's
/// output for basicConstraints, keyUsage and extendedKeyUsage. A signer must not be an authority (RFC 5280, 4.2.1.9),
/// its key usage must contain digitalSignature or nonRepudiation (4.2.1.3), and its extended key usage, if present,
/// must contain documentSigning (RFC 9336), emailProtection, or document signing after Adobe or Microsoft (4.2.1.12).
[[nodiscard]] std::string find_usage_refusal(std::string_view extensions);

}  // namespace gyrotherm::report
