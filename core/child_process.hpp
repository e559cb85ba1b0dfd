// SPDX-License-Identifier: Apache-2.0
/// Child processes. ChildProcess runs a function of this program that may hang or crash. The functions below it start
/// other programs and wait for them. All functions may be called from any thread.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/file.hpp"
#include "core/quantity.hpp"
#include "core/result.hpp"

namespace gyrotherm {

/// The read end (`from`) and the write end (`to`) of a pipe. Programs that this process starts do not inherit them.
struct Pipe {
  Descriptor from, to;
};
/// Creates a pipe. On failure both descriptors are closed and errno is set.
[[nodiscard]] Pipe new_pipe();

/// Redirects standard input to /dev/null. A child calls this because it must not share its parent's input.
void detach_standard_input();

/// Waits for a child to end and sets `status` as waitpid() does. Returns false if the child does not end in time.
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
  /// Kills the child if it is still running. A child that is blocked in the kernel may outlive this object.
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

/// Allows this process `more` seconds of further processor time. SIGXCPU then ends the process.
void limit_processor_time(std::chrono::seconds more);

/// Working directory and output files of a program that is started. An empty member means that the program inherits the
/// setting of this process.
struct LaunchSettings {
  std::string folder{};
  /// File for stdout; an existing file is overwritten.
  std::string output{};
  /// File to which stderr is appended, and stdout too if `output` is empty.
  std::string log{};
  /// True: the program leads a process group of its own, so that a signal to the group also reaches its children.
  bool has_own_group{};
};

/// Starts a program without a shell. A name without a slash is searched for in PATH. The program's standard input is
/// empty, and none of its signals is blocked. Fails with refused if the program cannot be started.
[[nodiscard]] Result<pid_t> start(const std::vector<std::string>& command, const LaunchSettings& in = {});

/// Waits for a child to end. Returns its exit code, or 128 plus the number of the signal that ended it.
[[nodiscard]] int wait_for(pid_t child);

/// Starts a program, waits for it to end, and returns its exit code as wait_for() does. Fails with refused if the
/// program cannot be started.
[[nodiscard]] Result<int> run_and_wait(const std::vector<std::string>& command, const LaunchSettings& in = {});

/// Largest output that read_program_output() accepts by default.
inline constexpr std::size_t kMaxOutputBytes = 16'000'000;

/// Runs a program and returns its stdout. Fails with refused if its exit code is not 0; the message contains its
/// stderr, or its stdout if stderr is empty. Kills the program and fails with timeout if it does not end in time, and
/// with refused if it prints more than `max_bytes` to stdout and stderr together.
[[nodiscard]] Result<std::string> read_program_output(const std::vector<std::string>& command, Duration within,
                                                      std::size_t max_bytes = kMaxOutputBytes);

}  // namespace gyrotherm
