// SPDX-License-Identifier: Apache-2.0
/// The proof tests of a rig: [prove], and the key `proof` of [policy].
#pragma once

#include <chrono>
#include <optional>
#include <string>

#include "core/quantity.hpp"
#include "core/toml_reader.hpp"

namespace gyrotherm::rig {

struct ProofSettings {
  /// A proof is due this long after the previous one; absent: no interval is stated.
  std::optional<Duration> every{};
  /// Folder of the protocols; relative paths start at the rig file.
  std::string folder = "proofs";
  /// Setting of the chamber's limiter during its test; absent: the test chooses it.
  std::optional<Celsius> limiter_at{};
  /// The set point of the test is this far above the setting.
  Kelvins limiter_over{10};
  /// Permitted difference between the setting and the air at which the limiter trips.
  Kelvins limiter_band{3};
  /// Longest time until the air reaches the setting.
  Duration limiter_within = std::chrono::minutes(30);
  /// Time for which the limiter must stay tripped without a reset.
  Duration limiter_hold = std::chrono::minutes(2);
  /// A run is refused while a proof is due or has failed.
  bool refuses_runs{};
};

/// Reads [prove] and [policy] proof. Records errors in the tables.
[[nodiscard]] ProofSettings read_proof_settings(const TomlTable& root);

}  // namespace gyrotherm::rig
