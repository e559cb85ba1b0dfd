// SPDX-License-Identifier: Apache-2.0
/// Child processes: functions of this program that may hang or crash without harming it, and other programs that are
/// started and awaited. All functions may be called from any thread.
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

/// A pipe whose ends are closed in every program that this process starts. Both descriptors are closed if no pipe can
/// be made.
struct Pipe {
  Descriptor from, to;
};
[[nodiscard]] Pipe new_pipe();

/// Redirects standard input to /dev/null, so that a child process does not share its parent's input.
void detach_standard_input();

/// Waits for a child to end. Returns false if it does not end in time; sets `status` as waitpid() does.
[[nodiscard]] bool reap(pid_t pid, Duration within, int* status = nullptr);

/// Describes how a child ended: "ended with exit code 3", "was ended by signal 11 (Segmentation fault)".
[[nodiscard]] std::string describe_exit_status(int status);

/// Limits of a child that runs third-party code on untrusted data.
struct Confinement {
  /// Address space in addition to the parent's.
  std::uint64_t memory_bytes{};
};
/// Exit code of a confined child that ran out of memory in C++ code.
inline constexpr int kOutOfMemoryExitCode = 71;

/// A child and the pipe through which it reports to its parent. The child is killed when its parent dies.
class ChildProcess {
 public:
  /// Runs `work` in a child; `work` writes its results to the descriptor `to_parent`. A confined child has no other
  /// open descriptor and no standard streams, cannot write files, and leaves no core dump. Sanitizer builds set no
  /// memory limit, because a sanitizer reserves the whole address space. If the parent has other threads, `work` must
  /// not take a lock that they use.
  explicit ChildProcess(const std::function<void(int to_parent)>& work,
                        const std::optional<Confinement>& confinement = std::nullopt);
  /// Kills the child if it is still running. A child that hangs in the kernel remains.
  ~ChildProcess();
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  [[nodiscard]] bool has_begun() const { return pid_ > 0; }
  /// Returns the descriptor from which the parent reads.
  [[nodiscard]] int output() const { return output_.number(); }
  /// Waits for the child to end and returns its status as waitpid() does. Returns nothing if it does not end in time.
  [[nodiscard]] std::optional<int> wait(Duration within);

 private:
  pid_t pid_ = -1;  ///< 0 after wait() succeeded
  Descriptor output_;
};

/// Limits the processor time of this process to `more` seconds from now on; SIGXCPU then ends it.
void limit_processor_time(std::chrono::seconds more);

/// Working directory and output files of a program that is started. An empty member keeps the setting of this process.
struct LaunchSettings {
  std::string folder{};
  /// File for stdout; an existing file is overwritten.
  std::string output{};
  /// File to which stderr is appended, and stdout too if `output` is empty.
  std::string log{};
};

/// Starts a program without a shell. A name without a slash is searched in PATH. The program gets an empty standard
/// input and no blocked signals. Fails with refused.
[[nodiscard]] Result<pid_t> start(const std::vector<std::string>& command, const LaunchSettings& in = {});

/// Waits for a child to end. Returns its exit code, or 128 plus the number of the signal that ended it.
[[nodiscard]] int wait_for(pid_t child);

/// Starts a program, waits for it to end, and returns as wait_for() does. Fails with refused.
[[nodiscard]] Result<int> run_and_wait(const std::vector<std::string>& command, const LaunchSettings& in = {});

/// Runs a program and returns its stdout. Fails with refused if its exit code is not 0, and reports its stderr, or its
/// stdout if stderr is empty. Fails with timeout if the program does not end `within` that time, after killing it.
[[nodiscard]] Result<std::string> read_program_output(const std::vector<std::string>& command, Duration within);

}  // namespace gyrotherm
