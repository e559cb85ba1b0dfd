// SPDX-License-Identifier: Apache-2.0
/// Reads logs of PX4 in the format ULog, version 1 (docs.px4.io, "ULog File Format"). A file describes its own
/// messages: formats (F), the series of logged messages (A) and their data (D). Each message is preceded by its size
/// and kind.
#pragma once

#include <vector>

#include "acquisition/exchange/bytes.hpp"
#include "acquisition/exchange/foreign_row.hpp"
#include "acquisition/exchange/import_map.hpp"
#include "acquisition/exchange/log_reading.hpp"
#include "core/result.hpp"

namespace gyrotherm::exchange {

/// Passes on a row for each message with a column of the map; columns of other messages are NaN. The time is
/// `timestamp` of the message. Notes report a log that ends within a message, drop-outs, damaged messages and skipped
/// bytes, and messages of an unknown kind. Fails with bad_file if the file is not a ULog file, is incompatible, or
/// lacks a column of the map (the fault lists the existing columns). Also fails with bad_file if the columns come from
/// several messages and the map does not combine rows. Fails as `take` does.
[[nodiscard]] Result<Notes> read_ulog(Bytes bytes, const ImportMap& map, const TakeRow& take);

/// Returns every column of a log with at least one message, in order of its series.
[[nodiscard]] Result<std::vector<LogColumn>> read_ulog_columns(Bytes bytes);

/// Returns whether a file with this beginning is a ULog file.
[[nodiscard]] bool is_ulog(std::string_view beginning);

}  // namespace gyrotherm::exchange
