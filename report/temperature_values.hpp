// SPDX-License-Identifier: Apache-2.0
/// Reads temperatures and their uncertainties in the notation of the Digital System of Units (D-SI 1 and 2): si:real,
/// si:realListXMLList, si:list and si:hybrid.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.hpp"
#include "report/xml_reader.hpp"

namespace gyrotherm::report {

struct ExpandedUncertainty {
  double expanded{};  ///< U, K
  double coverage_factor{};
};

struct TemperatureValue {
  double value{};  ///< °C; a difference: K
  std::optional<ExpandedUncertainty> uncertainty{};
};

struct TemperatureValues {
  std::vector<TemperatureValue> values{};
  /// The unit, if it is not a unit of temperature; `values` is then empty.
  std::string other_unit{};
};

/// Checks an expanded uncertainty in kelvins. Returns the reason for a refusal; empty if there is none. The coverage
/// factor must be 1 or more. If a probability is stated, it must match the coverage factor to 0.01: exactly for the
/// distributions "normal" and "uniform", otherwise as anything between a normal distribution and Student's with one
/// degree of freedom.
[[nodiscard]] std::string uncertainty_refusal(double expanded, double coverage_factor,
                                              std::optional<double> probability, std::string_view distribution);

/// Splits the text of an XML list at blanks.
[[nodiscard]] std::vector<std::string_view> split_xml_list(std::string_view text);

/// Reads the values of dcc:quantity: kelvins or degrees Celsius, also in thousandths and millionths. In a hybrid, all
/// units of temperature must give the same values to 0.06 K. An uncertainty, coverage factor or unit that is stated
/// once applies to all values of its list. Fails with bad_file at file:line if a number is missing or impossible, if
/// the lists have different lengths, or as uncertainty_refusal() does.
[[nodiscard]] Result<TemperatureValues> read_temperatures(const XmlElement& quantity, const std::string& file,
                                                          bool are_differences);

}  // namespace gyrotherm::report
