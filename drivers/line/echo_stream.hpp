// SPDX-License-Identifier: Apache-2.0
/// A line whose adapter returns what is sent, as two-wire RS-485 adapters do whose receiver stays on.
#pragma once

#include <memory>

#include "core/clock.hpp"
#include "drivers/wires.hpp"

namespace gyrotherm::drivers {

/// Each write reads its echo back and compares it with what was sent, so that reads return what others sent. Up to
/// eight stray bytes before the echo are ignored: nothing that precedes it can answer it. A write fails as that of
/// `line`, with timeout if nothing came back in 250 ms, or with corrupted if something else did; then an answer may
/// still come.
///
/// `clock` must be that of `line` and outlive the stream; without one the steady clock counts.
[[nodiscard]] std::unique_ptr<ByteStream> make_echo_stream(std::unique_ptr<ByteStream> line,
                                                           const Clock* clock = nullptr);

}  // namespace gyrotherm::drivers
