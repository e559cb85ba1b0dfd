// SPDX-License-Identifier: Apache-2.0
/// Sessions of a virtual unit that is described by a text protocol.
#pragma once

#include <memory>

#include "simulator/served_registers.hpp"
#include "simulator/servers/session.hpp"

namespace gyrotherm::simulator {

/// Returns a session that answers the questions and commands of `registers.map()`, which must have a text link, over
/// the link `kind`. A line that fits neither is refused as the table [simulated] states, or ignored. If `has_lag`, a
/// written value is read back only after the time `lag` of that table. `registers` must outlive the session.
[[nodiscard]] std::unique_ptr<Session> make_text_session(ServedRegisters& registers, drivers::LinkKind kind,
                                                         bool has_lag);

}  // namespace gyrotherm::simulator
