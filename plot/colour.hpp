/// The colours of every figure: told apart by colour-blind readers, and still apart when printed in grey.
#pragma once

#include <cstddef>
#include <string>

#include "plot/png.hpp"

namespace gyrotherm {

/// One colour of the palette of Okabe and Ito (2008), without its yellow, which is too faint for a line; repeats after
/// eight.
[[nodiscard]] std::string palette(std::size_t index);

namespace colour {
inline constexpr const char* kSetPoint = "#c8401b";
inline constexpr const char* kTemperature = "#0072b2";
inline constexpr const char* kBias = "#00855f";
inline constexpr const char* kRaw = "#9aa1a9";
inline constexpr const char* kThreePoint = "#d55e00";
inline constexpr const char* kMultiPoint = "#0072b2";
inline constexpr const char* kMultiPointT = "#00855f";
inline constexpr const char* kInk = "#1d2733";
inline constexpr const char* kFaintInk = "#5b6673";
inline constexpr const char* kGrid = "#e3e7ec";
inline constexpr const char* kFineGrid = "#f1f3f6";
inline constexpr const char* kFloor = "#f1e3b8";
inline constexpr const char* kSimulated = "#a8371b";
}  // namespace colour

/// A shade from near white (0) to deep blue (1), as "#rrggbb"; outside 0…1 the nearer end.
[[nodiscard]] std::string shade(double fraction);

/// From cold (0) to hot (1): blue, pale yellow, red, after ColorBrewer's RdYlBu; outside 0…1 the nearer end.
[[nodiscard]] Rgb heat(double fraction);

/// Whether white text reads better than dark text on shade(fraction).
[[nodiscard]] bool shade_is_dark(double fraction);

}  // namespace gyrotherm
