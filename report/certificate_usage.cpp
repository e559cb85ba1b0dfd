// SPDX-License-Identifier: Apache-2.0
#include "report/certificate_usage.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>

#include "core/text.hpp"
#include "report/other_program.hpp"

namespace gyrotherm::report {
namespace {

using Usages = std::vector<std::string>;

constexpr std::array<std::string_view, 2> kSigningUsages{"Digital Signature", "Non Repudiation"};
/// Names as openssl prints them: it knows emailProtection, later versions documentSigning and Microsoft's too.
constexpr std::array<std::string_view, 6> kDocumentUsages{"E-mail Protection",       "1.3.6.1.5.5.7.3.36",
                                                          "Document Signing",        "1.2.840.113583.1.1.5",
                                                          "1.3.6.1.4.1.311.10.3.12", "Microsoft Document Signing"};

/// Returns the values of an extension, which openssl prints on the line below its name; nothing if it is missing.
std::optional<Usages> values_of(std::string_view extensions, std::string_view name) {
  const auto begins = extensions.find(name);
  if (begins == std::string_view::npos) return std::nullopt;
  const auto line = extensions.find('\n', begins);
  std::string_view left = line == std::string_view::npos ? "" : extensions.substr(line + 1);
  left = left.substr(0, left.find('\n'));
  Usages values;
  while (!left.empty()) {
    const auto comma = std::min(left.find(','), left.size());
    values.emplace_back(trimmed(left.substr(0, comma), " \t\r"));
    left.remove_prefix(std::min(comma + 1, left.size()));
  }
  return values;
}

bool has_any(const Usages& usages, const auto& permitted) {
  return std::ranges::any_of(usages, [&](const std::string& one) {
    return std::ranges::find(permitted, std::string_view(one)) != permitted.end();
  });
}

}  // namespace

std::string usage_refusal(std::string_view extensions) {
  const auto constraints = values_of(extensions, "X509v3 Basic Constraints:");
  if (constraints && std::ranges::find(*constraints, "CA:TRUE") != constraints->end())
    return "is the certificate of an authority, which issues certificates and signs no reports";
  const auto usage = values_of(extensions, "X509v3 Key Usage:");
  if (!usage || !has_any(*usage, kSigningUsages))
    return fmt::format(
        "is no certificate for signing: its key usage is {}, expected digitalSignature or nonRepudiation",
        usage ? plain(fmt::format("{}", fmt::join(*usage, ", "))) : "missing");
  const auto extended = values_of(extensions, "X509v3 Extended Key Usage:");
  if (extended && !has_any(*extended, kDocumentUsages))
    return fmt::format(
        "is no certificate for documents: its extended key usage is {}, expected emailProtection or documentSigning",
        plain(fmt::format("{}", fmt::join(*extended, ", "))));
  return {};
}

Result<void> check_usage(const std::string& certificate, const std::string& where) {
  const auto run = run_program(
      "openssl", {"x509", "-in", certificate, "-noout", "-ext", "basicConstraints,keyUsage,extendedKeyUsage"});
  if (!run) return failure(run.error());
  if (run->exit_code != 0) return failure(FaultKind::bad_file, where, "openssl does not read the signer's certificate");
  const std::string refusal = usage_refusal(run->out);
  return refusal.empty() ? Result<void>{} : failure(FaultKind::bad_file, where, "the signer's certificate " + refusal);
}

}  // namespace gyrotherm::report
