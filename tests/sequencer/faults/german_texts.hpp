// SPDX-License-Identifier: Apache-2.0
/// German texts of the events of a record, for tests.
#pragma once

#include <string>

#include "core/sample.hpp"

namespace gyrotherm::faults {

/// Returns the German text of an event in a report, with the English text, if the event is a deviation and its text is
/// not German as a whole. Otherwise returns an empty text.
[[nodiscard]] std::string find_untranslated(const Event& event);

}  // namespace gyrotherm::faults
