/// Laws that hold also in release builds.
#pragma once

namespace gyrotherm {

/// Ends the process with SIGABRT, the law's name on stderr, if `holds` is false: a program that breaks a law of safety
/// must not go on commanding. What watches over the process makes the chamber safe.
void ensure(bool holds, const char* law);

}  // namespace gyrotherm
