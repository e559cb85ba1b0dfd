// SPDX-License-Identifier: Apache-2.0
/// Files that come with the program: profiles, rigs, maps. People call them by name, from any folder.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/result.hpp"

namespace gyrotherm {

/// A folder of shipped files, below the program's data, and what one of them is called.
struct ShippedKind {
  const char* folder;  ///< "profiles/rigs"
  const char* what;    ///< "rig"
};

inline constexpr ShippedKind kShippedProfile{"profiles", "profile"}, kShippedRig{"profiles/rigs", "rig"},
    kShippedImportMap{"profiles/imports", "column map"}, kShippedGyro{"profiles/gyros", "gyro file"},
    kShippedChamberMap{"profiles/chambers", "register map"},
    kShippedAnalogueMap{"profiles/analogue-inputs", "register map"},
    kShippedGyroStream{"profiles/gyro-streams", "gyro stream"};

/// Where the program's data may lie, in the order in which it is looked for: ../share/gyrotherm of the folder that the
/// running program lies in, share/gyrotherm of that folder, as a build has it, /usr/local/share/gyrotherm and
/// /usr/share/gyrotherm.
[[nodiscard]] std::vector<std::string> shipped_folders();

/// The first file of that path below one of the folders, like "profiles/rigs/virtual.toml"; relative to the working
/// folder where it lies in it. Empty if there is none.
[[nodiscard]] std::string shipped_file(const std::string& path);

/// Names of the shipped files of a kind, in order of the alphabet: "random" for profiles/random.toml.
[[nodiscard]] std::vector<std::string> shipped_names(const ShippedKind& kind);

/// Whether what was given is the path of a file, not the name of a shipped one: it has a / or ends in .toml.
[[nodiscard]] bool is_path(std::string_view given);

/// The path of what was given: itself if it is a path, else that of the shipped file of this name. Fails with bad_file
/// if there is none, and says which there are and where was looked.
[[nodiscard]] Result<std::string> path_of(const std::string& given, const ShippedKind& kind);

}  // namespace gyrotherm
