// SPDX-License-Identifier: Apache-2.0
/// The comparison of two calibrations as a text for people.
#pragma once

#include "report/comparison.hpp"
#include "report/document.hpp"

namespace gyrotherm::report {

/// First how many results have changed by more than both calibrations are uncertain, then all of them, greatest |E_n|
/// first.
[[nodiscard]] Document document_of(const Comparison& comparison, Language language);

}  // namespace gyrotherm::report
