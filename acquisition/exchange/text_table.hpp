// SPDX-License-Identifier: Apache-2.0
/// The rows of a foreign text table, as its map says.
#pragma once

#include "acquisition/exchange/bytes.hpp"
#include "acquisition/exchange/foreign_row.hpp"
#include "acquisition/exchange/import_map.hpp"
#include "core/result.hpp"

namespace gyrotherm::exchange {

/// Hands on every row. Lines may end with LF or CRLF and be in UTF-8 or, with a byte order mark, in UTF-16; empty lines
/// do not count, nor does a first line "sep=;" as spreadsheets write it. A header that is no UTF-8 is taken for
/// Latin-1. Empty fields at the end of a row, beyond those of the header, do not count. Fails with bad_file at the
/// first mistake, as `file:line:column: what, what was expected`; also if there is no row, where a line has more than
/// record::kLongestLine bytes or record::kMostFields fields, and as `take` does. Where the map leaves out damaged
/// lines, those that cannot be read are counted instead, unless they are more than the rows. A last line without an end
/// is told, and left out where its last number has fewer decimals than those before.
[[nodiscard]] Result<Findings> read_text_table(Bytes bytes, const ImportMap& map, const TakeRow& take);

}  // namespace gyrotherm::exchange
