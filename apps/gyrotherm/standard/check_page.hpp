// SPDX-License-Identifier: Apache-2.0
/// The check runs of a rig as a page, in English and German.
#pragma once

#include <string>

#include "report/standard/check_view.hpp"
#include "report/words.hpp"

namespace gyrotherm::app {

/// Returns a page with the standing, the charts, all runs and all explanations.
[[nodiscard]] std::string to_html(const standard::CheckedStandard& standard, report::Language language);

}  // namespace gyrotherm::app
