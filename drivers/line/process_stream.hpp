// SPDX-License-Identifier: Apache-2.0
/// A third-party program as a byte stream: written bytes go to its standard input, and its standard output is read.
/// Because the program is a separate process, the process that drives a chamber is not affected if the program crashes,
/// hangs or leaks memory.
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.hpp"
#include "drivers/wires.hpp"

namespace gyrotherm::drivers {

/// A program and its arguments, which no shell interprets. A program name without a slash is searched for in PATH.
/// Relative paths are relative to `folder`, the program's working directory.
struct ProgramCommand {
  std::vector<std::string> words;
  std::string folder = ".";
};
/// Formats the command for messages, with blanks between its arguments.
[[nodiscard]] std::string text(const ProgramCommand& command);
/// Returns the path of the executable file. Fails with disconnected if there is none, or if this user may not execute
/// it.
[[nodiscard]] Result<std::string> find_program(const ProgramCommand& command);

/// The stream of a program; not thread-safe. The program is started at first use, and again after it ended. It inherits
/// only its three standard streams and runs in its own process group. After it ended twice in a row, calls fail
/// immediately for 0.5 s, then for longer periods up to 10 s. If it ends, calls fail with disconnected; the message
/// contains its exit status and the last line that it wrote to stderr.
class ProcessStream final : public ByteStream {
 public:
  explicit ProcessStream(ProgramCommand command);
  /// Closes the program's standard input, waits up to half a second for the program to end, and kills its process
  /// group.
  ~ProcessStream() override;
  ProcessStream(const ProcessStream&) = delete;
  ProcessStream& operator=(const ProcessStream&) = delete;

  [[nodiscard]] Result<std::size_t> read(std::span<std::byte> buffer, Duration within) override;
  [[nodiscard]] Result<void> write(std::span<const std::byte> bytes, Duration within) override;
  /// Kills the process group of a misbehaving program. The next use starts the program again.
  void kill();

 private:
  class Child;
  [[nodiscard]] Result<void> start();
  [[nodiscard]] tl::unexpected<Fault> close_with_fault(std::string why);

  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace gyrotherm::drivers
