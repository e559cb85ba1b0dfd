// SPDX-License-Identifier: Apache-2.0
/// Locks that permit only one program at a time to drive a chamber. There are two locks. The operating system releases
/// both when the program that holds them ends, even if it crashes.
///
/// The first lock is a name in the abstract namespace of Unix sockets. It is visible to every program in the machine's
/// network namespace, regardless of user, folder and mount namespace; it cannot be removed, and the kernel reports its
/// holder. Any process can bind the name. Therefore the name counts as a lock only if its holder runs as a user who may
/// drive chambers (may_drive_chambers). If a process of another user holds the name, a program takes a random spare
/// name, "NAME#…"; every program checks the spare names too.
///
/// The second lock is a file in a folder that the user owns. It excludes programs of the same user in another network
/// namespace, and contains the path of the record.
///
/// Neither lock excludes programs on other machines. A run detects such a program when it changes the set point.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "core/file.hpp"
#include "core/result.hpp"
#include "drivers/line/line_address.hpp"

namespace gyrotherm::drivers {

/// Groups whose members may drive chambers: the package's own group, and the group that owns serial ports.
inline constexpr const char* kChamberGroups[] = {"gyrotherm", "dialout"};

/// Returns true for the current user, root, an unknown user (a negative number), and members of one of kChamberGroups
/// according to /etc/passwd and /etc/group. Directory services are not queried.
[[nodiscard]] bool may_drive_chambers(std::int64_t uid);

/// Returns the user who created the Unix socket with inode `inode` in this network namespace (sock_diag(7)), or nothing
/// if the kernel does not report the user (before Linux 5.3).
[[nodiscard]] std::optional<std::int64_t> find_socket_user(std::uint32_t inode);

/// Binds the name of a chamber, which is held while the returned descriptor is open. Fails with errno: EADDRINUSE if
/// another process holds the name.
[[nodiscard]] tl::expected<Descriptor, int> bind_chamber_name(const std::string& place);

/// Process that holds a name, as the kernel reports it. `pid` 0 and `uid` -1 mean unknown.
struct NameOwner {
  std::int64_t pid = 0;
  std::int64_t uid = -1;
};
/// Returns the holder of the name, or nothing if no process holds it.
[[nodiscard]] std::optional<NameOwner> find_name_owner(const std::string& place);

/// Returns an identifier of the chamber on a line, which does not depend on the notation of the line's address. In
/// "tcp-10.0.0.7-502-1" the last number is the unit number, because one address may serve several chambers.
/// "tcp-this.machine-502-1" stands for every address of this machine. "serial-dev-ttyUSB0" names the device to which a
/// link refers.
[[nodiscard]] std::string chamber_lock_name(const Line& line, std::uint16_t usual_port, std::uint8_t unit);

/// Process that holds a chamber. `pid` 0 and `uid` -1 mean unknown.
struct ChamberHolder {
  std::int64_t pid = 0;
  std::int64_t uid = -1;
  /// Text for messages: "process 19233 of ada (uid 1000), record /data/run.db".
  std::string words;
};

class ChamberLock {
 public:
  /// Takes the lock without waiting. `record` is the path of the record that this program writes, for the messages of
  /// programs that are refused. Fails with refused if another program holds the lock and its user may drive chambers;
  /// the message names the process and its user. Fails with storage if neither lock can be created. If two programs
  /// start while a process of a third user holds the name, both may be refused.
  [[nodiscard]] static Result<ChamberLock> take(const std::string& place, const std::string& record);
  /// Returns the program that holds the lock, or nothing if there is none whose user may drive chambers.
  [[nodiscard]] static std::optional<ChamberHolder> holder(const std::string& place);

  /// Processes that held the chamber's name when the lock was taken, although their users may not drive chambers.
  [[nodiscard]] const std::vector<ChamberHolder>& unauthorised_holders() const { return unauthorised_holders_; }

  /// Closes the connections of programs that queried the holder. Must be called from time to time, because a full queue
  /// would prevent other programs from querying.
  void close_callers() const;

 private:
  ChamberLock(Descriptor name, Descriptor file) : name_(std::move(name)), file_(std::move(file)) {}
  Descriptor name_, file_;
  std::vector<ChamberHolder> unauthorised_holders_;
};

}  // namespace gyrotherm::drivers
