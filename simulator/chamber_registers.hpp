// SPDX-License-Identifier: Apache-2.0
/// The virtual chamber behind its register map: register contents, profile memory, and the program that it executes by
/// itself.
#pragma once

#include <algorithm>
#include <cassert>
#include <chrono>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <tl/expected.hpp>
#include <utility>
#include <vector>

#include "drivers/chamber/item_exchange.hpp"
#include "drivers/chamber/program.hpp"
#include "drivers/chamber/register_map.hpp"
#include "simulator/served_registers.hpp"
#include "simulator/virtual_laboratory.hpp"

namespace gyrotherm::simulator {

/// Behaviour of a virtual chamber that the items of its register map do not describe, read from the map's [simulated]
/// table: the writes that change its state, and the values that it shows in each state.
struct SimulatedUnit {
  struct ShownRegister {
    std::string item;
    /// Value in each state: "off", "on", "manual", "running" (or "ramping", "soaking"), "held", "done".
    std::map<std::string, double> values;
  };
  /// Writes with an effect. `holds_output` selects manual mode at full heating; `creates_program` empties the memory;
  /// `stores_program` and `loads_program` save and restore the edit window.
  std::vector<drivers::Condition> turns_on, turns_off;
  std::vector<drivers::Condition> holds_output;
  std::vector<drivers::Condition> starts_program, holds_program, resumes_program, ends_program;
  std::vector<drivers::Condition> creates_program;
  std::vector<drivers::Condition> stores_program, loads_program;
  /// Items that select the program and the step to start.
  std::string program_number, program_step;
  std::vector<ShownRegister> shows;
  std::vector<std::pair<std::string, double>> initial;
  std::vector<std::pair<std::string, std::string>> initial_texts;
  /// Does not reply where other units send an exception.
  bool silent_exceptions{};
  /// Acknowledges and ignores function 16 outside the profile memory.
  bool ignores_blocks_elsewhere{};
  /// Items of the limiter: its setting, and the command that resets it. They stand for the knob and the button of a
  /// chamber. `limiter_fault` breaks it (LimiterFault); `limiter_alarm` shows its trip. Empty: the map has none.
  std::string limiter_setting, limiter_reset, limiter_fault, limiter_alarm;
  /// Items that show their first sentinel value while the unit is off.
  std::vector<std::string> when_off;
};

/// Reads the [simulated] table from the map's text. `file` is the name used in faults. Fails with bad_file if the table
/// has errors.
[[nodiscard]] Result<SimulatedUnit> read_simulated_unit(const drivers::RegisterMap& map, const std::string& file);

/// Fails with bad_file if the virtual unit would have an identity that its own map refuses.
[[nodiscard]] Result<void> check_simulated_identity(const drivers::RegisterMap& map, const SimulatedUnit& unit,
                                                    const std::string& file);

/// Offset of coil addresses in an image. Modbus addresses coils and registers separately.
inline constexpr int kCoils = 0x10000;
[[nodiscard]] inline int image_address(const drivers::RegisterItem& item) {
  const bool coil =
      item.write_function == drivers::WriteFunction::coil || item.read_function == drivers::ReadFunction::coils;
  return item.address + (coil ? kCoils : 0);
}

class RegisterImage {
 public:
  /// Creates an image with the map's fingerprint and initial values and zeros elsewhere. `map` must outlive it.
  RegisterImage(const drivers::RegisterMap& map, const SimulatedUnit& unit);

  [[nodiscard]] std::uint16_t word(int address) const {
    const auto found = words_.find(address);
    return found == words_.end() ? std::uint16_t{0} : found->second;
  }

  void set_word(int address, std::uint16_t word) { words_[address] = word; }

  [[nodiscard]] std::vector<std::uint16_t> words(int address, int count) const {
    std::vector<std::uint16_t> all(static_cast<std::size_t>(count));
    for (int i = 0; i < count; ++i) all[static_cast<std::size_t>(i)] = word(address + i);
    return all;
  }

  /// Returns the value that the controller displays, scaled by the item's decimals and unit.
  [[nodiscard]] double value(const drivers::RegisterItem& item) const {
    auto form = item_in_context(item);
    form.write_scale.reset();
    return decode_as_written(form, words(image_address(item), word_count(item)));
  }

  void set_value(const drivers::RegisterItem& item, double value) {
    const auto words = words_at(item, value);
    for (std::size_t i = 0; i < words.size(); ++i) words_[image_address(item) + static_cast<int>(i)] = words[i];
  }

  [[nodiscard]] drivers::RegisterItem item_in_context(const drivers::RegisterItem& item) const {
    if (item.decimals.empty() && item.unit.empty()) return item;
    const auto context =
        read_context(map_, item, [&](const drivers::RegisterItem& other) -> Result<double> { return value(other); });
    return apply_context(item, context.value_or(drivers::ItemContext{}));
  }

  /// Returns the words of `item` at `value`. Keeps the other bits of a bit field.
  [[nodiscard]] std::vector<std::uint16_t> words_at(const drivers::RegisterItem& item, double value) const {
    // Avoids a copy of an item without context, because this runs every second.
    const bool has_no_context = item.decimals.empty() && item.unit.empty();
    auto words = has_no_context ? encode_as_read(item, value) : encode_as_read(item_in_context(item), value);
    if (item.type != drivers::RegisterType::bits) return words;
    words[0] = merge_bits(item, words[0], word(image_address(item)));
    return words;
  }

 private:
  const drivers::RegisterMap& map_;
  std::map<int, std::uint16_t> words_;
};

class MemoryImage {
 public:
  /// Creates an empty memory. `map` and `registers` must outlive it.
  MemoryImage(const drivers::RegisterMap& map, RegisterImage& registers);

  [[nodiscard]] bool contains(int address) const { return find_range(address) != nullptr; }

  [[nodiscard]] std::uint16_t word(int address) const {
    const auto* range = find_range(address);
    return range && range->windowed ? word_at({selected_step(), address}) : word_at({0, address});
  }

  void set_word(int address, std::uint16_t word) {
    const auto* range = find_range(address);
    window_[{range && range->windowed ? selected_step() : 0, address}] = word;
  }

  /// Empties, saves and restores the content of the edit window.
  void clear() { window_.clear(); }
  void store() { stored_ = window_; }
  void load() { window_ = stored_; }

  [[nodiscard]] Result<drivers::ChamberProgram> program(Celsius from) const {
    if (!map_.memory) return failure(FaultKind::refused, "profile memory", "this controller has none");
    const auto& memory = *map_.memory;
    const auto read_words = [&](const drivers::MemoryBlock& block, int step) -> Result<std::vector<std::uint16_t>> {
      const bool window = memory.stride == 0 && step >= 0;
      std::vector<std::uint16_t> words;
      const int first = block.address + std::max(step, 0) * memory.stride;
      for (int i = 0; i < block.count; ++i) words.push_back(word_at({window ? step : 0, first + i}));
      return words;
    };
    const auto read_value = [&](const drivers::RegisterItem& item) -> Result<double> { return registers_.value(item); };
    const auto context = [&](const drivers::RegisterItem& form) {
      return read_context(map_, form, read_value).value_or(drivers::ItemContext{});
    };
    return decode_program(memory, from, read_words, context);
  }

 private:
  struct Range {
    int first{}, last{};
    /// True if the range shows only the selected step.
    bool windowed{};
  };
  /// Step (0 outside a window) and address.
  using StepAddress = std::pair<int, int>;

  [[nodiscard]] const Range* find_range(int address) const {
    const auto found =
        std::ranges::find_if(ranges_, [&](const auto& r) { return address >= r.first && address <= r.last; });
    return found == ranges_.end() ? nullptr : &*found;
  }

  [[nodiscard]] int selected_step() const {
    return step_selector_ < 0 ? 0 : registers_.word(step_selector_) - map_.memory->first_step;
  }

  [[nodiscard]] std::uint16_t word_at(const StepAddress& cell) const {
    if (const auto found = window_.find(cell); found != window_.end()) return found->second;
    const auto fresh = fresh_.find(cell.second);
    return fresh == fresh_.end() ? registers_.word(cell.second) : fresh->second;
  }

  const drivers::RegisterMap& map_;
  RegisterImage& registers_;
  std::vector<Range> ranges_;
  std::map<StepAddress, std::uint16_t> window_, stored_;
  /// Address of the register that selects the step of a window.
  int step_selector_ = -1;
  /// Content of a step that was never written, by address: the code for the end of the program.
  std::map<int, std::uint16_t> fresh_;
};

class ProgramRun {
 public:
  enum class Stage { none, ramping, soaking, held, done };

  /// Starts at the 0-based step `first`. If the program does not have this step, the run is done immediately.
  void start(drivers::ChamberProgram program, int first) {
    program_ = std::move(program);
    enter(static_cast<std::size_t>(first < 0 ? 0 : first));
  }

  void hold() {
    if (is_running()) stage_ = Stage::held;
  }

  void resume() {
    if (stage_ == Stage::held)
      stage_ = program_.steps[step_].kind == drivers::StepKind::ramp ? Stage::ramping : Stage::soaking;
  }

  void end() { stage_ = Stage::none; }

  [[nodiscard]] Stage stage() const { return stage_; }
  [[nodiscard]] bool is_running() const { return stage_ == Stage::ramping || stage_ == Stage::soaking; }
  [[nodiscard]] int step() const { return static_cast<int>(step_); }

  /// Returns the set point for the second that begins now, and advances by one second. A guaranteed soak does not
  /// advance while the air is outside its band. Requires is_running().
  [[nodiscard]] Celsius next_set_point(Celsius air) {
    assert(is_running());
    while (is_running() && elapsed_ >= program_.steps[step_].duration) enter(step_ + 1);
    if (!is_running()) return program_.steps.back().target;
    const auto& step = program_.steps[step_];
    const double part = to_seconds(elapsed_) / to_seconds(step.duration);
    const auto set_point = step.start + (step.target - step.start) * part;
    const bool waits = step.guaranteed_soak && abs(air - step.target) > program_.soak_band;
    if (!waits) elapsed_ += std::chrono::seconds(1);
    return set_point;
  }

 private:
  void enter(std::size_t step) {
    step_ = step;
    elapsed_ = {};
    if (step_ >= program_.steps.size())
      stage_ = Stage::done;
    else
      stage_ = program_.steps[step_].kind == drivers::StepKind::ramp ? Stage::ramping : Stage::soaking;
  }

  drivers::ChamberProgram program_;
  std::size_t step_{};
  Duration elapsed_{};
  Stage stage_ = Stage::none;
};

/// Serves air_temperature, humidity, dew_point, set_point (and active_ or working_set_point), output and clocks from
/// the laboratory. The map's [simulated] table describes the writes that switch the chamber and start its program, and
/// the states that it shows. If no write switches the chamber on, it is always on. Any other item keeps the value that
/// was written to it.
class ChamberRegisters final : public ServedRegisters {
 public:
  /// Creates the registers. `laboratory` must outlive them. The map's [simulated] table must be valid. If `is_marked`,
  /// the chamber reports an identity that mark_identity() has changed.
  ChamberRegisters(drivers::RegisterMap map, VirtualLaboratory& laboratory, bool is_marked = false);
  ChamberRegisters(const ChamberRegisters&) = delete;  // live_ points into map_

  [[nodiscard]] const drivers::RegisterMap& map() const override { return map_; }
  [[nodiscard]] std::uint8_t unit() const { return map_.link.modbus.unit; }
  [[nodiscard]] bool is_silent_on_errors() const override { return unit_.silent_exceptions; }

  /// Reads registers. A hole inside a map's block reads 0.
  [[nodiscard]] tl::expected<void, ModbusException> read(drivers::ReadFunction function, std::uint16_t address,
                                                         std::uint16_t count,
                                                         std::vector<std::uint16_t>& words) const override;
  [[nodiscard]] tl::expected<void, ModbusException> write(drivers::WriteFunction function, std::uint16_t address,
                                                          std::span<const std::uint16_t> words) override;

  /// Advances the clock and a running program by one second and applies the program's set point. Call it before the
  /// laboratory's step.
  void advance_second();
  [[nodiscard]] const ProgramRun& program() const { return run_; }

 private:
  enum class Role { air, humidity, dew_point, set_point, output, mode, clock, shows, limiter_alarm, sentinel };
  struct LiveItem {
    const drivers::RegisterItem* item{};
    Role role{};
    const SimulatedUnit::ShownRegister* shows{};
  };
  struct Assignment {
    /// Null for a word of the profile memory.
    const drivers::RegisterItem* item{};
    int address{};
    std::vector<std::uint16_t> words;
    double value{};
  };

  void find_live_items();
  void find_addresses();
  [[nodiscard]] bool serves(int address) const;
  [[nodiscard]] std::vector<std::uint16_t> live_words(const LiveItem& live) const;
  [[nodiscard]] double shown_value(const SimulatedUnit::ShownRegister& shows) const;
  [[nodiscard]] tl::expected<Assignment, ModbusException> assignment(int address, std::span<const std::uint16_t> words,
                                                                     bool coil) const;
  [[nodiscard]] bool accepts(const drivers::RegisterItem& item, double value) const;
  void apply(const Assignment& assignment);
  void apply_effects(const drivers::RegisterItem& item, double value);
  void apply_to_limiter(const drivers::RegisterItem& item, double value);
  void start_program();

  drivers::RegisterMap map_;
  SimulatedUnit unit_;
  VirtualLaboratory& laboratory_;
  RegisterImage image_;
  MemoryImage memory_;
  ProgramRun run_;
  std::vector<LiveItem> live_;
  std::map<int, bool> served_;
  /// Range of addresses in which holes are readable; empty if they are not.
  int hole_begin_{}, hole_end_{};
  std::int64_t seconds_{};
};

}  // namespace gyrotherm::simulator
