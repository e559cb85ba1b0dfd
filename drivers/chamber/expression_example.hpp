// SPDX-License-Identifier: Apache-2.0
/// Example texts of the pattern of an identity, for virtual instruments.
#pragma once

#include <optional>
#include <string>

#include "drivers/chamber/register_map.hpp"

namespace gyrotherm::drivers {

/// Returns whether a text fits the pattern of a fingerprint.
[[nodiscard]] bool fits(const Fingerprint& print, const std::string& text);

/// Returns a short text that fits the pattern of a fingerprint. Returns nothing if none was found, which happens only
/// for regular expressions.
[[nodiscard]] std::optional<std::string> make_example(const Fingerprint& print);

}  // namespace gyrotherm::drivers
