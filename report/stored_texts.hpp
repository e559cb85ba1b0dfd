// SPDX-License-Identifier: Apache-2.0
/// Texts that records and reports store in English, in the language of a view.
#pragma once

#include <string>
#include <vector>

#include "report/plot/language.hpp"

namespace gyrotherm::report {

/// Returns the description of an instrument, such as "dcon 2 at serial:/dev/ttyUSB0, module 01, input 3", "gyro at
/// virtual" or "imported from table.csv". Names and addresses stay as they are.
[[nodiscard]] std::string translate_instrument(plot::Language language, const std::string& stored);

/// Returns the name of a thermometer in a figure: "self", the temperature that the unit reports, is "eigene".
[[nodiscard]] std::string translate_thermometer(plot::Language language, const std::string& stored);

/// Returns the description of an event of a record: "suspended: the air …". A fixed text of the program is translated,
/// except for its names, numbers and words of persons; any other text is the wording of the record. `kind` is the kind
/// of the deviation.
[[nodiscard]] std::string translate_event(plot::Language language, const std::string& kind, const std::string& stored);

/// Returns the missing items of a draft, joined by "; ". Names of files, keys and persons stay as they are.
[[nodiscard]] std::string translate_missing(plot::Language language, const std::vector<std::string>& stored);

}  // namespace gyrotherm::report
