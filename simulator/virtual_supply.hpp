// SPDX-License-Identifier: Apache-2.0
/// A virtual laboratory power supply, which answers the lines of its description and feeds units of the virtual
/// laboratory.
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "core/result.hpp"
#include "drivers/supply/supply_description.hpp"
#include "simulator/virtual_laboratory.hpp"

namespace gyrotherm::simulator {

/// An output that is wired to units.
struct WiredOutput {
  drivers::OutputSettings settings;
  /// Names of the units that it feeds.
  std::vector<std::string> units;
};

struct VirtualSupplyOptions {
  drivers::SupplyDescription description;
  std::vector<WiredOutput> outputs;
};

/// The supply starts with its wired outputs on and with their settings, because a virtual laboratory starts with its
/// units on. Each output is a voltage source with a current limit on the loads of its units. An output whose protection
/// trips is switched off until it is switched on again after the trip was cleared. A unit has power while all outputs
/// that feed it are on.
class VirtualSupply {
 public:
  /// Fails with usage if the laboratory does not have a named unit, or the supply a wired output.
  [[nodiscard]] static Result<VirtualSupply> make(VirtualSupplyOptions options, const VirtualLaboratory& laboratory);

  [[nodiscard]] const drivers::SupplyDescription& description() const { return description_; }
  [[nodiscard]] std::size_t wired_outputs() const { return wired_.size(); }
  /// Connects the outputs. `number` is the index of the supply. Call it after the laboratory has been moved.
  void connect(VirtualLaboratory& laboratory, std::size_t number);
  /// Returns the answer to a line without its terminator, or nothing.
  [[nodiscard]] std::optional<std::string> answer(const std::string& line);
  /// Ignores all commands, as a supply whose panel is locked; questions are answered.
  void ignore_commands(bool ignored) { ignores_commands_ = ignored; }
  /// Evaluates the protections. Call it after each second of the laboratory.
  void advance_second();
  /// Switches the wired output with this index, without a protection, as in a recorded second.
  void replay(std::size_t wired, bool on);

 private:
  struct Output {
    /// Settings by the name of their item.
    std::map<std::string, double> values{};
    bool is_on = false;
    /// The output trips at its current limit.
    bool trips_at_limit = false;
    std::set<std::string> trips{};
    std::vector<std::size_t> units{};
  };
  struct Measurement {
    double voltage_v{}, current_a{};
    bool is_limited = false;
  };

  VirtualSupply() = default;
  [[nodiscard]] Measurement measure(const Output& output) const;
  void protect(std::size_t index);
  void apply(std::size_t index);
  [[nodiscard]] bool carry_out(std::size_t index, const std::string& name, const drivers::SupplyItem& item,
                               const drivers::FieldValues& fields);
  [[nodiscard]] std::string answer_question(std::size_t index, std::size_t question) const;
  [[nodiscard]] drivers::FieldValue value_of(std::size_t index, const std::string& name,
                                             const drivers::SupplyItem& item) const;

  drivers::SupplyDescription description_;
  /// One per output of the instrument.
  std::vector<Output> outputs_;
  /// Indices of the wired outputs.
  std::vector<std::size_t> wired_;
  VirtualLaboratory* laboratory_ = nullptr;
  std::size_t number_ = 0;
  bool ignores_commands_ = false;
};

}  // namespace gyrotherm::simulator
