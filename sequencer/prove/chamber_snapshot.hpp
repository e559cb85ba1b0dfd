// SPDX-License-Identifier: Apache-2.0
/// The writable registers of a chamber as they were found, word by word, and their restoration.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "core/result.hpp"
#include "core/sample.hpp"
#include "drivers/chamber/register_map.hpp"
#include "drivers/instruments.hpp"
#include "drivers/wires.hpp"
#include "sequencer/prove/proof.hpp"

namespace gyrotherm::prove {

class ChamberSnapshot {
 public:
  /// Reads the state of the chamber and every item that its map can read and write. Skips items that the unit does not
  /// have, and its clock. `map` must outlive the snapshot. Fails as Registers::read() and Chamber::inspect() do.
  [[nodiscard]] static Result<ChamberSnapshot> take(const drivers::RegisterMap& map, drivers::Registers& registers,
                                                    drivers::Chamber& chamber);

  [[nodiscard]] const ChamberState& state() const { return state_; }
  /// Returns the registers before and now. Fails as take() does.
  [[nodiscard]] Result<std::vector<ProofRegister>> compare(drivers::Registers& registers) const;
  /// Returns the chamber to the mode and the set point in which it was found, then writes every item that still
  /// differs. A chamber that was off is switched off first. Fails with mismatch if a register keeps another content.
  /// Does not restore what the chamber does not show: see describe_lost_state().
  [[nodiscard]] Result<void> restore(drivers::Registers& registers, drivers::Chamber& chamber) const;

  /// Describes what a test of this chamber changes for good, because the chamber did not show it; empty: nothing.
  /// `safe` is the set point that the tests leave.
  [[nodiscard]] std::string describe_lost_state(Celsius safe) const;

 private:
  using Words = std::vector<std::uint16_t>;
  explicit ChamberSnapshot(const drivers::RegisterMap& map) : map_(&map) {}
  [[nodiscard]] Result<Words> read(drivers::Registers& registers, const drivers::RegisterItem& item) const;

  const drivers::RegisterMap* map_;
  ChamberState state_{};
  std::map<std::string, Words> found_;
};

/// Returns why the proof tests must not command this chamber; empty if they may.
[[nodiscard]] std::string refusal_reason(const ChamberState& state);

}  // namespace gyrotherm::prove
