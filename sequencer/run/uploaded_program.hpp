/// A profile that the chamber's controller carries out by itself: what it is given, and whether it still does it.
#pragma once

#include <string>

#include "core/result.hpp"
#include "core/sample.hpp"
#include "drivers/chamber/program.hpp"
#include "sequencer/profile/profile.hpp"

namespace gyrotherm {

/// The profile, segment by segment, as a program. Its name is that of the profile, in capitals, letters and digits
/// alone. Fails with usage if its guaranteed soaks have different bands: a controller has one.
[[nodiscard]] Result<ChamberProgram> program_of(const Profile& profile);

/// Watches, second by second, that the controller carries its program out.
class ProgramWatch {
 public:
  /// `last`: the profile is in its last segment, where the controller may be ahead and have finished. Returns why the
  /// run cannot go on, or nothing. A controller that does not answer, or whose map names no states, is not judged.
  [[nodiscard]] std::string judge(const Reading<ChamberState>& chamber, bool last, Duration elapsed);

 private:
  Duration gone_{};
};

}  // namespace gyrotherm
