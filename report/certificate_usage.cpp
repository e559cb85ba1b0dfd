// SPDX-License-Identifier: Apache-2.0
#include "report/certificate_usage.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>
#include <vector>

#include "core/text.hpp"

namespace gyrotherm::report {
namespace {

constexpr std::array<std::string_view, 2> kSigningUsages{"Digital Signature", "Non Repudiation"};
/// Usages as openssl prints them. openssl has a name for emailProtection; later versions also have names for
/// documentSigning and for Microsoft's usage.
constexpr std::array<std::string_view, 6> kDocumentUsages{"E-mail Protection",       "1.3.6.1.5.5.7.3.36",
                                                          "Document Signing",        "1.2.840.113583.1.1.5",
                                                          "1.3.6.1.4.1.311.10.3.12", "Microsoft Document Signing"};

/// Returns the values of an extension from the line below its name; nothing if it is missing.
std::optional<std::vector<std::string>> extension_values(std::string_view extensions, std::string_view name) {
  const auto begins = extensions.find(name);
  if (begins == std::string_view::npos) return std::nullopt;
  const auto line = extensions.find('\n', begins);
  std::string_view left = line == std::string_view::npos ? "" : extensions.substr(line + 1);
  left = left.substr(0, left.find('\n'));
  std::vector<std::string> values;
  while (!left.empty()) {
    const auto comma = std::min(left.find(','), left.size());
    values.emplace_back(trimmed(left.substr(0, comma), " \t\r"));
    left.remove_prefix(std::min(comma + 1, left.size()));
  }
  return values;
}

bool intersects(const std::vector<std::string>& usages, const auto& permitted) {
  return std::ranges::any_of(usages, [&](const std::string& one) {
    return std::ranges::find(permitted, std::string_view(one)) != permitted.end();
  });
}

}  // namespace

std::string find_usage_refusal(std::string_view extensions) {
  const auto constraints = extension_values(extensions, "X509v3 Basic Constraints:");
  if (constraints && std::ranges::find(*constraints, "CA:TRUE") != constraints->end())
    return "belongs to a certificate authority and cannot sign reports";
  const auto usage = extension_values(extensions, "X509v3 Key Usage:");
  if (!usage || !intersects(*usage, kSigningUsages))
    return fmt::format(
        "is not a certificate for signing: its key usage is {}, expected digitalSignature or nonRepudiation",
        usage ? plain(fmt::format("{}", fmt::join(*usage, ", "))) : "missing");
  const auto extended = extension_values(extensions, "X509v3 Extended Key Usage:");
  if (extended && !intersects(*extended, kDocumentUsages))
    return fmt::format(
        "is not a certificate for signing documents: its extended key usage is {}, expected emailProtection or "
        "documentSigning",
        plain(fmt::format("{}", fmt::join(*extended, ", "))));
  return {};
}

}  // namespace gyrotherm::report
