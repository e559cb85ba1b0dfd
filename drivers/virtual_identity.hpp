// SPDX-License-Identifier: Apache-2.0
/// The marks by which the virtual instruments of `gyrotherm simulate` identify themselves. A run that finds one is
/// marked as SIMULATED, because nothing else distinguishes it from a run on real instruments.
#pragma once

#include <string>
#include <string_view>

namespace gyrotherm::drivers {

/// The serial number of virtual instruments.
inline constexpr std::string_view kVirtualSerialNumber = "VIRTUAL1";
/// Mark for fields that are too short for the serial number: the name of a DCON module has at most six characters.
inline constexpr std::string_view kShortVirtualName = "VIRTU1";
/// The serial number of virtual instruments whose serial number is an integer: "VIRT" in ASCII.
inline constexpr int kVirtualSerialInteger = 0x56495254;

/// Returns whether an identity, as Identified::identify() returns it, is that of a virtual instrument: it contains one
/// of the serial numbers above as a separate token, or it is that of a virtual chamber whose map this project ships.
/// Letters, digits, '-', '_' and '.' continue a token, so "VIRTUAL10" and "NON-VIRTUAL1" do not match.
[[nodiscard]] bool is_virtual_identity(std::string_view identity);

/// Returns the identity with the serial number of virtual instruments appended, unless it already is that of a virtual
/// instrument.
[[nodiscard]] std::string add_virtual_mark(const std::string& identity);

}  // namespace gyrotherm::drivers
