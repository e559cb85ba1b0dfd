// SPDX-License-Identifier: Apache-2.0
/// Registers and bytes of the exchanges that the driver tests compare.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace gyrotherm::drivers {

using Words = std::vector<std::uint16_t>;
using Bytes = std::vector<std::byte>;

}  // namespace gyrotherm::drivers
