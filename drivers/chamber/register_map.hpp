// SPDX-License-Identifier: Apache-2.0
/// The register map of a Modbus chamber, a TOML file under profiles/chambers, used by the driver and by the virtual
/// chamber. docs/chamber-maps.md describes the format.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
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
#include "drivers/chamber/text_link.hpp"
#include "drivers/line/link_settings.hpp"
#include "drivers/line/modbus.hpp"

namespace gyrotherm::drivers {

/// A condition on the value of an item: it is one of `codes`, it has one of `bits`, or it is above a number.
struct Condition {
  std::string item;
  std::vector<std::string> meanings;  ///< for messages
  std::vector<std::int64_t> codes;
  std::uint32_t bits{};  ///< any of them set
  /// Inverts the condition.
  bool not_these{};
  std::optional<double> above;
};
/// Returns whether `value`, a finite result of decode(), satisfies the condition. A value without lower_bits() has none
/// of the bits.
[[nodiscard]] bool holds(const Condition& condition, double value);
/// Returns whether a value that was read from `item` satisfies the condition. Fails with corrupted if the condition is
/// on bits and the value has no lower_bits().
[[nodiscard]] Result<bool> evaluate(const Condition& condition, const RegisterItem& item, double value);

/// Activity of the chamber while a condition is satisfied. The first rule with a satisfied condition applies.
struct StateRule {
  ChamberActivity activity = ChamberActivity::unknown;
  Condition when;
};

struct AlarmRule {
  AlarmSeverity severity{};
  std::string text;  ///< default: names of codes or bits
  Condition when;
};

/// One step of a command.
struct SequenceStep {
  enum class Kind { write, wait, pause };
  enum class Source { number, program, step, date };
  Kind kind{};
  /// Item that is written or waited for.
  std::string item;
  Source source = Source::number;
  double value{};
  /// Item of type date_time; its value plus `duration` is written to `item`.
  std::string date_of;
  Condition until;
  /// Length of a pause, or time limit of a wait.
  Duration duration{};
  /// The step is skipped unless this condition is satisfied.
  std::optional<Condition> only_if;
};
using Sequence = std::vector<SequenceStep>;

enum class StepKind { ramp, soak, end };

/// Source of a cell's value. `start` to `total_seconds` belong to the step.
enum class CellSource {
  name,
  number,
  /// Number of steps, including the end step if there is one.
  step_count,
  /// Number of the step, starting with first_step.
  step,
  /// Kind of the step, encoded by the codes of the cell.
  kind,
  /// Set points at the start and the end of the step, °C.
  start,
  target,
  /// Magnitude of the rate, K/min.
  rate,
  /// The duration, split into hours, minutes and seconds, or as a total number of seconds.
  hours,
  minutes,
  seconds,
  total_seconds,
  /// Codes "off" and "on".
  guaranteed_soak,
  /// Soak band, K.
  soak_band,
  /// MemoryCell::constant.
  constant,
};

struct MemoryCell {
  std::uint16_t at{};  ///< register within the block
  CellSource source = CellSource::constant;
  double constant{};
  RegisterItem form;  ///< type, order, scale, codes
};

/// Registers written in one exchange.
struct MemoryBlock {
  /// Address on the wire; in a block of steps, the address for the first step.
  std::uint16_t address{};
  std::uint16_t count{};
  std::optional<WriteFunction> function;
  /// The block is written only for steps of these kinds; for every step if empty.
  std::vector<StepKind> kinds;
  /// The block selects a program or step: it is also written before other blocks are read, and is not read itself.
  bool select{};
  /// The written registers can be read back.
  bool read_back = true;
  std::vector<MemoryCell> cells;
};

struct ProfileMemory {
  int steps_at_most{};
  int programs = 1;
  int first_program = 1;
  int first_step = 1;
  /// Number of registers from one step to the next; 0 if all steps use the same registers.
  std::uint16_t stride{};
  /// Ramps are stored as rates instead of durations.
  bool ramps_by_rate{};
  /// An end step follows the last step.
  bool end_step{};
  Duration end_time{};  ///< duration of the end step
  /// Maximum duration of a step. Longer steps are split.
  Duration longest_step{};
  /// Resolution of durations.
  Duration finest{};
  Duration pause{};  ///< between writes
  /// Pause between a failed write and the repetition of the whole upload; 0 for no repetition.
  Duration recovery{};
  /// Item that contains the program number assigned by the controller. If empty, the driver chooses the number.
  std::string number_from;
  std::vector<MemoryBlock> header, step, footer;
  Confidence confidence = Confidence::unverified;
};

/// Modbus links, and links of text units. A text unit with a serial link may also be behind a TCP device server.
enum class LinkKind { tcp, rtu, rtu_over_tcp, text_tcp, text_serial };
[[nodiscard]] inline bool is_text(LinkKind kind) { return kind >= LinkKind::text_tcp; }

struct MapLink {
  LinkKind kind{};
  /// Of a text unit only port, serial format, timeout and unit number are used.
  ModbusLink modbus;
  TextWire text{};
};

/// Expected content of a register of the described instrument.
struct Fingerprint {
  std::string item;
  double value{};
  /// Bits of an integer that are compared.
  std::uint32_t mask = 0xFFFFFFFF;
  /// Pattern of a text, as in matches(), in place of the value.
  std::string pattern;
  /// The pattern is a regular expression (ECMAScript) that is searched for in the text.
  bool is_expression = false;
};

/// A setting of the instrument that changes the meaning of its registers.
struct VerifiedSetting {
  std::string item;
  /// Description, such as "the unit does not ramp set points by itself". If empty, any value is accepted.
  std::string verifies;
  /// Required value, if the item is a number.
  Condition when;
  /// Required pattern, if the item is a text.
  std::string pattern;
};

/// Another configuration of the same product, which has its own map.
struct OtherMap {
  Fingerprint print;
  std::string map;  ///< such as "watlow_f4t_cascade"
  /// Description, such as "it has cascade control".
  std::string what;
};

/// Identity checks in addition to the fingerprint, and properties that cannot be verified.
struct Verification {
  /// Description of the property that the fingerprint verifies.
  std::string verifies;
  /// Items such as a serial number.
  std::vector<std::string> shows;
  std::vector<VerifiedSetting> settings;
  std::vector<OtherMap> other_maps;
  std::vector<std::string> not_verified;
};

/// Items and codes that switch temperature control. A code is written to `commanded`; `active`, which may be the same
/// item, shows the effect.
struct ControlMode {
  std::string commanded;
  std::string active;
  std::int64_t on{};
  std::int64_t off{};
};

/// An output that may be wired to switch the chamber's power. The rig file names the output that its chamber uses.
struct PowerSwitch {
  std::string name;  ///< such as "event_1"
  Condition is_on;
  Sequence on, off;
};

/// Limits of the set points that the controller accepts: as numbers, or as the items that contain the numbers.
struct SetPointLimits {
  std::optional<Celsius> lowest, highest;
  std::string lowest_item, highest_item;
  /// Minimum time between two set points; 0 for no minimum.
  Duration every{};
  /// Write endurance of the memory in which the controller stores each set point; 0 if it does not store them, or if
  /// this is unknown.
  std::int64_t nonvolatile{};
};

struct RegisterMap {
  std::string name;
  std::string vendor;
  /// Links of the unit, at least one; the first is the usual one.
  std::vector<MapLink> links;
  MapLink link;  ///< the selected link
  /// The air temperature, the set point and the fingerprint may be read as one block, with the registers in between.
  bool one_block{};
  /// Any registers may be read as one block with the registers in between, up to the limit of the link.
  bool holes{};
  /// State and alarms are read at every n-th reading of the chamber; 0 for never, if the map has none.
  int status_every{};
  std::vector<RegisterItem> items;
  /// Protocol of a text unit; null for a Modbus unit.
  std::shared_ptr<const TextLink> text_link;
  /// Parameters of a text unit, as in effect.
  TextParameters parameters;
  std::optional<Fingerprint> identity;
  Verification verification;
  /// If empty, temperature control is active whenever the chamber is powered.
  std::optional<ControlMode> control;
  std::vector<PowerSwitch> power_switches;
  /// Keyed by command: "start", "stop", "pause", "resume", "acknowledge", …
  std::map<std::string, Sequence> sequences;
  std::vector<StateRule> states;
  std::vector<AlarmRule> alarms;
  SetPointLimits limits;
  /// The items "humidity" and "dew_point" are read, as far as the map has them.
  bool reads_humidity{};
  std::optional<ProfileMemory> memory;
  /// Text of the file.
  std::string text;

  [[nodiscard]] const RegisterItem* find(std::string_view item) const;
  [[nodiscard]] const MapLink* find(LinkKind kind) const;
};

/// Parses a map of a Modbus unit (schema gyrotherm-chamber/1) or of a text unit (gyrotherm-text/1). Fails with bad_file
/// and lists every error with its position. The items air_temperature and set_point (writable) are required. Items
/// named in identity, control, states, alarms and sequences must exist and have the codes that are used. `word_order`
/// overrides the map's order, for a unit with a different setting; `parameters` override those of a text unit.
[[nodiscard]] Result<RegisterMap> parse_register_map(std::string_view text, const std::string& file,
                                                     std::optional<WordOrder> word_order = {},
                                                     const TextParameters& parameters = {});

/// Returns the map with the link of that kind selected, including its settings and addresses. Fails with usage if the
/// map has no such link.
[[nodiscard]] Result<RegisterMap> select_link(RegisterMap map, LinkKind kind);
/// Returns the map for a unit at the end of `line`. A serial line uses RTU; a TCP line uses Modbus TCP if the map has
/// it, and otherwise RTU over TCP; a virtual line uses the map's first link. `framing` overrides the choice.
[[nodiscard]] Result<RegisterMap> select_link_for(RegisterMap map, const Line& line,
                                                  std::optional<LinkKind> framing = {});

/// Returns the map with the power switch of that name. "start" then begins with switching the power on, "stop" ends
/// with switching it off, and a chamber without power is in state off. An empty name changes nothing. Fails with usage
/// if the map has no such switch.
[[nodiscard]] Result<RegisterMap> select_power_switch(RegisterMap map, const std::string& name);

/// Fails with usage if the unit has no parameter of a name in `parameters`; `where` is the name.
[[nodiscard]] Result<void> check_parameters(const RegisterMap& map, const TextParameters& parameters);

/// Returns the map of a unit that measures humidity: its items "humidity", in percent, and "dew_point", in °C, are then
/// read. Fails with usage if the map has neither.
[[nodiscard]] Result<RegisterMap> select_humidity(RegisterMap map);

/// Returns the map with an installation's settings applied to the selected link. Fails with usage if the link does not
/// have such a setting, or if an item needs more registers than one exchange may read with these settings. `where` of
/// the fault is the key of the setting.
[[nodiscard]] Result<RegisterMap> apply_settings(RegisterMap map, const LinkSettings& settings);

/// Returns the keyword of map files.
[[nodiscard]] const char* name(LinkKind kind);
[[nodiscard]] const char* name(Confidence confidence);

inline constexpr auto kWordOrders = make_vocabulary<WordOrder::abcd, WordOrder::dcba>("abcd", "cdab", "badc", "dcba");
inline constexpr auto kLinkKinds =
    make_vocabulary<LinkKind::tcp, LinkKind::text_serial>("tcp", "rtu", "rtu_over_tcp", "text_tcp", "text_serial");
inline constexpr auto kReadFunctions = make_vocabulary<ReadFunction::coils, ReadFunction::input_registers>(
    "coils", "discrete_inputs", "holding_registers", "input_registers");
inline constexpr Vocabulary<WriteFunction, 3> kWriteFunctions{{{"coil", WriteFunction::coil},
                                                               {"one_register", WriteFunction::one_register},
                                                               {"registers", WriteFunction::registers}}};
inline constexpr auto kCellSources = make_vocabulary<CellSource::name, CellSource::constant>(
    "name", "number", "step_count", "step", "kind", "start", "target", "rate", "hours", "minutes", "seconds",
    "total_seconds", "guaranteed_soak", "soak_band", "constant");
inline constexpr auto kStepKinds = make_vocabulary<StepKind::ramp, StepKind::end>("ramp", "soak", "end");
inline constexpr auto kConfidences =
    make_vocabulary<Confidence::verified, Confidence::unverified>("verified", "manual", "secondary", "unverified");

/// A register whose description was not verified on the instrument.
struct Doubt {
  std::string item;
  Confidence confidence{};
  std::string note;
};

/// Returns the unverified items that are in use, least certain first. Items are in use if reading, set points,
/// commands, states, alarms, limits, the fingerprint or the profile memory need them.
[[nodiscard]] std::vector<Doubt> list_doubts(const RegisterMap& map);

/// Returns a line of text: "3 registers in use verified, 5 from the manual, 1 from one source (…), 1 unverified:
/// set_point (…)".
[[nodiscard]] std::string describe_confidence(const RegisterMap& map);

/// Returns the tolerance between a sent set point and the one that the chamber shows: the resolution of the register or
/// the tolerance in the map, whichever is larger, and at least 0.1 K. The interlocks, the safe sequence and
/// gyrotherm-make-safe all use this value.
[[nodiscard]] Kelvins set_point_tolerance(const RegisterMap& map);

/// Values of a unit in one word order. In some controllers the word order is a setting that the manual does not specify
/// reliably.
struct OrderFinding {
  WordOrder order{};
  /// Values in this order; NaN for bytes that are not a number.
  double air_c{}, set_point_c{};
  /// Both values are possible in a chamber, and each is either zero or not close to zero.
  bool plausible{};
};

/// Decodes two items in all four word orders, starting with the order of the map. Returns nothing if an item has only
/// one register. A non-zero value below 0.05 °C is considered the result of a wrong order, unless no order gives a
/// larger value. A non-zero value below 10⁻⁴ °C is always considered wrong.
[[nodiscard]] std::vector<OrderFinding> probe_word_order(const RegisterItem& air,
                                                         std::span<const std::uint16_t> air_words,
                                                         const RegisterItem& set_point,
                                                         std::span<const std::uint16_t> set_point_words);

/// Returns whether the values are plausible in another order but not in the map's, because the unit has a different
/// setting.
[[nodiscard]] bool has_wrong_word_order(const std::vector<OrderFinding>& findings);

/// Returns the result as text: "word order cdab fits (air 23.41 °C, set point 20.00 °C)", or the change to make.
[[nodiscard]] std::string describe(const std::vector<OrderFinding>& findings);

[[nodiscard]] const char* name(WordOrder order);

// Parts of parse_register_map(), also used by the readers of the map's [simulated] table and of maps for other
// instruments. They note errors in the table.

/// Reads the keys that every Modbus unit has: name, vendor, source, [link], [[register]], [identity].
void read_unit(const TomlTable& file, std::optional<WordOrder> word_order, RegisterMap& map);

/// Reads [identity].
void read_identity(const TomlTable& table, RegisterMap& map);
/// Reads the keys of [identity] that do not describe the fingerprint.
void read_verification(const TomlTable& table, RegisterMap& map);
/// Returns the key that names an item in a condition or step: "item" in the file of a text unit, otherwise "register".
[[nodiscard]] inline const char* item_key(const TomlTable& table) { return table.has("item") ? "item" : "register"; }
/// Returns whether a regular expression is found in `text`.
[[nodiscard]] bool fits_expression(const std::string& expression, const std::string& text);

/// Reads a list of whole numbers from `low` to `high`, which a double must hold exactly. Any other number is an error
/// and is left out.
[[nodiscard]] std::vector<std::int64_t> read_integers(const TomlTable& table, const char* key, std::int64_t low,
                                                      std::int64_t high);
/// Returns the noun for an item of this kind of unit in messages: "item" or "register".
[[nodiscard]] const char* item_kind(const RegisterMap& map);
/// Returns the item `name`. If there is none, notes an error at `key` and returns null.
[[nodiscard]] const RegisterItem* find_named_item(const RegisterMap& map, const TomlTable& table, const char* key,
                                                  const std::string& name);
/// Reads the keys that the profile memories of all units have.
[[nodiscard]] ProfileMemory read_memory_properties(const TomlTable& table, const RegisterMap& map);
/// Notes an error if the steps of a profile memory lack a value, or do not fit into the registers.
void check_steps(const TomlTable& table, const ProfileMemory& memory);
/// Returns the number that a name denotes: the first code with this meaning, or the mask of the flag.
[[nodiscard]] std::optional<double> find_code(const RegisterItem& item, const std::string& meaning);
/// Describes a name that is neither a code nor a flag of an item, and lists those that are.
[[nodiscard]] std::string describe_unknown_code(const RegisterMap& map, const RegisterItem& item,
                                                const std::string& name);

/// Returns whether the map has a command that stops the chamber.
[[nodiscard]] bool can_stop(const RegisterMap& map);

/// Reads { register, is | is_not | bits | above }. Notes an error for a condition that would never or always hold
/// because its keys exclude each other.
[[nodiscard]] Condition read_condition(const TomlTable& table, const RegisterMap& map);
/// Reads a condition as read_condition() does, on an item that can be read.
[[nodiscard]] Condition read_readable_condition(const TomlTable& table, const RegisterMap& map);

}  // namespace gyrotherm::drivers
