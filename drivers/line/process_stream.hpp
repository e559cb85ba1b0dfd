// SPDX-License-Identifier: Apache-2.0
/// A program of others as a line: what is written goes to its standard input, what it prints comes back. It is a
/// process of its own, so that it may crash, hang and leak without harm to whoever drives a chamber.
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.hpp"
#include "drivers/wires.hpp"

namespace gyrotherm::drivers {

/// A program and its arguments, which no shell sees. A program named without a slash is looked for in the path; what is
/// relative is so to `folder`, in which it runs.
struct ProgramCommand {
  std::vector<std::string> words;
  std::string folder = ".";
};
/// For people: its words with blanks between them.
[[nodiscard]] std::string text(const ProgramCommand& command);
/// The file that would be run. Fails with disconnected if there is none, or if this user may not run it.
[[nodiscard]] Result<std::string> find_program(const ProgramCommand& command);

/// One thread. The program is started at first use, and again after it ended; after a second end in a row the line
/// rests 0.5 s, then longer, up to 10 s, and until then every use fails at once. It is started with no open file but
/// its three, in a process group of its own. Its end is a disconnected fault that says how it ended, and the last line
/// that it wrote to its standard error.
class ProcessStream final : public ByteStream {
 public:
  explicit ProcessStream(ProgramCommand command);
  /// Closes the program's standard input, gives it half a second to end by itself, and kills it with its group.
  ~ProcessStream() override;
  ProcessStream(const ProcessStream&) = delete;
  ProcessStream& operator=(const ProcessStream&) = delete;

  [[nodiscard]] Result<std::size_t> read(std::span<std::byte> buffer, Duration within) override;
  [[nodiscard]] Result<void> write(std::span<const std::byte> bytes, Duration within) override;
  /// Kills the program with its group, as one that does not do what it should; the next use starts it anew.
  void kill();

 private:
  class Child;
  [[nodiscard]] Result<void> start();
  [[nodiscard]] tl::unexpected<Fault> broken(std::string why);

  struct Inside;
  std::unique_ptr<Inside> inside_;
};

}  // namespace gyrotherm::drivers
