// SPDX-License-Identifier: Apache-2.0
/// Reads the calibration of a thermometer from a digital calibration certificate of any laboratory (PTB's DCC 3.0 to
/// 3.3), after verifying its signature.
///
/// The correction of a thermometer in a record is one number, the offset. It is the mean of the corrections at the
/// calibrated temperatures. Its standard uncertainty is √(u² + s²): u is the largest standard uncertainty U/k of the
/// points, and s² is the mean square of their deviations from the mean (GUM, JCGM 100:2008, F.2.4.5).
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.hpp"
#include "report/signature.hpp"
#include "report/xml_reader.hpp"

namespace gyrotherm::report {

/// XML readers reject texts of more than 10 MB.
inline constexpr std::size_t kLargestForeignDcc = 10'000'000;

/// The correction of a thermometer at one temperature.
struct CalibrationPoint {
  double at_c{};          ///< indicated, otherwise reference or nominal temperature
  double correction_k{};  ///< reference temperature − indicated temperature
  double expanded_k{};    ///< U
  double coverage_factor{};
  [[nodiscard]] double standard_uncertainty_k() const { return expanded_k / coverage_factor; }
};

struct TemperatureCertificate {
  std::string number{};
  /// Name of the calibration laboratory.
  std::string issuer{};
  /// Days such as "2026-11-25": end of the calibration, issue and recalibration. The last two may be empty.
  std::string calibrated{}, issued{}, due{};
  std::vector<CalibrationPoint> points{};  ///< at least one

  [[nodiscard]] double offset_k() const;
  [[nodiscard]] double standard_uncertainty_k() const;
  /// Returns the point with the largest standard uncertainty.
  [[nodiscard]] const CalibrationPoint& most_uncertain() const;
  [[nodiscard]] double lowest_c() const;
  [[nodiscard]] double highest_c() const;
};

/// Reads a DCC as XML. Fails with bad_file at file:line as read_xml() does, or if it is not a DCC of version 3.0
/// to 3.3.
[[nodiscard]] Result<XmlElement> read_foreign_dcc(std::string_view dcc, const std::string& file);

/// Returns the day of issue, otherwise the last day of the calibration; nothing if neither is a day.
[[nodiscard]] std::optional<std::string> find_issue_day(const XmlElement& dcc);

/// Reads the calibration of the item with this serial number, or of the only item if `serial_number` is empty. Fails
/// with bad_file at file:line if a value is missing, contradictory or impossible, or is not a temperature, or if it is
/// unknown to which item the values belong. Does not verify the signature.
[[nodiscard]] Result<TemperatureCertificate> read_temperature_certificate(const XmlElement& dcc,
                                                                          const std::string& file,
                                                                          const std::string& serial_number);

struct VerifiedCertificate {
  TemperatureCertificate certificate{};
  Signer signer{};
  std::string sha256{};  ///< digest of the file
};

/// Reads a certificate from its bytes and verifies its signature. The signer must be trusted on the day of issue (or
/// the last day of the calibration) or today, unless `trust` states a day. Fails like read_foreign_dcc(),
/// verify_foreign_dcc() and read_temperature_certificate(), in this order.
[[nodiscard]] Result<VerifiedCertificate> verify_temperature_certificate(std::string_view dcc, const std::string& file,
                                                                         const std::string& serial_number,
                                                                         const Trust& trust);

}  // namespace gyrotherm::report
