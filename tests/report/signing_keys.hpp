// SPDX-License-Identifier: Apache-2.0
/// Keys and certificates for tests of signatures.
#pragma once

#include <ctime>
#include <string>
#include <vector>

#include "report/signature.hpp"
#include "tests/support/folder.hpp"

namespace gyrotherm::report {

/// Extensions of a certificate that may sign reports.
inline constexpr const char* kForSigning =
    "basicConstraints=critical,CA:FALSE\nkeyUsage=critical,digitalSignature,nonRepudiation\n";

/// Runs a program, which must succeed.
void run(const std::string& program, const std::vector<std::string>& words);

/// Returns a PDF with two pages, and optionally with an empty signature field on the second page.
std::string pdf_of(const std::string& first, const std::string& second, bool has_field = false);

/// Formats a time in UTC as strftime() does.
std::string utc_text(std::time_t at, const char* form);

/// Keys and certificates of an authority and of the signers that it has certified.
class Keys {
 public:
  Keys();
  [[nodiscard]] std::string operator/(const std::string& name) const { return folder_ / name; }
  [[nodiscard]] SigningKey key(const std::string& name) const;
  [[nodiscard]] Trust trust(const std::string& name = "ca") const {
    return {.certificates_file = folder_ / (name + ".pem")};
  }
  /// Issues a certificate with these extensions, signed by the authority "ca".
  void issue_with(const std::string& name, const std::string& extensions);
  /// Issues a certificate for the key "lab" with other times or another digest. Makes the folder and returns the path
  /// of the certificate in it.
  [[nodiscard]] std::string issue_again(const std::string& folder, const std::vector<std::string>& options) const;

 private:
  void write(const std::string& name, const std::string& bytes);
  void authority(const std::string& name);
  void issue(const std::string& name, const std::string& by, const std::vector<std::string>& more,
             const std::string& extensions = kForSigning);

  tests::TestFolder folder_;
};

}  // namespace gyrotherm::report
