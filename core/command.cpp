// SPDX-License-Identifier: Apache-2.0
#include "core/command.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <optional>

#include "core/deadline.hpp"
#include "core/file.hpp"
#include "core/text.hpp"

namespace gyrotherm {

namespace {

constexpr mode_t kForOwnerAndGroup = 0640;

class FileActions {
 public:
  FileActions() { posix_spawn_file_actions_init(&actions_); }
  FileActions(const FileActions&) = delete;
  FileActions& operator=(const FileActions&) = delete;
  ~FileActions() { posix_spawn_file_actions_destroy(&actions_); }

  void open(int number, const char* path, int how) {
    posix_spawn_file_actions_addopen(&actions_, number, path, how, kForOwnerAndGroup);
  }
  void copy(int from, int to) { posix_spawn_file_actions_adddup2(&actions_, from, to); }
  void stand_in(const std::string& folder) { posix_spawn_file_actions_addchdir_np(&actions_, folder.c_str()); }
  [[nodiscard]] const posix_spawn_file_actions_t* get() const { return &actions_; }

 private:
  posix_spawn_file_actions_t actions_{};
};

Result<pid_t> spawn(const std::vector<std::string>& command, const FileActions& files) {
  std::vector<char*> words;
  for (const auto& word : command) words.push_back(const_cast<char*>(word.c_str()));  // execve() asks for it
  words.push_back(nullptr);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  sigset_t none;
  sigemptyset(&none);
  posix_spawnattr_setsigmask(&attributes, &none);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK);
  pid_t child{};
  const int code = ::posix_spawnp(&child, words.front(), files.get(), &attributes, words.data(), environ);
  posix_spawnattr_destroy(&attributes);
  if (code != 0) return failure(FaultKind::refused, command.front(), std::strerror(code));
  return child;
}

/// What a program says at its two outputs.
struct Said {
  std::string output, complaint;
};

/// False at the end of the line.
bool take_piece(int number, std::string& text) {
  std::array<char, 4096> piece;
  const auto got = ::read(number, piece.data(), piece.size());
  if (got < 0) return errno == EINTR;
  text.append(piece.data(), static_cast<std::size_t>(got));
  return got > 0;
}

/// Nothing if the ends of both do not come in time.
std::optional<Said> read_to_their_ends(int output, int complaint, const Deadline& deadline) {
  Said said;
  std::array lines{pollfd{output, POLLIN, 0}, pollfd{complaint, POLLIN, 0}};  // poll() passes over one below 0
  const std::array texts{&said.output, &said.complaint};
  while (lines[0].fd >= 0 || lines[1].fd >= 0) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(deadline.left()).count();
    const int found = ::poll(lines.data(), lines.size(), static_cast<int>(left));
    if (found < 0 && errno == EINTR) continue;
    if (found <= 0) return std::nullopt;
    for (std::size_t i = 0; i < lines.size(); ++i)
      if (lines[i].revents != 0 && !take_piece(lines[i].fd, *texts[i])) lines[i].fd = kNoDescriptor;
  }
  return said;
}

struct Pipe {
  Descriptor reading, writing;
};

Result<Pipe> open_pipe(const std::string& for_whom) {
  std::array<int, 2> ends{};
  if (::pipe2(ends.data(), O_CLOEXEC) != 0) return failure(FaultKind::refused, for_whom, std::strerror(errno));
  return Pipe{.reading = Descriptor(ends[0]), .writing = Descriptor(ends[1])};
}

}  // namespace

Result<pid_t> start(const std::vector<std::string>& command, const Surroundings& in) {
  FileActions files;
  files.open(STDIN_FILENO, "/dev/null", O_RDONLY);
  if (!in.log.empty()) {
    files.open(STDERR_FILENO, in.log.c_str(), O_WRONLY | O_CREAT | O_APPEND);
    files.copy(STDERR_FILENO, STDOUT_FILENO);
  }
  if (!in.output.empty()) files.open(STDOUT_FILENO, in.output.c_str(), O_WRONLY | O_CREAT | O_TRUNC);
  if (!in.folder.empty()) files.stand_in(in.folder);
  return spawn(command, files);
}

int wait_for(pid_t child) {
  constexpr int kSignals = 128;  // a shell's way to say so
  int status = 0;
  while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : kSignals + WTERMSIG(status);
}

Result<int> run_to_its_end(const std::vector<std::string>& command, const Surroundings& in) {
  return start(command, in).map(wait_for);
}

Result<std::string> printed_by(const std::vector<std::string>& command, Duration within) {
  auto output = open_pipe(command.front());
  if (!output) return failure(output.error());
  auto complaint = open_pipe(command.front());
  if (!complaint) return failure(complaint.error());
  FileActions files;
  files.open(STDIN_FILENO, "/dev/null", O_RDONLY);
  files.copy(output->writing.number(), STDOUT_FILENO);
  files.copy(complaint->writing.number(), STDERR_FILENO);
  const auto child = spawn(command, files);
  if (!child) return failure(child.error());
  output->writing.close();
  complaint->writing.close();
  auto said = read_to_their_ends(output->reading.number(), complaint->reading.number(), Deadline(within));
  if (!said) ::kill(*child, SIGKILL);
  const int code = wait_for(*child);
  if (!said) return failure(FaultKind::timeout, command.front(), "did not end in time");
  if (code != 0)
    return failure(FaultKind::refused, fmt::format("{}", fmt::join(command, " ")),
                   fmt::format("ended with {}: {}", code,
                               trimmed(said->complaint.empty() ? said->output : said->complaint, " \n")));
  return std::move(said->output);
}

}  // namespace gyrotherm
