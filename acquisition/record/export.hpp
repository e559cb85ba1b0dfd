// SPDX-License-Identifier: Apache-2.0
/// Our records out.
#pragma once

#include <string>

#include "acquisition/record/record.hpp"
#include "core/result.hpp"

namespace gyrotherm::record {

/// The record as text: comment lines with `#` that say what it is ("SIMULATED" first, if it is), a header of names with
/// units, one row per sample; an empty field where there is no value. Quoted as in RFC 4180, lines end with LF; numbers
/// are the shortest that read back to the same value.
[[nodiscard]] std::string to_csv(const Record& record);

/// Writes it; the file appears as a whole. Fails like read_record, or with storage.
[[nodiscard]] Result<void> export_record(const std::string& record_path, const std::string& csv_path);

}  // namespace gyrotherm::record
