// SPDX-License-Identifier: Apache-2.0
/// Register map with only the two registers that every chamber needs. A test appends what it is about.
#pragma once

namespace gyrotherm::drivers {

inline constexpr char kTwoRegisters[] = R"(schema = "gyrotherm-chamber/1"
name = "n"
vendor = "v"
source = "s"
[[register]]
name = "air_temperature"
address = 10
type = "s16"
[[register]]
name = "set_point"
address = 300
type = "s16"
access = "rw"
)";

}  // namespace gyrotherm::drivers
