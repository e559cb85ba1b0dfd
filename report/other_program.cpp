// SPDX-License-Identifier: Apache-2.0
#include "report/other_program.hpp"

#include <fmt/format.h>
#include <stdlib.h>
#include <sys/mman.h>
#include <sys/random.h>
#include <unistd.h>

#include <QProcess>
#include <QProcessEnvironment>
#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <filesystem>
#include <system_error>
#include <utility>

namespace gyrotherm::report {
namespace {

constexpr std::array<std::pair<std::string_view, const char*>, 5> kPackages{{{"xmlsec1", "xmlsec1"},
                                                                             {"pdfsig", "poppler-utils"},
                                                                             {"certutil", "libnss3-tools"},
                                                                             {"pk12util", "libnss3-tools"},
                                                                             {"openssl", "openssl"}}};

std::string package_for(const std::string& program) {
  for (const auto& [name, package] : kPackages)
    if (name == program) return package;
  return program;
}

tl::unexpected<Fault> not_started_fault(const std::string& program) {
  return failure(FaultKind::bad_file, program,
                 fmt::format("is not installed or cannot be run; it is in the Debian package {}: "
                             "sudo apt install {}",
                             package_for(program), package_for(program)));
}

constexpr std::string_view kFolderName = "/gyrotherm-sign-", kFolderSuffix = "XXXXXX";
constexpr std::array kEndingSignals{SIGINT, SIGTERM, SIGHUP};

/// Returns the folder of private folders.
std::string private_base() {
  const char* runtime = std::getenv("XDG_RUNTIME_DIR");
  std::error_code error;
  if (runtime != nullptr && std::filesystem::is_directory(runtime, error)) return runtime;
  const auto path = std::filesystem::temp_directory_path(error);
  return error ? "/tmp" : path.string();
}

/// Blocks the ending signals of this thread while private folders exist, and restores the mask after the last one.
class FolderSignals {
 public:
  void add_folder() {
    if (++folders_ > 1) return;
    sigset_t ending;
    sigemptyset(&ending);
    for (const int signal : kEndingSignals) sigaddset(&ending, signal);
    pthread_sigmask(SIG_BLOCK, &ending, &before_);
  }
  void remove_folder() {
    if (--folders_ == 0) pthread_sigmask(SIG_SETMASK, &before_, nullptr);
  }
  [[nodiscard]] bool are_blocked() const { return folders_ > 0; }
  [[nodiscard]] const sigset_t& mask_before() const { return before_; }

  /// Returns whether a signal is pending that takes effect after the last folder. The kernel also keeps an ignored
  /// signal pending while it is blocked.
  [[nodiscard]] bool is_pending() const {
    sigset_t pending;
    if (folders_ == 0 || sigpending(&pending) != 0) return false;
    return std::ranges::any_of(kEndingSignals, [&](int signal) {
      struct sigaction action {};
      return sigismember(&pending, signal) == 1 && sigismember(&before_, signal) == 0 &&
             ::sigaction(signal, nullptr, &action) == 0 && action.sa_handler != SIG_IGN;
    });
  }

 private:
  int folders_ = 0;
  sigset_t before_{};
};

thread_local FolderSignals folder_signals;

enum class ProcessEnd { finished, timed_out, interrupted };

/// Waits for the end of a process. Ends it after `longest` or if a signal is pending: with SIGTERM, so that it removes
/// its own private folders, then with SIGKILL.
ProcessEnd wait_for_end(QProcess& process, std::chrono::milliseconds longest) {
  constexpr int kPoll_ms = 50, kGrace_ms = 5000;
  const auto deadline = std::chrono::steady_clock::now() + longest;
  bool has_ended = false, is_interrupted = false;
  while (!has_ended && !is_interrupted && std::chrono::steady_clock::now() < deadline) {
    has_ended = process.waitForFinished(kPoll_ms) || process.state() == QProcess::NotRunning;
    is_interrupted = folder_signals.is_pending();
  }
  if (!has_ended) {
    process.terminate();
    if (!process.waitForFinished(kGrace_ms) && process.state() != QProcess::NotRunning) {
      process.kill();
      process.waitForFinished(kGrace_ms);
    }
  }
  if (is_interrupted) return ProcessEnd::interrupted;
  return has_ended ? ProcessEnd::finished : ProcessEnd::timed_out;
}

}  // namespace

Result<ProgramRun> run_program(const std::string& program, const std::vector<std::string>& arguments,
                               std::chrono::milliseconds longest) {
  QProcess process;
  QProcessEnvironment environment = QProcessEnvironment::systemEnvironment();
  environment.insert("LC_ALL", "C.UTF-8");
  environment.insert("TZ", "UTC");
  process.setProcessEnvironment(environment);
  process.setProcessChannelMode(QProcess::MergedChannels);
  process.setStandardInputFile(QProcess::nullDevice());
  QStringList qt_arguments;
  for (const std::string& argument : arguments) qt_arguments << QString::fromStdString(argument);
  if (folder_signals.are_blocked())
    process.setChildProcessModifier(
        [before = folder_signals.mask_before()] { pthread_sigmask(SIG_SETMASK, &before, nullptr); });
  process.start(QString::fromStdString(program), qt_arguments, QIODevice::ReadOnly);
  const int milliseconds = static_cast<int>(longest.count());
  if (!process.waitForStarted(milliseconds)) return not_started_fault(program);
  switch (wait_for_end(process, longest)) {
    case ProcessEnd::finished: break;
    case ProcessEnd::timed_out:
      return failure(FaultKind::timeout, program, fmt::format("did not exit within {} ms", milliseconds));
    case ProcessEnd::interrupted: return failure(FaultKind::interrupted, program, "was ended by a signal to gyrotherm");
  }
  if (process.exitStatus() != QProcess::NormalExit)
    return failure(FaultKind::refused, program, "was terminated by a signal");
  return ProgramRun{process.exitCode(), hide_private_paths(process.readAll().toStdString())};
}

std::string hide_private_paths(std::string text) {
  const std::string begin = private_base() + std::string(kFolderName);
  const std::size_t length = begin.size() + kFolderSuffix.size() + 1;
  for (auto at = text.find(begin); at != std::string::npos; at = text.find(begin, at)) text.erase(at, length);
  const std::string memory = fmt::format("/proc/{}/fd/", ::getpid());
  for (auto at = text.find(memory); at != std::string::npos; at = text.find(memory, at)) {
    const auto end = std::min(text.find_first_not_of("0123456789", at + memory.size()), text.size());
    text.replace(at, end - at, "memory");
  }
  return text;
}

Result<PrivateFolder> PrivateFolder::make() {
  const std::string base = private_base();
  std::string path = base + std::string(kFolderName) + std::string(kFolderSuffix);
  folder_signals.add_folder();
  if (::mkdtemp(path.data()) != nullptr) return PrivateFolder(std::move(path));
  const int error = errno;
  folder_signals.remove_folder();
  return failure(FaultKind::storage, base,
                 "cannot create a temporary folder: " + std::generic_category().message(error));
}

PrivateFolder::~PrivateFolder() {
  if (path_.empty()) return;
  std::error_code error;
  std::filesystem::remove_all(path_, error);
  folder_signals.remove_folder();
}

Result<MemoryFile> MemoryFile::make(std::string_view content) {
  MemoryFile file(::memfd_create("gyrotherm", MFD_CLOEXEC));
  const bool is_open = file.descriptor_ >= 0;
  if (is_open && ::write(file.descriptor_, content.data(), content.size()) == std::ssize(content)) return file;
  return failure(FaultKind::storage, "memory", "cannot create a file: " + std::generic_category().message(errno));
}

MemoryFile::~MemoryFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

std::string MemoryFile::path() const { return fmt::format("/proc/{}/fd/{}", ::getpid(), descriptor_); }

Result<std::string> make_random_password() {
  std::array<unsigned char, 32> bytes{};
  if (::getrandom(bytes.data(), bytes.size(), 0) != std::ssize(bytes))
    return failure(FaultKind::storage, "getrandom", std::generic_category().message(errno));
  std::string text;
  for (const unsigned char byte : bytes) text += fmt::format("{:02x}", byte);
  return text;
}

}  // namespace gyrotherm::report
