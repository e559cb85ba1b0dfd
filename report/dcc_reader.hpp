// SPDX-License-Identifier: Apache-2.0
/// A Digital Calibration Certificate read back: what it says of the files that it belongs to, and whether it has the
/// form in which this program writes it.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/result.hpp"
#include "report/dcc.hpp"

namespace gyrotherm::report {

/// What of a certificate a verifier needs.
struct ReadDcc {
  std::string identifier{};
  std::vector<IssuedFile> files{};  ///< in their order
};

/// Reads a certificate that this program wrote, without its signature. Fails with bad_file where it is no XML, or not
/// byte for byte what would be written of what it says: a comment, another way of saying the same, or a document type
/// are refused, for a signature over XML is over what is said and not over the bytes.
[[nodiscard]] Result<ReadDcc> read_dcc(std::string_view dcc, const std::string& file);

}  // namespace gyrotherm::report
