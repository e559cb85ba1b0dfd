// SPDX-License-Identifier: Apache-2.0
/// One program drives a chamber: two locks of the operating system, which end with the program that holds them, however
/// that ends.
///
/// The first is a name in the abstract space of unix sockets. Every program on the machine's network sees it, whatever
/// user, folder or mount namespace it has, it cannot be removed, and the kernel reports its holder. Any process can
/// bind it, so it counts only if its holder's user may drive chambers (may_hold_chambers). A program that finds it with
/// a stranger takes a drawn spare name, "NAME#…"; every program looks at the spares, too. The second is a lock file in
/// a folder of the user's own, for programs of one user in two network namespaces; it also names the record. What
/// neither excludes (other machines) the run finds by the chamber's foreign set point.
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

/// The groups whose members may drive chambers: the package's own, and the one that serial ports belong to.
inline constexpr const char* kChamberGroups[] = {"gyrotherm", "dialout"};

/// Returns true for this user, root, and members of one of kChamberGroups by /etc/passwd and /etc/group; directory
/// services are not asked. A user that is not known (below 0) counts as one who may.
[[nodiscard]] bool may_hold_chambers(std::int64_t uid);

/// Returns the user who made the unix socket of that inode in this network namespace, by sock_diag(7); nothing if the
/// kernel does not report it (before Linux 5.3).
[[nodiscard]] std::optional<std::int64_t> user_of_socket(std::uint32_t inode);

/// The name of that place, as long as the descriptor is open. Fails with errno, EADDRINUSE if another process has it.
[[nodiscard]] tl::expected<Descriptor, int> take_name(const std::string& place);

/// The process that has a name, by the kernel's word; zeros where it cannot be told.
struct NameOwner {
  std::int64_t pid = 0;
  std::int64_t uid = -1;
};
/// Returns nothing if no process has the name.
[[nodiscard]] std::optional<NameOwner> owner_of_name(const std::string& place);

/// The chamber at the end of a line, however the line is written: "tcp-10.0.0.7-502-1" (with the unit's number, for
/// several chambers may be behind one address), "tcp-this.machine-502-1" (of any address of this machine's own),
/// "serial-dev-ttyUSB0" (of the device that a link leads to).
[[nodiscard]] std::string chamber_place(const Line& line, std::uint16_t usual_port, std::uint8_t unit);

/// Who holds a chamber.
struct ChamberHolder {
  std::int64_t pid = 0;   ///< 0: it cannot be told
  std::int64_t uid = -1;  ///< −1: likewise
  std::string words;      ///< "process 19233 of ada (uid 1000), record /data/run.db"
};

class ChamberLock {
 public:
  /// Takes the lock at once. `record`: what is to be driven from here, for programs that are refused. Fails with
  /// refused if another program holds it whose user may drive chambers, and names that program and its user, or with
  /// storage if neither lock can be made. Two that start while a stranger has the name may both be refused.
  [[nodiscard]] static Result<ChamberLock> take(const std::string& place, const std::string& record);
  /// Returns nothing if no program of a user who may drive chambers holds it.
  [[nodiscard]] static std::optional<ChamberHolder> holder(const std::string& place);

  /// Processes that held the chamber's name when the lock was taken, and whose users may not drive chambers.
  [[nodiscard]] const std::vector<ChamberHolder>& strangers() const { return strangers_; }

  /// Lets those go who asked who holds it. Now and then: too many of them would keep others from being told.
  void dismiss_callers() const;

 private:
  ChamberLock(Descriptor name, Descriptor file) : name_(std::move(name)), file_(std::move(file)) {}
  Descriptor name_, file_;
  std::vector<ChamberHolder> strangers_;
};

}  // namespace gyrotherm::drivers
