// SPDX-License-Identifier: Apache-2.0
/// The virtual chamber as its register map shows it: the words of its registers, its profile memory, and the program
/// that it carries out by itself.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <tl/expected.hpp>
#include <utility>
#include <vector>

#include "drivers/chamber/program.hpp"
#include "drivers/chamber/register_map.hpp"
#include "simulator/virtual_laboratory.hpp"

namespace gyrotherm::simulator {

/// What a virtual chamber needs to know beside the items of its register map, from the map's [simulated] table: what
/// switches the unit on, and what it shows then.
struct SimulatedUnit {
  struct Shows {
    std::string item;
    std::map<std::string, double>
        values;  ///< by state: "off", "on", "running" (or "ramping", "soaking"), "held", "done"
  };
  std::vector<drivers::Condition> turns_on, turns_off;  ///< by writing this
  std::vector<drivers::Condition> starts_program, holds_program, resumes_program, ends_program;
  std::vector<drivers::Condition> creates_program;  ///< by writing this the memory is emptied
  std::vector<drivers::Condition> stores_program,
      loads_program;                         ///< by writing this the edit window is kept, or comes back
  std::string program_number, program_step;  ///< items that say which program and step is started
  std::vector<Shows> shows;
  std::vector<std::pair<std::string, double>> initial;
  std::vector<std::pair<std::string, std::string>> initial_texts;
  bool silent_exceptions{};           ///< no reply where others answer with an exception
  bool ignores_blocks_elsewhere{};    ///< function 16 outside the profile memory is acknowledged and does nothing
  std::vector<std::string> when_off;  ///< items that hold their first sentinel while the unit is off
};

/// Reads the table from the map's text, which `file` names in faults. Fails with bad_file if it has mistakes.
[[nodiscard]] Result<SimulatedUnit> read_simulated_unit(const drivers::RegisterMap& map, const std::string& file);

class RegisterImage {
 public:
  /// `map` outlives it. Holds the map's fingerprint and initial values, zeros otherwise.
  RegisterImage(const drivers::RegisterMap& map, const SimulatedUnit& unit);

  [[nodiscard]] std::uint16_t word(int address) const;
  void set_word(int address, std::uint16_t word) { words_[address] = word; }
  [[nodiscard]] std::vector<std::uint16_t> words(int address, int count) const;

  /// As the controller shows it, with its decimals and unit.
  [[nodiscard]] double value(const drivers::RegisterItem& item) const;
  void set_value(const drivers::RegisterItem& item, double value);
  [[nodiscard]] drivers::RegisterItem in_its_context(const drivers::RegisterItem& item) const;

  /// The words of `item` at `value`; of a bit field with the other bits as they are.
  [[nodiscard]] std::vector<std::uint16_t> words_at(const drivers::RegisterItem& item, double value) const;

 private:
  const drivers::RegisterMap& map_;
  std::map<int, std::uint16_t> words_;
};

/// Coils and registers have addresses of their own: those of coils are this much higher in an image.
inline constexpr int kCoils = 0x10000;
[[nodiscard]] int image_address(const drivers::RegisterItem& item);

class MemoryImage {
 public:
  /// Both outlive it.
  MemoryImage(const drivers::RegisterMap& map, RegisterImage& registers);

  [[nodiscard]] bool holds(int address) const;
  [[nodiscard]] std::uint16_t word(int address) const;
  void set_word(int address, std::uint16_t word);

  /// The edit window's content is kept, or comes back.
  void clear() { window_.clear(); }
  void store() { stored_ = window_; }
  void load() { window_ = stored_; }

  [[nodiscard]] Result<drivers::ChamberProgram> program(Celsius from) const;

 private:
  struct Range {
    int first{}, last{};
    bool windowed{};  ///< shows the step that is selected
  };
  using Place = std::pair<int, int>;  ///< step (of a window; else 0), address

  [[nodiscard]] const Range* range_of(int address) const;
  [[nodiscard]] int selected_step() const;
  [[nodiscard]] std::uint16_t word_at(const Place& place) const;

  const drivers::RegisterMap& map_;
  RegisterImage& registers_;
  std::vector<Range> ranges_;
  std::map<Place, std::uint16_t> window_, stored_;
  int step_selector_ = -1;              ///< address of the register that chooses the step of a window
  std::map<int, std::uint16_t> fresh_;  ///< what a step that was never written shows, by address: that it is the end
};

class ProgramRun {
 public:
  enum class Stage { none, ramping, soaking, held, done };

  /// From the step `first` (from 0) on; a program without it is done at once.
  void start(drivers::ChamberProgram program, int first);
  void hold();
  void resume();
  void end() { stage_ = Stage::none; }

  [[nodiscard]] Stage stage() const { return stage_; }
  [[nodiscard]] bool runs() const { return stage_ == Stage::ramping || stage_ == Stage::soaking; }
  [[nodiscard]] int step() const { return static_cast<int>(step_); }  ///< from 0

  /// The set point of the second that begins now; only while it runs. Then that second is over, unless a guaranteed
  /// soak waits for the air.
  [[nodiscard]] Celsius next_set_point(Celsius air);

 private:
  void enter(std::size_t step);

  drivers::ChamberProgram program_;
  std::size_t step_{};
  Duration elapsed_{};
  Stage stage_ = Stage::none;
};

/// Codes of a Modbus exception reply (Modbus Application Protocol V1.1b3, section 7).
enum class ModbusException : std::uint8_t { illegal_function = 1, illegal_address = 2, illegal_value = 3 };

/// Serves air_temperature, set_point (and active_ or working_set_point), output and clocks from the world; what
/// switches the chamber on, starts its program and shows its state is for the map's [simulated] table to say. A map in
/// which nothing switches it on describes a chamber that is on. Any other item keeps what is written to it.
class ChamberRegisters {
 public:
  /// `laboratory` must outlive this. The map's [simulated] table has been found to be good.
  ChamberRegisters(drivers::RegisterMap map, VirtualLaboratory& laboratory);
  ChamberRegisters(const ChamberRegisters&) = delete;  // live_ points into map_

  [[nodiscard]] const drivers::RegisterMap& map() const { return map_; }
  [[nodiscard]] std::uint8_t unit() const { return map_.link.modbus.unit; }
  [[nodiscard]] bool is_silent_when_wrong() const { return unit_.silent_exceptions; }

  /// Appends `count` words to `words`. Fails with illegal_value if the map reads fewer at once, or illegal_address at a
  /// register that is none of the map's (inside a map's one block such a hole reads 0).
  [[nodiscard]] tl::expected<void, ModbusException> read(drivers::ReadFunction function, std::uint16_t address,
                                                         std::uint16_t count, std::vector<std::uint16_t>& words) const;
  /// All or nothing. Fails with illegal_address at a register that is not writable or belongs to an item written in
  /// part, or illegal_value if the controller does not accept what is written.
  [[nodiscard]] tl::expected<void, ModbusException> write(drivers::WriteFunction function, std::uint16_t address,
                                                          std::span<const std::uint16_t> words);

  /// The second that begins: a program that runs has its set point in it. To be called before the world's step.
  void pass_second();
  [[nodiscard]] const ProgramRun& program() const { return run_; }

 private:
  enum class Role { air, set_point, output, mode, clock, shows, sentinel };
  struct Live {
    const drivers::RegisterItem* item{};
    Role role{};
    const SimulatedUnit::Shows* shows{};
  };
  struct Assignment {
    const drivers::RegisterItem* item{};  ///< nothing: a word of the profile memory
    int address{};
    std::vector<std::uint16_t> words;
    double value{};
  };

  void find_live_items();
  void find_addresses();
  [[nodiscard]] bool serves(int address) const;
  [[nodiscard]] std::vector<std::uint16_t> live_words(const Live& live) const;
  [[nodiscard]] double shown(const SimulatedUnit::Shows& shows) const;
  [[nodiscard]] tl::expected<Assignment, ModbusException> assignment(int address, std::span<const std::uint16_t> words,
                                                                     bool coil) const;
  [[nodiscard]] bool accepts(const drivers::RegisterItem& item, double value) const;
  void apply(const Assignment& assignment);
  void take_effect(const drivers::RegisterItem& item, double value);
  void start_program();

  drivers::RegisterMap map_;
  SimulatedUnit unit_;
  VirtualLaboratory& laboratory_;
  RegisterImage image_;
  MemoryImage memory_;
  ProgramRun run_;
  std::vector<Live> live_;
  std::map<int, bool> served_;     ///< addresses of items
  int hole_begin_{}, hole_end_{};  ///< of the map's one block, or of all that it has; empty if it has no holes
  std::int64_t seconds_{};
};

}  // namespace gyrotherm::simulator
