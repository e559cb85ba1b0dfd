// SPDX-License-Identifier: Apache-2.0
#include "apps/gyrotherm/machine_checks.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sched.h>
#include <sys/resource.h>
#include <sys/statfs.h>
#include <sys/statvfs.h>
#include <sys/timex.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string_view>
#include <system_error>

#include "core/file.hpp"
#include "core/process.hpp"
#include "core/shipped.hpp"
#include "core/text.hpp"

namespace gyrotherm::app {
namespace {

namespace fs = std::filesystem;

/// Returns a path as one word of a shell command.
std::string quote_for_shell(const std::string& path) {
  if (path.find_first_of(" \t'\"$`\\*?&;|<>()") == std::string::npos) return path;
  std::string quoted = "'";
  for (const char c : path) quoted += c == '\'' ? "'\\''" : std::string(1, c);
  return quoted + "'";
}

// ---- disk

constexpr double kMegabyte = 1e6;
/// A run with one axis and eight thermometers writes about 17 MB a day, and its live copy the same amount.
constexpr double kScarceBytes = 1000 * kMegabyte, kTooFewBytes = 100 * kMegabyte;
constexpr std::uint64_t kScarceInodes = 10'000, kTooFewInodes = 100;

enum class DiskKind { local, in_memory, network, simple, kernel };

struct FileSystem {
  std::uint32_t magic;
  const char* name;
  DiskKind kind;
};

constexpr std::array kFileSystems{
    FileSystem{0xEF53, "ext4", DiskKind::local},          FileSystem{0x58465342, "xfs", DiskKind::local},
    FileSystem{0x9123683E, "btrfs", DiskKind::local},     FileSystem{0x2FC12FC1, "zfs", DiskKind::local},
    FileSystem{0xF2F52010, "f2fs", DiskKind::local},      FileSystem{0x794C7630, "overlay", DiskKind::local},
    FileSystem{0x01021994, "tmpfs", DiskKind::in_memory}, FileSystem{0x858458F6, "ramfs", DiskKind::in_memory},
    FileSystem{0x6969, "NFS", DiskKind::network},         FileSystem{0xFF534D42, "CIFS", DiskKind::network},
    FileSystem{0xFE534D42, "SMB", DiskKind::network},     FileSystem{0x517B, "SMB", DiskKind::network},
    FileSystem{0x65735546, "FUSE", DiskKind::network},    FileSystem{0x01021997, "9p", DiskKind::network},
    FileSystem{0x00C36400, "Ceph", DiskKind::network},    FileSystem{0x4D44, "FAT", DiskKind::simple},
    FileSystem{0x2011BAB0, "exFAT", DiskKind::simple},    FileSystem{0x9FA0, "proc", DiskKind::kernel},
    FileSystem{0x62656572, "sysfs", DiskKind::kernel}};

bool is_of_kernel(const struct statfs& disk) {
  const auto* known = std::ranges::find(kFileSystems, static_cast<std::uint32_t>(disk.f_type), &FileSystem::magic);
  return known != kFileSystems.end() && known->kind == DiskKind::kernel;
}

Finding check_file_system(const std::string& folder, const struct statfs& disk) {
  const auto magic = static_cast<std::uint32_t>(disk.f_type);
  const auto* known = std::ranges::find(kFileSystems, magic, &FileSystem::magic);
  const auto name = known == kFileSystems.end() ? fmt::format("file system 0x{:x}", magic) : std::string(known->name);
  Finding finding{"file system", FindingState::ok, fmt::format("{}, blocks of {} bytes", name, disk.f_bsize), ""};
  switch (known == kFileSystems.end() ? DiskKind::local : known->kind) {
    case DiskKind::local:
    case DiskKind::kernel: return finding;  // check_disk() reports a fault for the latter
    case DiskKind::in_memory: finding.found += ": it is in memory, and a power cut erases its records"; break;
    case DiskKind::network:
      finding.found += ": it may be on another machine, and this machine cannot guarantee its locks and syncs";
      break;
    case DiskKind::simple: finding.found += ": it has no journal, and a power cut may destroy all files on it"; break;
  }
  finding.state = FindingState::warning;
  finding.fix =
      fmt::format("record in a folder on a disk of this machine, not in {}; copy closed records afterwards", folder);
  return finding;
}

Finding check_space(const std::string& folder, const struct statvfs& disk) {
  const auto bytes = static_cast<double>(disk.f_bavail) * static_cast<double>(disk.f_frsize);
  const bool has_inodes = disk.f_files != 0;  // 0: no inode table
  Finding finding{"disk", FindingState::ok, "", "", FaultKind::storage};
  finding.found = fmt::format("{}: {:.1f} GB free", folder, bytes / 1e9);
  if (has_inodes) finding.found += fmt::format(", {} inodes", disk.f_favail);
  if (bytes < kTooFewBytes || (has_inodes && disk.f_favail < kTooFewInodes))
    finding.state = FindingState::fault;
  else if (bytes < kScarceBytes || (has_inodes && disk.f_favail < kScarceInodes))
    finding.state = FindingState::warning;
  if (finding.state != FindingState::ok)
    finding.fix =
        fmt::format("free disk space (du -x {0} | sort -n | tail), or record in another folder: --folder FOLDER",
                    quote_for_shell(folder));
  return finding;
}

// ---- limits

/// The program opens a few files for each instrument and each reader.
constexpr rlim_t kEnoughFiles = 256;
constexpr rlim_t kEnoughMemory = 1'000'000'000;

rlim_t soft_limit(__rlimit_resource_t resource) {
  rlimit limit{};
  return ::getrlimit(resource, &limit) == 0 ? limit.rlim_cur : RLIM_INFINITY;
}

std::string format_limit(rlim_t limit, const char* unit) {
  return limit == RLIM_INFINITY ? "no limit" : fmt::format("{} {}", limit, unit);
}

/// Reports any limit on a resource as a fault, because a long run reaches it eventually.
Finding check_unlimited(const char* what, __rlimit_resource_t resource, const char* unit, const char* option,
                        const char* ends) {
  const auto limit = soft_limit(resource);
  if (limit == RLIM_INFINITY) return {what, FindingState::ok, format_limit(limit, unit), ""};
  return {what, FindingState::fault, fmt::format("{}: {}", format_limit(limit, unit), ends),
          fmt::format("ulimit -{} unlimited, or /etc/security/limits.conf", option), FaultKind::storage};
}

Finding check_files() {
  const auto limit = soft_limit(RLIMIT_NOFILE);
  Finding finding{"open files", FindingState::ok, fmt::format("at most {}", format_limit(limit, "files")), ""};
  if (limit >= kEnoughFiles) return finding;
  finding.state = FindingState::warning;
  finding.fix = fmt::format("ulimit -n {}; for a service LimitNOFILE={}", 2 * kEnoughFiles, 2 * kEnoughFiles);
  return finding;
}

Finding check_memory() {
  const auto limit = std::min(soft_limit(RLIMIT_AS), soft_limit(RLIMIT_DATA));
  Finding finding{"memory", FindingState::ok, format_limit(limit, "bytes"), ""};
  if (limit >= kEnoughMemory) return finding;
  finding.state = FindingState::warning;
  finding.found += ": rows are buffered in memory while a disk hangs";
  finding.fix = "ulimit -v unlimited; ulimit -d unlimited";
  return finding;
}

/// Reports the limit for information only: the program locks no memory.
Finding check_locked_memory() {
  return {"locked memory", FindingState::ok,
          format_limit(soft_limit(RLIMIT_MEMLOCK), "bytes") + ", of which none is needed", ""};
}

Finding check_priority() {
  errno = 0;
  const int nice = ::getpriority(PRIO_PROCESS, 0);
  const int policy = ::sched_getscheduler(0);
  Finding finding{"priority", FindingState::ok, fmt::format("nice {}, no real-time priority is needed", nice), ""};
  if (policy != SCHED_IDLE && policy != SCHED_BATCH && nice <= 0) return finding;
  finding.state = FindingState::warning;
  finding.found = fmt::format("nice {}{}: on a busy machine a second may be delayed", nice,
                              policy == SCHED_IDLE    ? ", idle class"
                              : policy == SCHED_BATCH ? ", as a batch job"
                                                      : "");
  finding.fix = "start gyrotherm without nice, batch or chrt --idle";
  return finding;
}

// ---- installation

Finding check_program(const char* name, FindingState missing, const char* why) {
  const auto path = sibling_program_path(name);
  if (is_executable(path)) return {name, FindingState::ok, path, ""};
  return {name, missing, fmt::format("{} cannot be started: {}", path, why),
          "install the complete program: cmake --install, or the package gyrotherm", FaultKind::bad_file};
}

// ---- programs and settings that disturb serial adapters

constexpr const char* kInstallRules = "gyrotherm devices lists the command that installs its udev rules";
/// Adapters that brltty's rules claim, in the notation of these rules.
constexpr std::array<std::string_view, 4> kBrlttyAdapters{"403/6001", "10c4/ea60", "67b/2303", "1a86/7523"};

/// Returns the text of a system file without blanks at both ends, or an empty text if it cannot be read.
std::string read_system_file(const fs::path& file) {
  std::ifstream stream(file);
  std::string text;
  for (std::string line; std::getline(stream, line);) text += line + "\n";
  return std::string(trimmed(text, " \t\r\n"));
}

bool is_running(const std::string& program, const std::string& root) {
  return std::ranges::any_of(list_folder(root + "/proc"), [&](const auto& entry) {
    const auto name = entry.filename().string();
    return name.find_first_not_of("0123456789") == std::string::npos && read_system_file(entry / "comm") == program;
  });
}

std::string tty_name(const Device& device) { return fs::path(device.node.path).filename().string(); }

/// Returns whether a udev property keeps ModemManager away from the port.
bool is_ignored_by_modem_manager(const Device& device, const std::string& root) {
  const auto number = read_system_file(root + "/sys/class/tty/" + tty_name(device) + "/dev");
  const auto properties = "\n" + read_system_file(root + "/run/udev/data/c" + number) + "\n";
  return properties.find("\nE:ID_MM_DEVICE_IGNORE=1\n") != std::string::npos ||
         properties.find("\nE:ID_MM_PORT_IGNORE=1\n") != std::string::npos;
}

Finding check_modem_manager(const std::vector<Device>& adapters, const std::string& root) {
  constexpr const char* kName = "ModemManager";
  if (!is_running(kName, root)) return {kName, FindingState::ok, "is not active", ""};
  std::vector<std::string> probed;
  for (const auto& device : adapters)
    if (!is_ignored_by_modem_manager(device, root)) probed.push_back(device.node.path);
  if (probed.empty()) return {kName, FindingState::ok, "ignores the serial adapters", ""};
  return {kName, FindingState::warning,
          fmt::format("is active and sends AT commands to {} when it is plugged in", fmt::join(probed, ", ")),
          fmt::format("{}; or: sudo systemctl disable --now ModemManager", kInstallRules)};
}

/// Returns the first rules file of brltty that claims a common adapter, or an empty string.
std::string find_brltty_rules(const std::string& root) {
  for (const auto* folder : {"/etc/udev/rules.d", "/usr/lib/udev/rules.d", "/lib/udev/rules.d"})
    for (const auto& entry : list_folder(root + folder)) {
      if (entry.filename().string().find("brltty") == std::string::npos) continue;
      std::string rules = read_system_file(entry);
      for (std::size_t end; !rules.empty(); rules.erase(0, end)) {
        end = std::min(rules.find('\n'), rules.size() - 1) + 1;
        const auto line = std::string_view(rules).substr(0, end);
        if (!trimmed(line).starts_with('#') &&
            std::ranges::any_of(kBrlttyAdapters, [&](auto id) { return line.find(id) != std::string_view::npos; }))
          return entry.string().substr(root.size());
      }
    }
  return {};
}

Finding check_brltty(const std::string& root) {
  constexpr const char* kName = "brltty";
  constexpr const char* kFix = "without a braille display: sudo apt-get remove brltty";
  if (is_running(kName, root))
    return {kName, FindingState::warning, "is active and may claim serial adapters as braille displays", kFix};
  if (const auto rules = find_brltty_rules(root); !rules.empty())
    return {kName, FindingState::warning,
            fmt::format("claims common serial adapters as braille displays ({}), and their ports disappear", rules),
            kFix};
  return {kName, FindingState::ok, "claims no serial adapter", ""};
}

/// Returns the folder of a port's USB device in /sys, or an empty path.
fs::path usb_device(const Device& device, const std::string& root) {
  std::error_code error;
  auto folder = fs::canonical(root + "/sys/class/tty/" + tty_name(device) + "/device", error);
  while (!error && folder.has_relative_path() && folder != root) {
    if (fs::exists(folder / "idVendor", error)) return folder;
    folder = folder.parent_path();
  }
  return {};
}

std::vector<Finding> check_power(const std::vector<Device>& adapters, const std::string& root) {
  std::vector<Finding> findings;
  for (const auto& device : adapters) {
    const auto folder = usb_device(device, root);
    if (folder.empty() || read_system_file(folder / "power/control") != "auto") continue;
    findings.push_back(
        {"power of " + device.node.path, FindingState::warning,
         "USB autosuspend may switch the adapter off while its line is quiet",
         fmt::format("echo on | sudo tee {}/power/control; permanently: {}", folder.string(), kInstallRules)});
  }
  return findings;
}

}  // namespace

std::vector<Finding> check_installation() {
  std::vector<Finding> findings;
  const auto names = shipped_names(kShippedRig);
  if (names.empty())
    findings.push_back({"shipped files", FindingState::warning,
                        fmt::format("none found in {}", fmt::join(shipped_folders(), ", ")),
                        "install the complete program: cmake --install, or the package gyrotherm"});
  else
    findings.push_back({"shipped files", FindingState::ok, find_shipped_file(kShippedProfile.folder), ""});
  findings.push_back(check_program("gyrotherm-make-safe", FindingState::fault,
                                   "if a run dies, the chamber is not made safe; runs on a real rig therefore do "
                                   "not start"));
  findings.push_back(check_program("gyrotherm-pdf", FindingState::warning, "reports have no PDF"));
  return findings;
}

std::vector<Finding> check_disk(const std::string& folder) {
  struct statvfs space {};
  struct statfs kind {};
  if (::statvfs(folder.c_str(), &space) != 0 || ::statfs(folder.c_str(), &kind) != 0)
    return {{"disk", FindingState::fault, fmt::format("{}: {}", folder, std::generic_category().message(errno)),
             "mkdir -p " + quote_for_shell(folder), FaultKind::storage}};
  std::vector<Finding> findings;
  if (std::error_code error; !fs::is_directory(folder, error))
    findings.push_back({"folder", FindingState::fault, folder + " is not a folder", "name a folder: --folder FOLDER",
                        FaultKind::storage});
  else if (is_of_kernel(kind))
    findings.push_back({"folder", FindingState::fault,
                        folder + " is in a file system of the kernel, which has no files",
                        "record in a folder on a disk", FaultKind::storage});
  else if ((space.f_flag & ST_RDONLY) != 0)
    findings.push_back({"folder", FindingState::fault, folder + " is on a disk that is mounted read-only",
                        "record in another folder, or mount it with rw", FaultKind::storage});
  else if (::faccessat(AT_FDCWD, folder.c_str(), W_OK | X_OK, AT_EACCESS) != 0)
    findings.push_back(
        {"folder", FindingState::fault, fmt::format("{} is not writable by {}", folder, describe_user(::geteuid())),
         fmt::format("record in a folder of your own, or: sudo chown \"$USER\" {}", folder), FaultKind::storage});
  else
    findings.push_back({"folder", FindingState::ok, folder + " is writable", ""});
  findings.push_back(check_space(folder, space));
  findings.push_back(check_file_system(folder, kind));
  return findings;
}

Finding check_clock() {
  timex clock{};
  const int state = ::adjtimex(&clock);
  Finding finding{"clock", FindingState::ok, "", ""};
  if (state >= 0 && state != TIME_ERROR && (clock.status & STA_UNSYNC) == 0) {
    finding.found = fmt::format("synchronised with UTC to within {:.1f} ms", static_cast<double>(clock.maxerror) / 1e3);
    return finding;
  }
  finding.state = FindingState::warning;
  finding.found = "the clock is not synchronised: UTC times in records may be wrong, but durations are correct";
  finding.fix = "sudo timedatectl set-ntp true, or sudo apt-get install chrony";
  return finding;
}

std::vector<Finding> check_limits() {
  return {check_files(),
          check_unlimited("file size", RLIMIT_FSIZE, "bytes", "f", "a record would end at this size"),
          check_unlimited("processor time", RLIMIT_CPU, "s", "t", "a run would be killed after this time"),
          check_memory(),
          check_locked_memory(),
          check_priority()};
}

std::vector<Finding> check_serial_adapters(const std::vector<Device>& devices, const std::string& root) {
  std::vector<Device> adapters;
  std::ranges::copy_if(devices, std::back_inserter(adapters),
                       [](const auto& device) { return !device.is_hid && !device.usb.empty(); });
  std::vector<Finding> findings{check_modem_manager(adapters, root), check_brltty(root)};
  std::ranges::move(check_power(adapters, root), std::back_inserter(findings));
  return findings;
}

}  // namespace gyrotherm::app
