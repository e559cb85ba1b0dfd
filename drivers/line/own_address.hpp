/// Addresses by which this machine speaks to itself.
#pragma once

#include <string>

namespace gyrotherm {

/// Whether a numeric IPv4 address leads to this machine: the loopback net, 0.0.0.0, or one of its own interfaces.
[[nodiscard]] bool is_own_address(const std::string& host);

}  // namespace gyrotherm
