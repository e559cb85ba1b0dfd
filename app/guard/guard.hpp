/// Watches the program that drives a chamber by the bytes that it sends, and tells when it is time to act.
#pragma once

#include "core/quantity.hpp"

namespace gyrotherm {

/// What the program sends. Anything else counts as kAlive.
inline constexpr char kPreparing = 'p';  ///< alive, and the next byte may take long
inline constexpr char kAlive = '.';      ///< a tick is done; the next byte is due in a second
inline constexpr char kGoodBye = 'q';    ///< ended in order; nothing is to be done

enum class WatchEnd { good_bye, closed, silent };

struct WatchLimits {
  Duration silence = std::chrono::seconds(8);
  Duration preparing = std::chrono::minutes(15);  ///< an upload of a long program
};

/// Reads from the descriptor until the watch has an end. Silence is counted in slices of a second: a machine that stood
/// still does not make a program late.
[[nodiscard]] WatchEnd watch(int descriptor, const WatchLimits& limits = {});

}  // namespace gyrotherm
