// SPDX-License-Identifier: Apache-2.0
/// Child processes: work of this program, which then hangs or crashes alone, and other programs, which are started and
/// waited for. Any thread.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/file.hpp"
#include "core/quantity.hpp"
#include "core/result.hpp"

namespace gyrotherm {

/// A pipe of which both ends are closed in programs that this one starts; without open ends if there is none to be had.
struct Pipe {
  Descriptor from, to;
};
[[nodiscard]] Pipe new_pipe();

/// Reads standard input from nothing from now on: that of a child's parent is not the child's.
void leave_parents_input();

/// Waits for the end of a child. Returns false if it has not ended in time; `status` is set as waitpid() does.
[[nodiscard]] bool reap(pid_t pid, Duration within, int* status = nullptr);

/// Returns the ending of a child in words: "ended with exit code 3", "was ended by signal 11 (Segmentation fault)".
[[nodiscard]] std::string ending_in_words(int status);

/// The limits of a child that carries out code of others on bytes of others.
struct Confinement {
  std::uint64_t memory_bytes{};  ///< address space, beyond the parent's
};
/// The exit code of a confined child whose C++ code was given no memory.
inline constexpr int kNoMemoryLeft = 71;

/// A child and the pipe by which it speaks to its parent. It is killed when its parent dies.
class ChildProcess {
 public:
  /// Begins `work` in a child, which writes to the descriptor that it is given. A confined child has no other open
  /// descriptor, no standard streams, writes no file and leaves no core dump; the limit of memory is not set where a
  /// sanitizer wants the whole address space. The parent may have other threads only if `work` takes no lock of theirs.
  explicit ChildProcess(const std::function<void(int to_parent)>& work,
                        const std::optional<Confinement>& confinement = std::nullopt);
  /// Kills the child if it still works; one that hangs in the kernel stays there.
  ~ChildProcess();
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  [[nodiscard]] bool has_begun() const { return pid_ > 0; }
  /// The end that the parent reads.
  [[nodiscard]] int output() const { return output_.number(); }
  /// Waits for the end of the child and returns its status, as waitpid() does. Returns nothing if it has not ended in
  /// time.
  [[nodiscard]] std::optional<int> wait(Duration within);

 private:
  pid_t pid_ = -1;  ///< 0 once it was waited for
  Descriptor output_;
};

/// Lets this process use so many more seconds of processor time, from now on; then SIGXCPU ends it.
void allow_processor_time(std::chrono::seconds more);

/// Surroundings of a program that is started. An empty member leaves those of this process.
struct Surroundings {
  std::string folder{};  ///< working directory
  std::string output{};  ///< file for stdout, made anew
  /// File to which stderr is appended, and stdout too if there is no `output`.
  std::string log{};
};

/// Starts a program without a shell. A name without a slash is looked up in the path. The program has an empty standard
/// input and no blocked signal. Fails with refused.
[[nodiscard]] Result<pid_t> start(const std::vector<std::string>& command, const Surroundings& in = {});

/// Waits for the end of a child. Returns its exit code, or 128 plus the number of the signal that ended it.
[[nodiscard]] int wait_for(pid_t child);

/// Starts a program and waits for its end. Returns as wait_for() does. Fails with refused.
[[nodiscard]] Result<int> run_to_its_end(const std::vector<std::string>& command, const Surroundings& in = {});

/// Returns what a program prints on its stdout. Fails with refused if its exit code is not 0, and reports its stderr,
/// or its stdout if that was empty; with timeout if it does not end `within`: it is killed then.
[[nodiscard]] Result<std::string> printed_by(const std::vector<std::string>& command, Duration within);

}  // namespace gyrotherm
