// SPDX-License-Identifier: Apache-2.0
/// The units under test that operators have dropped from a run. Their readings are ignored until an operator returns
/// them. The unit of an empty position is dropped for the whole run. Values; one thread.
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
  /// Takes the names of all units, in sample order, and those of the units whose positions are empty.
  explicit DroppedUnits(std::vector<std::string> names, std::vector<std::string> unused = {})
      : names_(std::move(names)), unused_(std::move(unused)), dropped_(names_.size()) {
    drop(unused_);
  }

  /// Returns the reason why a unit cannot be dropped or returned; empty if it can. The last remaining unit cannot be
  /// dropped: the command "stop" ends the run.
  [[nodiscard]] std::string refusal_reason(const control::UnitRequest& request) const;
  /// Carries out a request that has no objection.
  void carry_out(const control::UnitRequest& request);
  /// Restores the dropped units of a resumed run. Ignores unknown names.
  void drop(std::span<const std::string> names);

  /// Returns a flag for each unit: true if it is dropped.
  [[nodiscard]] const std::vector<bool>& all() const { return dropped_; }
  /// Removes the readings of dropped units from the sample, and their faults too.
  void clear_readings(Sample& sample) const;

 private:
  std::vector<std::string> names_, unused_;
  std::vector<bool> dropped_;
};

/// Returns the units that the record's run dropped and did not return.
[[nodiscard]] std::vector<std::string> find_dropped_units(const record::Record& record);

}  // namespace gyrotherm::run
