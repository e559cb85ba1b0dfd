/// The register map of a Modbus chamber: a TOML file under profiles/chambers, used by the driver and, from the other
/// end of the wire, by the virtual chamber. docs/chamber-maps.md describes the format.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/quantity.hpp"
#include "core/result.hpp"
#include "drivers/chamber/conditions.hpp"
#include "drivers/chamber/profile_memory.hpp"
#include "drivers/chamber/register_item.hpp"
#include "drivers/line/modbus.hpp"

namespace gyrotherm {

enum class LinkKind { tcp, rtu, rtu_over_tcp };

struct MapLink {
  LinkKind kind{};
  ModbusLink modbus;
  int clients_at_most = 0;  ///< TCP connections that the unit takes at once; 0: not known
};

/// What a register holds if the instrument is the one that the map describes.
struct Fingerprint {
  std::string item;
  double value{};
  std::uint32_t mask = 0xFFFFFFFF;  ///< bits that count, of a whole number
  std::string pattern;              ///< of a text: "F4T*", "*" stands for anything; then there is no value
};

/// How conditioning is commanded: a code written to one item, and seen to take effect in another (or the same).
struct ControlMode {
  std::string commanded;
  std::string active;
  std::int64_t on{};
  std::int64_t off{};
};

/// What set points the controller takes: numbers, or the items that hold them.
struct SetPointLimits {
  std::optional<Celsius> lowest, highest;
  std::string lowest_item, highest_item;
  CelsiusPerMinute fastest{};  ///< 0: not known
  Duration every{};            ///< a set point no more often than this; 0: as often as the link allows
};

/// Registers that must not be written, and why.
struct Forbidden {
  std::uint16_t first{}, last{};
  std::string why;
};

/// What the virtual chamber needs to know beside the items: what switches it on, and what it shows then.
struct SimulatedUnit {
  struct Shows {
    std::string item;
    std::map<std::string, double>
        values;  ///< by state: "off", "on", "running" (or "ramping", "soaking"), "held", "done"
  };
  std::vector<Condition> turns_on, turns_off;  ///< by writing this
  std::vector<Condition> starts_program, holds_program, resumes_program, ends_program;
  std::vector<Condition> creates_program;                ///< by writing this the memory is emptied
  std::vector<Condition> stores_program, loads_program;  ///< by writing this the edit window is kept, or comes back
  std::string program_number, program_step;              ///< items that say which program and step is started
  std::vector<Shows> shows;
  std::vector<std::pair<std::string, double>> initial;
  std::vector<std::pair<std::string, std::string>> initial_texts;
  bool silent_exceptions{};           ///< no reply where others answer with an exception
  bool ignores_blocks_elsewhere{};    ///< function 16 outside the profile memory is acknowledged and does nothing
  std::vector<std::string> when_off;  ///< items that hold their first sentinel while the unit is off
};

struct RegisterMap {
  std::string name;
  std::string vendor;
  std::string model;
  std::string firmware;
  std::string source;
  Confidence confidence = Confidence::unverified;  ///< of the least sure item that this program uses
  std::vector<MapLink> links;                      ///< at least one; the first is the usual one
  MapLink link;                                    ///< the one in use
  bool one_block{};    ///< air_temperature, set_point and the fingerprint may be read as one block, holes included
  bool holes{};        ///< any registers within the link's limit may be read as one block, holes included
  int status_every{};  ///< state and alarms are asked for at each n-th read; 0: never
  std::vector<RegisterItem> items;
  std::optional<Fingerprint> identity;
  std::optional<ControlMode> control;         ///< absent: the chamber conditions whenever it is powered
  std::map<std::string, Sequence> sequences;  ///< "start", "stop", "pause", "resume", "acknowledge", …
  std::vector<StateRule> states;
  std::vector<AlarmRule> alarms;
  SetPointLimits limits;
  std::vector<Forbidden> forbidden;
  std::optional<ProfileMemory> memory;
  SimulatedUnit simulated;
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

/// "tcp", "rtu", "rtu_over_tcp", as files say it.
[[nodiscard]] const char* name(LinkKind kind);
[[nodiscard]] const char* name(Confidence confidence);

}  // namespace gyrotherm
