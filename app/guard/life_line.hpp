/// The life line of a run on a real rig: as long as it hears from this program, nobody else makes the chamber safe. Its
/// other end is systemd, or else a guard of its own (gyrotherm-make-safe --guard).
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "app/conduct/notify_socket.hpp"
#include "app/guard/armed_file.hpp"
#include "core/result.hpp"

namespace gyrotherm {

class LifeLine {
 public:
  /// Writes the armed file, then has itself watched. Before the first command to the chamber. From now on this program
  /// does not stop for a terminal's Ctrl-Z, which would look like a hang. Fails with storage, or with bad_file if
  /// gyrotherm-make-safe is not beside this program.
  [[nodiscard]] static Result<std::unique_ptr<LifeLine>> tie(const Armed& armed);

  /// At the end of a tick, while everything that must live lives. A guard that has died is replaced. Never blocks.
  void beat();
  /// The run has ended in order and the chamber may be left as it is: the armed file goes. A program that
  /// ends without this leaves it to the watcher.
  void good_bye();

 private:
  explicit LifeLine(Armed armed) : armed_(std::move(armed)) {}
  [[nodiscard]] Result<void> start_guard();
  void send(char byte);
  void hang_up();

  Armed armed_;
  std::optional<NotifySocket> systemd_;
  std::optional<std::string> limit_;  ///< of silence, in µs, where systemd watches
  bool beating_ = false;
  int pipe_ = kNoDescriptor;  ///< closed by good_bye() or by the end of the program alone: its end is a reason to act
};

}  // namespace gyrotherm
