// SPDX-License-Identifier: Apache-2.0
/// Files shipped with the program: profiles, rigs and maps. Users refer to them by name from any folder.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/result.hpp"

namespace gyrotherm {

/// A kind of shipped file: its folder in the program's data, and the noun for one file in messages.
struct ShippedKind {
  const char* folder;  ///< such as "profiles/rigs"
  const char* what;    ///< such as "rig"
};

inline constexpr ShippedKind kShippedProfile{"profiles", "profile"}, kShippedRig{"profiles/rigs", "rig"},
    kShippedImportMap{"profiles/imports", "column map"}, kShippedGyro{"profiles/gyros", "gyro file"},
    kShippedChamberMap{"profiles/chambers", "register map"},
    kShippedAnalogueMap{"profiles/analogue-inputs", "register map"},
    kShippedGyroStream{"profiles/gyro-streams", "gyro stream"},
    kShippedThermometer{"profiles/thermometers", "thermometer description"},
    kShippedSupply{"profiles/supplies", "supply description"};

/// Returns the folders that may contain the program's data, in search order. D is the folder of the running program:
/// D/../share/gyrotherm, D/share/gyrotherm (in a build tree), /usr/local/share/gyrotherm, /usr/share/gyrotherm.
[[nodiscard]] std::vector<std::string> shipped_folders();

/// Searches shipped_folders() for the file `path`, such as "profiles/rigs/virtual.toml". Returns the path of the first
/// match, relative to the working directory if the file lies in it, or an empty string.
[[nodiscard]] std::string find_shipped_file(const std::string& path);

/// Returns the names of the shipped files of a kind, sorted: "random" for profiles/random.toml.
[[nodiscard]] std::vector<std::string> shipped_names(const ShippedKind& kind);

/// Returns whether `given` is a path: it contains a / or ends in .toml. Otherwise it is the name of a shipped file.
[[nodiscard]] bool is_path(std::string_view given);

/// Returns the path that `given` refers to: itself if it is a path, otherwise the path of the shipped file of that
/// name. Fails with bad_file if there is none; the message lists the available names and the searched folders.
[[nodiscard]] Result<std::string> resolve_path(const std::string& given, const ShippedKind& kind);

}  // namespace gyrotherm
