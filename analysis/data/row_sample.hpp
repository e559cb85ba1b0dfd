// SPDX-License-Identifier: Apache-2.0
/// Recognition of the same readings in two records, even if their files, times or thermometers differ.
#pragma once

#include <cstdint>
#include <vector>

#include "analysis/data/dataset.hpp"

namespace gyrotherm::data {

/// Computes a hash of every 16 consecutive rates from `from_s` to `to_s` and returns the 256 smallest hashes in order.
/// A hash does not depend on the time or on the removed Earth rate. Rates that change in fewer than half of the rows
/// are skipped, because equal sequences of them occur by chance. A part of a record with a twentieth of its rows has
/// about a twentieth of the hashes, wherever it begins.
[[nodiscard]] std::vector<std::int64_t> sample_rows(const Dataset& dataset, double from_s, double to_s);

/// Returns whether the dataset has rows of the record from which `sample` was taken: at least three of its hashes occur
/// from `from_s` to `to_s`.
[[nodiscard]] bool has_rows_of(const Dataset& dataset, const std::vector<std::int64_t>& sample, double from_s,
                               double to_s);

}  // namespace gyrotherm::data
