// SPDX-License-Identifier: Apache-2.0
/// The calibration report as a Digital Calibration Certificate: XML after PTB's schema DCC 3.3.0, for machines to read,
/// and the certificate read back.
///
/// It has all that the report says but its figures. One measurementResult is one axis, one result is one table of it;
/// what a quantity is, its refType says: of PTB's vocabulary (basic_…) where that has a word, else of ours
/// (gyrotherm_ and the key of the table of words). Texts are in English and German. Nothing in it depends on when it
/// is written: equal reports and options give equal bytes.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.hpp"
#include "report/calibration.hpp"

namespace gyrotherm::report {

inline constexpr const char* kDccFile = "dcc.xml";
inline constexpr const char* kCalibrationFile = "calibration.json";
/// The refType of an identification whose name is a file's and whose value is its SHA-256.
inline constexpr const char* kFileDigestType = "gyrotherm_fileSha256";

/// A file that is issued with the certificate, and by which bytes it is known.
struct IssuedFile {
  std::string name{};  ///< without its folder
  std::string sha256{};
};

/// The report as people read it.
struct ReadableReport {
  std::string name{};   ///< "report.pdf"
  std::string bytes{};  ///< of a PDF
};

/// A PDF of more bytes is not put into the XML: readers of it refuse a text of more than 10 MB, and base64 has four
/// letters for three bytes.
inline constexpr std::size_t kLargestEmbeddedPdf = 7'000'000;

struct DccOptions {
  std::vector<IssuedFile> files{};  ///< calibration.json is named, if it is not here, as to_json() gives it
  std::optional<ReadableReport> pdf{};
};

/// The certificate, not signed. What a draft lacks and the schema asks for is said to be "not given (draft)", its days
/// 0001-01-01; its identifier, its statements and its signer say that it is a draft. Fails with bad_file if a report
/// that is no draft lacks it, or has no results.
[[nodiscard]] Result<std::string> dcc_of(const CalibrationReport& report, const DccOptions& options = {});

/// The contents of a certificate that a verifier needs.
struct ReadDcc {
  std::string identifier{};
  std::vector<IssuedFile> files{};  ///< in their order
};

/// Reads a certificate that this program wrote, without its signature. Fails with bad_file where it is not XML, or
/// differs in a byte from what this program would write of its contents. Comments, other forms of the same contents and
/// document types are therefore refused: a signature over XML covers the contents and not the bytes.
[[nodiscard]] Result<ReadDcc> read_dcc(std::string_view dcc, const std::string& file);

}  // namespace gyrotherm::report
