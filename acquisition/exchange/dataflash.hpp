// SPDX-License-Identifier: Apache-2.0
/// Logs of ArduPilot: DataFlash (ardupilot.org, "Adding a new Log Message"; AP_Logger). Each message begins with A3 95
/// and its kind; messages FMT tell the length, fields and format of each kind, messages FMTU their units.
#pragma once

#include <string_view>
#include <vector>

#include "acquisition/exchange/bytes.hpp"
#include "acquisition/exchange/foreign_row.hpp"
#include "acquisition/exchange/import_map.hpp"
#include "acquisition/exchange/log_reading.hpp"
#include "core/result.hpp"

namespace gyrotherm::exchange {

/// Hands on a row for each message that has a wanted column; what other messages have is NaN in it. Time is the
/// message's TimeUS (or TimeMS); of a kind whose units mark a field as the number of the sensor there is a series for
/// each sensor, and what comes before those units is left out, and a note. Bytes that belong to no message are passed
/// over, and a note. Fails with bad_file as read_ulog() does.
[[nodiscard]] Result<Notes> read_dataflash(Bytes bytes, const ImportMap& map, const TakeRow& take);

/// Every column of a log, in order of its series.
[[nodiscard]] Result<std::vector<LogColumn>> columns_of_dataflash(Bytes bytes);

/// Whether a file that begins so is one.
[[nodiscard]] bool is_dataflash(std::string_view beginning);

}  // namespace gyrotherm::exchange
