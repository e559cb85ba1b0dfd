// SPDX-License-Identifier: Apache-2.0
/// Logs of PX4: ULog, version 1 (docs.px4.io, "ULog File Format"). A file describes its own messages: formats (F), the
/// series of messages that are logged (A) and their data (D), each message behind its size and kind.
#pragma once

#include <vector>

#include "acquisition/exchange/bytes.hpp"
#include "acquisition/exchange/foreign_row.hpp"
#include "acquisition/exchange/import_map.hpp"
#include "acquisition/exchange/log_reading.hpp"
#include "core/result.hpp"

namespace gyrotherm::exchange {

/// Hands on a row for each message that has a wanted column; what other messages have is NaN in it. Time is the
/// message's `timestamp`. A log that ends within a message, drop-outs, and messages of an unknown kind are notes. Fails
/// with bad_file if the file is no such log or an incompatible one, lacks a column (its columns are named), or where
/// columns come from several messages and the map does not put rows together; and as `take` does.
[[nodiscard]] Result<Notes> read_ulog(Bytes bytes, const ImportMap& map, const TakeRow& take);

/// Every column of a log of which a message came, in order of its series.
[[nodiscard]] Result<std::vector<LogColumn>> columns_of_ulog(Bytes bytes);

/// Whether a file that begins so is one.
[[nodiscard]] bool is_ulog(std::string_view beginning);

}  // namespace gyrotherm::exchange
