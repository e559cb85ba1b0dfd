/// The message-passing library that hypre needs, started once for this process alone.
#pragma once

namespace gyrotherm {

/// Starts it at the first call; it ends with the process. Signal handlers are as before.
void start_message_passing();

}  // namespace gyrotherm
