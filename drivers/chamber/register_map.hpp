// SPDX-License-Identifier: Apache-2.0
/// The register map of a Modbus chamber: a TOML file under profiles/chambers, used by the driver and, from the other
/// end of the wire, by the virtual chamber. docs/chamber-maps.md describes the format.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/quantity.hpp"
#include "core/result.hpp"
#include "core/sample.hpp"
#include "core/toml_reader.hpp"
#include "drivers/chamber/register_item.hpp"
#include "drivers/line/modbus.hpp"

namespace gyrotherm::drivers {

/// What an item must hold: one of some codes, one of some bits, or more than a number.
struct Condition {
  std::string item;
  std::vector<std::string> meanings;  ///< in words; empty: any
  std::vector<std::int64_t> codes;
  std::uint32_t bits{};  ///< any of them set
  bool not_these{};      ///< true if it holds none of the codes and bits
  std::optional<double> above;
};
/// `value`: as decode() gives it; finite.
[[nodiscard]] bool holds(const Condition& condition, double value);

/// What the chamber is doing if a condition holds; the first that does decides.
struct StateRule {
  ChamberActivity activity = ChamberActivity::unknown;
  Condition when;
};

struct AlarmRule {
  AlarmSeverity severity{};
  std::string text;  ///< empty: the names of the codes or bits
  Condition when;
};

/// One step of a command.
struct SequenceStep {
  enum class Kind { write, wait, pause };
  enum class Source { number, program, step, date };
  Kind kind{};
  std::string item;  ///< that is written or waited for
  Source source = Source::number;
  double value{};                    ///< written
  std::string date_of;               ///< item of type date_time that is read; `duration` later is written
  Condition until;                   ///< of a wait
  Duration duration{};               ///< of a pause, or the longest of a wait
  std::optional<Condition> only_if;  ///< the step is left out unless this holds
};
using Sequence = std::vector<SequenceStep>;

enum class StepKind { ramp, soak, end };

/// Where the value of a cell comes from.
enum class CellSource {
  name,             ///< of the program
  number,           ///< of the program
  step_count,       ///< the end step included, where there is one
  step,             ///< number of this one, from 1
  kind,             ///< of this one, by the codes of the cell
  start,            ///< set point at the beginning of this one, °C
  target,           ///< … at its end
  rate,             ///< K/min, magnitude
  hours,            ///< of the step's time
  minutes,          ///< … within the hour
  seconds,          ///< … within the minute
  total_seconds,    ///< the whole time
  guaranteed_soak,  ///< whether time counts only inside the band: codes "off" and "on"
  soak_band,        ///< K
  constant,         ///< of the cell
};

struct MemoryCell {
  std::uint16_t at{};  ///< register of its block
  CellSource source = CellSource::constant;
  double constant{};
  RegisterItem form;  ///< type, order, scale, codes
};

/// Registers that are written by one exchange.
struct MemoryBlock {
  std::uint16_t address{};  ///< on the wire; of the first step, in a block of steps
  std::uint16_t count{};
  std::optional<WriteFunction> function;
  std::vector<StepKind> kinds;  ///< written for steps of these alone; empty: for every step
  bool select{};                ///< chooses program or step: written before reading too, and not read itself
  bool read_back = true;        ///< the controller gives back what was written
  std::vector<MemoryCell> cells;
};

struct ProfileMemory {
  int steps_at_most{};
  int programs = 1;
  int first_program = 1;  ///< number of the first one
  int first_step = 1;
  std::uint16_t stride{};   ///< registers from one step to the next; 0: all steps in one window
  bool ramps_by_rate{};     ///< else by time
  bool end_step{};          ///< the last step says that there are no more
  Duration end_time{};      ///< that the end step is given
  Duration longest_step{};  ///< a longer one is written as several
  Duration finest{};        ///< times are multiples of it
  Duration pause{};         ///< between writes
  Duration recovery{};      ///< after a write that failed, before the whole is sent again
  std::string number_from;  ///< item that says which number the controller gave the program; empty: we choose
  std::vector<MemoryBlock> header, step, footer;
  Confidence confidence = Confidence::unverified;
};

enum class LinkKind { tcp, rtu, rtu_over_tcp };

struct MapLink {
  LinkKind kind{};
  ModbusLink modbus;
};

/// What a register holds if the instrument is the one that the map describes.
struct Fingerprint {
  std::string item;
  double value{};
  std::uint32_t mask = 0xFFFFFFFF;  ///< bits that count, of a whole number
  /// Pattern of a text, in place of the value: "*" stands for any characters or none, "?" for one, "[1-4]" and "[!A-C]"
  /// for one of those, or none of those.
  std::string pattern;
};

/// A setting of the instrument that changes what its registers mean.
struct VerifiedSetting {
  std::string item;
  /// In words: "the unit does not ramp set points by itself". Empty: it may have any value.
  std::string verifies;
  Condition when;       ///< for a number
  std::string pattern;  ///< for a text
};

/// Another configuration of the same make, which has a map of its own.
struct OtherMap {
  Fingerprint print;
  std::string map;   ///< "watlow_f4t_cascade"
  std::string what;  ///< in words: "it has cascade control"
};

/// Everything that identify() compares beside the fingerprint, and everything that no register shows.
struct Verification {
  std::string verifies;            ///< by the fingerprint, in words
  std::vector<std::string> shows;  ///< items such as a serial number
  std::vector<VerifiedSetting> settings;
  std::vector<OtherMap> other_maps;
  std::vector<std::string> not_verified;  ///< in words
};

/// How conditioning is commanded: a code written to one item, and seen to take effect in another (or the same).
struct ControlMode {
  std::string commanded;
  std::string active;
  std::int64_t on{};
  std::int64_t off{};
};

/// One way in which makers have wired what switches the chamber's power. The rig file names the one of its chamber.
struct PowerSwitch {
  std::string name;  ///< "event_1"
  Condition is_on;
  Sequence on, off;
};

/// What set points the controller takes: numbers, or the items that hold them.
struct SetPointLimits {
  std::optional<Celsius> lowest, highest;
  std::string lowest_item, highest_item;
  Duration every{};  ///< a set point no more often than this; 0: as often as the link allows
};

struct RegisterMap {
  std::string name;
  std::string vendor;
  std::vector<MapLink> links;  ///< at least one; the first is the usual one
  MapLink link;                ///< the one in use
  bool one_block{};    ///< air_temperature, set_point and the fingerprint may be read as one block, holes included
  bool holes{};        ///< any registers within the link's limit may be read as one block, holes included
  int status_every{};  ///< state and alarms are asked for at each n-th read; 0: never
  std::vector<RegisterItem> items;
  std::optional<Fingerprint> identity;
  Verification verification;
  std::optional<ControlMode> control;  ///< absent: the chamber conditions whenever it is powered
  std::vector<PowerSwitch> power_switches;
  std::map<std::string, Sequence> sequences;  ///< "start", "stop", "pause", "resume", "acknowledge", …
  std::vector<StateRule> states;
  std::vector<AlarmRule> alarms;
  SetPointLimits limits;
  std::optional<ProfileMemory> memory;
  std::string text;  ///< the file, as read

  [[nodiscard]] const RegisterItem* find(std::string_view item) const;
  [[nodiscard]] const MapLink* find(LinkKind kind) const;
};

/// Fails with bad_file, every mistake with its place. Required items: air_temperature, set_point (writable). Items that
/// identity, control, states, alarms and sequences name exist, and have the codes asked for.
/// `word_order`: the user's override for a unit that was set up differently.
[[nodiscard]] Result<RegisterMap> parse_register_map(std::string_view text, const std::string& file,
                                                     std::optional<WordOrder> word_order = {});

/// The map with its link of that kind in use: settings and addresses. Fails with usage if it describes no such link.
[[nodiscard]] Result<RegisterMap> on_link(RegisterMap map, LinkKind kind);
/// The map for a unit at the end of `line`: a serial line wants RTU, a TCP line Modbus TCP where the map has it and
/// otherwise RTU over TCP; a virtual line the map's first link. `framing`: the user's choice.
[[nodiscard]] Result<RegisterMap> on_line(RegisterMap map, const Line& line, std::optional<LinkKind> framing = {});

/// The map with the power switch of that name: "start" begins by switching it on, "stop" ends by switching it off, and
/// a chamber whose power is off is off. An empty name changes nothing. Fails with usage if the map has no such switch.
[[nodiscard]] Result<RegisterMap> with_power_switch(RegisterMap map, const std::string& name);

/// "tcp", "rtu", "rtu_over_tcp", as files say it.
[[nodiscard]] const char* name(LinkKind kind);
[[nodiscard]] const char* name(Confidence confidence);

inline constexpr auto kWordOrders = words_in_order<WordOrder::abcd, WordOrder::dcba>("abcd", "cdab", "badc", "dcba");
inline constexpr auto kLinkKinds = words_in_order<LinkKind::tcp, LinkKind::rtu_over_tcp>("tcp", "rtu", "rtu_over_tcp");
inline constexpr auto kReadFunctions = words_in_order<ReadFunction::coils, ReadFunction::input_registers>(
    "coils", "discrete_inputs", "holding_registers", "input_registers");
inline constexpr Vocabulary<WriteFunction, 3> kWriteFunctions{{{"coil", WriteFunction::coil},
                                                               {"one_register", WriteFunction::one_register},
                                                               {"registers", WriteFunction::registers}}};
inline constexpr auto kStepKinds = words_in_order<StepKind::ramp, StepKind::end>("ramp", "soak", "end");
inline constexpr auto kConfidences =
    words_in_order<Confidence::verified, Confidence::unverified>("verified", "manual", "secondary", "unverified");

// How sure a register map is of what the program uses of it. Pure.

struct Doubt {
  std::string item;
  Confidence confidence{};
  std::string note;
};

/// The items that reading, set points, commands, states, alarms, limits, the fingerprint and the profile memory use,
/// and that nobody has verified on the instrument; the least sure first.
[[nodiscard]] std::vector<Doubt> doubts(const RegisterMap& map);

/// A line for people: "3 registers in use verified, 5 from the manual, 1 from one source (…), 1 unverified: set_point
/// (…)".
[[nodiscard]] std::string confidence_in_words(const RegisterMap& map);

// How far from the set point that was sent a chamber may show it: one answer for a run's interlocks, for its safe
// sequence and for gyrotherm-make-safe.

/// What a controller may make of a set point: its register's resolution or, if that is more, what the map tolerates; a
/// tenth of a kelvin at least.
[[nodiscard]] Kelvins set_point_tolerance(const RegisterMap& map);

// Which word orders make sense of what a unit holds: a setting of some controllers that their manuals are not sure of.

struct OrderFinding {
  WordOrder order{};
  double air_c{}, set_point_c{};  ///< as this order reads them; NaN where it reads no number
  bool plausible{};               ///< both are numbers that a chamber can have, and neither is next to nothing
};

/// All four orders of the two items' words, the items' own first. Empty for items of one register: there is no order to
/// find. A value nearer to zero than 0.05 °C that is not zero is taken for the trace of a wrong order, unless no order
/// gives a larger one; below 10⁻⁴ °C always.
[[nodiscard]] std::vector<OrderFinding> probe_word_order(const RegisterItem& air,
                                                         std::span<const std::uint16_t> air_words,
                                                         const RegisterItem& set_point,
                                                         std::span<const std::uint16_t> set_point_words);

/// Returns true if the item's own order makes no sense of the words while another one does: the unit is set otherwise.
[[nodiscard]] bool contradicts_its_order(const std::vector<OrderFinding>& findings);

/// For people: "word order cdab fits (air 23.41 °C, set point 20.00 °C)", or what to change.
[[nodiscard]] std::string in_words(const std::vector<OrderFinding>& findings);

[[nodiscard]] const char* name(WordOrder order);

// Pieces of parse_register_map() for the readers of the map's [simulated] table and of other units' maps. Mistakes are
// noted in the table.

/// What the map of any Modbus unit has: name, vendor, source, [link], [[register]], [identity].
void read_unit(const TomlTable& file, std::optional<WordOrder> word_order, RegisterMap& map);

/// Reads [identity].
void read_identity(const TomlTable& table, RegisterMap& map);

/// The item that `key` names; nothing, and a mistake, if there is none.
[[nodiscard]] const RegisterItem* named_item(const RegisterMap& map, const TomlTable& table, const char* key,
                                             const std::string& name);
/// The first code of that meaning, a flag's bit as a mask.
[[nodiscard]] std::optional<double> code_of(const RegisterItem& item, const std::string& meaning);
/// { register, is | is_not | bits | above }
[[nodiscard]] Condition read_condition(const TomlTable& table, const RegisterMap& map);

}  // namespace gyrotherm::drivers
