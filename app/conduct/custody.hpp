/// What a program takes on when it drives a real chamber: the chamber is its own, and it is watched. On a virtual rig
/// there is nothing to take on.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "app/guard/life_line.hpp"
#include "core/result.hpp"
#include "drivers/chamber/chamber_lock.hpp"
#include "rig/rig_file.hpp"

namespace gyrotherm {

class Custody {
 public:
  /// Takes the chamber's lock. Fails with refused if another program drives it.
  [[nodiscard]] static Result<Custody> take(const RigFile& rig, const std::string& record);

  /// The last thing before the chamber is moved for the first time: from now on somebody else makes it safe if this
  /// program dies or hangs. Fails like LifeLine::tie().
  [[nodiscard]] Result<void> arm();
  /// At the end of a tick. `busiest`: how long the longest call to an instrument that is under way has lasted; past its
  /// limit the watcher hears nothing.
  void beat(Duration busiest);
  /// The chamber may be left as it is. A program that ends without this leaves it to the watcher.
  void release();

 private:
  std::optional<Armed> armed_;  ///< of a real rig
  std::optional<ChamberLock> lock_;
  std::unique_ptr<LifeLine> life_line_;
};

/// The place of a real rig's chamber among the locks.
[[nodiscard]] std::string chamber_place(const RigFile& rig);

}  // namespace gyrotherm
