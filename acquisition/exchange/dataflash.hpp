// SPDX-License-Identifier: Apache-2.0
/// Reads logs of ArduPilot in the format DataFlash (ardupilot.org, "Adding a new Log Message"; AP_Logger). Each message
/// begins with A3 95 and its kind. FMT messages define the length, the fields and the format of each kind. FMTU
/// messages define its units.
#pragma once

#include <string_view>
#include <vector>

#include "acquisition/exchange/bytes.hpp"
#include "acquisition/exchange/foreign_row.hpp"
#include "acquisition/exchange/import_map.hpp"
#include "acquisition/exchange/log_reading.hpp"
#include "core/result.hpp"

namespace gyrotherm::exchange {

/// Passes on a row for each message with a column of the map; columns of other messages are NaN. The time is TimeUS (or
/// TimeMS) of the message. If the units of a kind mark a field as the sensor number, each sensor has its own series.
/// Messages of the kind that precede its units are left out, with a note. Skips bytes that belong to no message, with a
/// note. Fails with bad_file as read_ulog() does.
[[nodiscard]] Result<Notes> read_dataflash(Bytes bytes, const ImportMap& map, const TakeRow& take);

/// Returns every column of a log, in order of its series.
[[nodiscard]] Result<std::vector<LogColumn>> read_dataflash_columns(Bytes bytes);

/// Returns whether a file with this beginning is a DataFlash log.
[[nodiscard]] bool is_dataflash(std::string_view beginning);

}  // namespace gyrotherm::exchange
