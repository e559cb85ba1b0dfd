// SPDX-License-Identifier: Apache-2.0
/// The protocol of proof tests as a printable page, in English and in German.
#pragma once

#include "apps/gyrotherm/protocol_folder.hpp"

namespace gyrotherm::app {

/// Returns the kind of the protocol of proof tests (sequencer/prove/proof.hpp), with its page.
[[nodiscard]] ProtocolKind proof_protocol();

}  // namespace gyrotherm::app
