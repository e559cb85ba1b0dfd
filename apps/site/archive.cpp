// SPDX-License-Identifier: Apache-2.0
#include "apps/site/archive.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <charconv>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <string_view>

#include "acquisition/record/chain.hpp"
#include "core/child_process.hpp"
#include "core/clock.hpp"
#include "core/deadline.hpp"
#include "core/file.hpp"
#include "core/sha256.hpp"

namespace gyrotherm::site {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kPartSuffix = ".part";

tl::unexpected<Fault> make_errno_fault(const std::string& path) {
  return failure(FaultKind::storage, path, std::strerror(errno));
}

/// Copies the content of a file, syncs the copy, and returns the digest of the copied bytes.
Result<std::string> copy_bytes(const RegularFile& from, int to, const std::string& path) {
  Sha256 hash;
  std::array<char, 1 << 18> piece{};
  for (;;) {
    const auto count = read_some(from.descriptor.number(), piece.data(), piece.size());
    if (count < 0) return make_errno_fault(path);
    if (count == 0) break;
    const std::string_view bytes(piece.data(), static_cast<std::size_t>(count));
    hash.add(bytes);
    if (!write_all(to, bytes)) return make_errno_fault(path);
  }
  if (::fsync(to) != 0) return make_errno_fault(path);
  return hex(hash.digest());
}

Result<void> sync_folder(const std::string& folder) {
  const Descriptor opened(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (!opened.is_open() || ::fsync(opened.number()) != 0) return make_errno_fault(folder);
  return {};
}

/// Removes incomplete copies of publishers that were killed: PATH.PID.part, if no process has that number. In a folder
/// that several machines share, this may remove the copy of a running publisher on another machine. That publisher then
/// tries again.
void remove_stale_copies(const std::string& path) {
  const auto prefix = fs::path(path).filename().string() + ".";
  for (const auto& entry : list_folder(fs::path(path).parent_path())) {
    const auto name = entry.filename().string();
    if (!name.starts_with(prefix) || !name.ends_with(kPartSuffix)) continue;
    const auto number = std::string_view(name).substr(prefix.size());
    int pid{};
    const auto read = std::from_chars(number.data(), number.data() + number.size(), pid);
    const bool is_copy = read.ec == std::errc() && std::string_view(read.ptr) == kPartSuffix && pid > 0;
    if (is_copy && ::kill(pid, 0) != 0 && errno == ESRCH) ::unlink(entry.c_str());
  }
}

Result<void> copy_to_folder(const std::string& folder, const RunFileDigest& file) {
  const auto target = (fs::path(folder) / (file.sha256 + ".db")).string();
  remove_stale_copies(target);
  struct stat facts {};
  if (::stat(target.c_str(), &facts) == 0 && static_cast<std::uint64_t>(facts.st_size) == file.bytes) return {};
  const auto source = open_regular_file(file.path);
  if (!source) return failure(source.error());
  const auto unfinished = fmt::format("{}.{}{}", target, ::getpid(), kPartSuffix);
  Descriptor made(::open(unfinished.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_NOFOLLOW | O_CLOEXEC, 0640));
  if (!made.is_open()) return make_errno_fault(unfinished);
  auto copied = copy_bytes(*source, made.number(), unfinished);
  if (copied && *copied != file.sha256) copied = failure(FaultKind::storage, file.path, "changed while it was copied");
  if (copied && std::rename(unfinished.c_str(), target.c_str()) != 0) copied = make_errno_fault(target);
  if (!copied) {
    ::unlink(unfinished.c_str());
    return failure(copied.error());
  }
  return sync_folder(folder);
}

Result<void> run_command(const std::vector<std::string>& command, Duration within, int stop) {
  const auto child = start(command, {.has_own_group = true});
  if (!child) return failure(child.error());
  const Descriptor ended(static_cast<int>(::syscall(SYS_pidfd_open, *child, 0)));
  std::array<pollfd, 2> lines{pollfd{ended.number(), POLLIN, 0}, pollfd{stop, POLLIN, 0}};
  const Deadline deadline(within);
  int found = 0;
  do {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(deadline.left()).count();
    found = ::poll(lines.data(), lines.size(), static_cast<int>(left));
  } while (found < 0 && errno == EINTR);
  const bool has_ended = found > 0 && lines[0].revents != 0;
  if (!has_ended) ::kill(-*child, SIGKILL);
  const int code = wait_for(*child);
  if (!has_ended && found > 0) return failure(FaultKind::interrupted, command.front(), "stopped");
  if (!has_ended)
    return failure(FaultKind::timeout, command.front(), fmt::format("did not end within {}", format_duration(within)));
  if (code == 0) return {};
  return failure(FaultKind::refused, command.front(), fmt::format("ended with exit code {}", code));
}

void replace_all(std::string& text, std::string_view what, const std::string& with) {
  for (auto at = text.find(what); at != std::string::npos; at = text.find(what, at + with.size()))
    text.replace(at, what.size(), with);
}

}  // namespace

Result<RunFileDigest> compute_digest(const std::string& path) {
  struct stat facts {};
  if (::stat(path.c_str(), &facts) != 0) return failure(FaultKind::bad_file, path, std::strerror(errno));
  return record::file_digest(path).map([&](std::string digest) {
    return RunFileDigest{.path = path,
                         .name = fs::path(path).filename().string(),
                         .sha256 = std::move(digest),
                         .bytes = static_cast<std::uint64_t>(facts.st_size)};
  });
}

std::vector<std::string> expand_command(const std::vector<std::string>& command, const RunFileDigest& file) {
  auto words = command;
  for (auto& word : words) {
    replace_all(word, "{sha256}", file.sha256);
    replace_all(word, "{file}", file.path);
  }
  return words;
}

Result<void> archive(const ArchiveSettings& settings, const RunFileDigest& file, int stop) {
  if (!settings.folder.empty()) return copy_to_folder(settings.folder, file);
  if (!settings.command.empty()) return run_command(expand_command(settings.command, file), settings.within, stop);
  return {};
}

}  // namespace gyrotherm::site
