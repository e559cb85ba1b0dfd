/// What an operator's word does to a run under way.
#pragma once

#include <string>

#include "sequencer/run/control_message.hpp"
#include "sequencer/run/run_controller.hpp"

namespace gyrotherm {

/// Carries it out with the next tick and says so, or says why not. Either way it is in the record, with who it was.
[[nodiscard]] ControlAnswer carry_out(RunController& run_controller, const ControlRequest& request,
                                      const std::string& who);

}  // namespace gyrotherm
