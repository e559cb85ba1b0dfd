// SPDX-License-Identifier: Apache-2.0
/// The units under test that operators have dropped from a run: what comes from them counts for nothing until they are
/// returned to it. Values; one thread.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "acquisition/record/record.hpp"
#include "core/sample.hpp"
#include "sequencer/control/control_message.hpp"

namespace gyrotherm::run {

class DroppedUnits {
 public:
  /// The names of all units, in the order of the sample's.
  explicit DroppedUnits(std::vector<std::string> names) : names_(std::move(names)), dropped_(names_.size()) {}

  /// Why a unit is not dropped, or returned; empty: it can be. The last one that is left is not dropped: that ends the
  /// run, which has a word of its own.
  [[nodiscard]] std::string objection(const control::UnitRequest& request) const;
  /// There is no objection.
  void carry_out(const control::UnitRequest& request);
  /// Of a run that goes on; names that are no unit's are passed over.
  void drop(std::span<const std::string> names);

  /// Whether each is.
  [[nodiscard]] const std::vector<bool>& all() const { return dropped_; }
  /// Takes out of the sample what dropped units sent: no reading, and no fault either.
  void take_out(Sample& sample) const;

 private:
  std::vector<std::string> names_;
  std::vector<bool> dropped_;
};

/// Those that were dropped from a run, by its record, and not returned.
[[nodiscard]] std::vector<std::string> dropped_units_of(const record::Record& record);

}  // namespace gyrotherm::run
