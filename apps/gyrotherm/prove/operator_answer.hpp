// SPDX-License-Identifier: Apache-2.0
/// The answer of the operator to a question of a proof test.
#pragma once

namespace gyrotherm::app {

/// Discards input that was typed before the question, so that it does not answer it. Does nothing unless `input` is a
/// terminal.
void discard_typed_input(int input);

/// Reads a line. Returns true if it confirms the step: it is empty or blank. Any other line, and the end of the input,
/// does not confirm it.
[[nodiscard]] bool read_confirmation(int input);

}  // namespace gyrotherm::app
