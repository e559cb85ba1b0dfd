// SPDX-License-Identifier: Apache-2.0
#include "sequencer/rig/rig_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <set>
#include <utility>

#include "acquisition/record/schema.hpp"
#include "core/clock.hpp"
#include "core/file.hpp"
#include "core/humidity.hpp"
#include "core/toml_reader.hpp"
#include "drivers/chamber/exchange_time.hpp"
#include "drivers/chamber/register_map.hpp"
#include "drivers/chamber/text_file_reader.hpp"
#include "drivers/line/line_address.hpp"
#include "sequencer/interlocks/limits.hpp"
#include "sequencer/rig/line_settings.hpp"
#include "sequencer/rig/thermometer_settings.hpp"
#include "simulator/chamber_registers.hpp"

namespace gyrotherm::rig {
namespace {

std::optional<Celsius> read_limit_if_any(const TomlTable& table, const char* key) {
  if (!table.has(key)) return {};
  return table.celsius(key);
}

void check_safe_set_point(const TomlTable& table, const char* key, const RigFile& rig) {
  if (rig.safe_set_point < rig.chamber_limits.lowest || rig.safe_set_point > rig.chamber_limits.highest)
    table.note_error(key, "the safe set point is outside the chamber's limits");
}

/// Reads [chamber.limiter]; nothing if there is none. `lowest` and `highest` are the chamber's limits in the rig: a
/// limiter set inside them would trip in a run, and is an error.
std::optional<Limiter> read_limiter(const TomlTable& chamber, Celsius lowest, Celsius highest) {
  if (!chamber.has("limiter")) return {};
  const auto table = chamber.table("limiter");
  Limiter limiter{.protection_class = table.choice("class", {"1", "2", "3.1", "3.2", "3.3"}),
                  .lowest = read_limit_if_any(table, "lowest"),
                  .highest = read_limit_if_any(table, "highest")};
  if (!limiter.lowest && !limiter.highest)
    table.note_error("", "expected lowest, highest or both: the limiter's settings");
  // DIN 12880: class 3.1 protects from high temperatures, class 3.2 from low ones, class 3.3 from both.
  const auto& protection = limiter.protection_class;
  if (protection == "3.1" && !limiter.highest)
    table.note_error("class", "a limiter of class 3.1 acts at a high temperature, expected \"highest\"");
  if (protection == "3.2" && !limiter.lowest)
    table.note_error("class", "a limiter of class 3.2 acts at a low temperature, expected \"lowest\"");
  if (protection == "3.3" && !(limiter.lowest && limiter.highest))
    table.note_error("class", "a limiter of class 3.3 acts on both sides, expected \"lowest\" and \"highest\"");
  if (limiter.lowest && limiter.highest && *limiter.lowest >= *limiter.highest) {
    table.note_error("lowest", "the limiter's lowest setting is not below its highest");
    return limiter;
  }
  if (limiter.lowest && *limiter.lowest >= lowest)
    table.note_error("lowest", "the limiter would trip at a permitted set point");
  if (limiter.highest && *limiter.highest <= highest)
    table.note_error("highest", "the limiter would trip at a permitted set point");
  return limiter;
}

/// Reads the name and the title.
void read_name(const TomlTable& root, RigFile& rig) {
  rig.name = root.text("name");
  if (rig.name.empty() && root.is_text("name")) root.note_error("name", "\"name\" is empty, expected a name");
  rig.title = root.text("title", rig.name);
}

void read_chamber(const TomlTable& table, RigFile& rig) {
  rig.chamber_line = table.text("line");
  check_line(table, rig.chamber_line);
  rig.chamber_link = drivers::read_link_settings(table.table("link"));
  rig.chamber_parameters = drivers::read_text_parameters(table.table("parameter"));
  rig.chamber_limits = {
      .lowest = table.celsius("lowest"),
      .highest = table.celsius("highest"),
      .fastest_heating = table.positive_rate("fastest_heating"),
      .fastest_cooling = table.positive_rate("fastest_cooling"),
  };
  rig.safe_set_point = table.celsius("safe_set_point");
  rig.limiter = read_limiter(table, rig.chamber_limits.lowest, rig.chamber_limits.highest);
  if (rig.chamber_limits.lowest >= rig.chamber_limits.highest)
    table.note_error("lowest", "the lowest temperature is not below the highest");
  else
    check_safe_set_point(table, "safe_set_point", rig);
}

/// Reads [room]: the dew point of the air around the chamber, or its temperature and relative humidity.
profile::RoomAir read_room(const TomlTable& table) {
  constexpr Celsius kTemperature{23};
  constexpr double kHumidityPercent = 60;
  profile::RoomAir room;
  const bool has_air = table.has("temperature") || table.has("humidity_percent");
  const auto temperature = table.celsius("temperature", kTemperature);
  const double percent = table.number("humidity_percent", kHumidityPercent);
  const auto computed = dew_point(temperature, percent);
  if (has_air && !computed)
    table.note_error(table.has("humidity_percent") ? "humidity_percent" : "temperature",
                     "expected a humidity above 0 and at most 100 %, and a temperature from -45 to 100 °C");
  if (has_air && table.has("dew_point"))
    table.note_error("dew_point", "a dew point is given with temperature or humidity_percent, expected one of them");
  if (computed && has_air) room.dew_point = *computed;
  room.dew_point = table.celsius("dew_point", room.dew_point);
  room.margin = table.kelvins("margin", room.margin);
  if (room.margin < Kelvins{0}) table.note_error("margin", "expected 0 K or more");
  return room;
}

/// Checks the table [simulated] of a map. The map of a real rig in a record is not checked, so that the record can be
/// read. The identity of the virtual chamber matters only in a simulation, because a real rig may have other
/// parameters.
Result<void> check_virtual_chamber(const drivers::RegisterMap& map, const std::string& file, bool is_simulated,
                                   bool is_recorded) {
  if (!is_simulated && is_recorded) return {};
  const auto unit = simulator::read_simulated_unit(map, file);
  if (!unit) return failure(unit.error());
  return is_simulated ? check_simulated_identity(map, *unit, file) : Result<void>{};
}

/// Reads the map and selects the link for the line.
Result<drivers::RegisterMap> read_map(const TomlTable& chamber, const RigFile& rig,
                                      std::optional<drivers::LinkKind> framing,
                                      const std::optional<std::string>& known) {
  const auto named = read_named(chamber, "map", rig.file, kShippedChamberMap, known);
  if (!named) return failure(named.error());
  auto map = parse_register_map(named->text, named->path, rig.chamber_word_order, rig.chamber_parameters);
  if (map) note_unknown_parameter(*map, chamber, rig.chamber_parameters);
  const auto line = drivers::parse_line(rig.chamber_line);
  if (!map || !line) return map;
  if (auto sound = check_virtual_chamber(*map, named->path, rig.simulated, known.has_value()); !sound)
    return failure(std::move(sound.error()));
  auto linked = select_link_for(std::move(*map), *line, framing);
  if (!linked) return failure(FaultKind::bad_file, chamber.location("line"), linked.error().what);
  auto powered = select_power_switch(std::move(*linked), rig.chamber_power);
  if (!powered) return failure(FaultKind::bad_file, chamber.location("power"), powered.error().what);
  auto measuring = chamber.boolean("humidity", false) ? select_humidity(std::move(*powered)) : std::move(powered);
  if (!measuring) return failure(FaultKind::bad_file, chamber.location("humidity"), measuring.error().what);
  auto applied = apply_link_settings(std::move(*measuring), chamber, rig.chamber_line, rig.chamber_link);
  const auto slow = known ? std::string() : drivers::describe_slow_exchange(applied.link);
  if (!slow.empty()) return failure(FaultKind::bad_file, chamber.location("link"), slow);
  return applied;
}

/// Reads the word order. Returns the framing that the file requires, if any.
std::optional<drivers::LinkKind> read_word_order_and_framing(const TomlTable& chamber, RigFile& rig) {
  rig.chamber_word_order = read_link_keyword(drivers::kWordOrders, chamber, "word_order");
  return read_link_keyword(drivers::kLinkKinds, chamber, "framing");
}

/// Applies [analysis] to the units without their own thermometers.
void read_analysis(const TomlTable& table, const std::vector<std::string>& channels, std::vector<UnitSettings>& units) {
  const auto gradients = read_channel_names(table, "gradients", channels);
  const auto three_point = read_channel_names(table, "three_point", channels);
  const bool is_required = std::ranges::any_of(units, [](const auto& unit) { return !unit.has_own_thermometers; });
  if ((is_required || table.has("gradients")) && gradients.size() < 2)
    table.note_error("gradients", "expected at least two thermometers");
  if (!three_point.empty() && three_point.size() != 3)
    table.note_error("three_point", "expected three thermometers: cathode, anode, shell");
  for (auto& unit : units) {
    if (unit.has_own_thermometers) continue;
    unit.info.gradients = gradients;
    if (!unit.has_own_three_point) unit.info.three_point = three_point;
  }
}

/// Reads [safe], the safe state of the chamber.
void read_safe_state(const TomlTable& table, RigFile& rig) {
  rig.safe_set_point = table.celsius("set_point", rig.safe_set_point);
  rig.safe_off = table.boolean("off", false);
  rig.safe_observe = table.duration("observe", rig.safe_observe);
  if (rig.safe_observe > std::chrono::hours(1))
    table.note_error("observe", "\"observe\" is longer than 1 h, expected at most 1 h");
  if (table.has("set_point")) check_safe_set_point(table, "set_point", rig);
  if (table.has("also")) rig.safe_also = drivers::read_relay_settings(table.table("also"));
}

/// Records an error if the safe state switches off a chamber whose map has no command for it. A rig file from a record
/// is not checked, so that the record can be read.
void check_safe_off(const TomlTable& root, const RigFile& rig, const drivers::RegisterMap& map, bool is_recorded) {
  if (rig.safe_off && !is_recorded && !drivers::can_stop(map))
    root.table("safe").note_error(
        "off", fmt::format("the map \"{}\" has no command that stops the chamber, expected [control] or stop in "
                           "[sequence]; without them, remove \"off\" and rely on the safe set point",
                           map.name));
}

/// Records an error if the safe set point is outside the air limits. The interlocks would otherwise trip while the
/// chamber is being made safe.
void check_safe_air(const TomlTable& root, const RigFile& rig) {
  const auto& limits = rig.limits;
  if (rig.safe_set_point >= limits.air_lowest && rig.safe_set_point <= limits.air_highest) return;
  const bool in_safe = root.has("safe") && root.table("safe").has("set_point");
  root.table(in_safe ? "safe" : "chamber")
      .note_error(
          in_safe ? "set_point" : "safe_set_point",
          fmt::format("the safe set point is {:g} °C, outside the air limits, {:g} to {:g} °C, at which a run ends",
                      rig.safe_set_point.value, limits.air_lowest.value, limits.air_highest.value));
}

std::vector<record::Channel> thermometer_channels(const RigFile& rig) {
  std::vector<record::Channel> channels;
  for (const auto& settings : rig.thermometers)
    channels.insert(channels.end(), settings.calibrated.begin(), settings.calibrated.end());
  return channels;
}

std::vector<std::string> channel_names(const std::vector<record::Channel>& channels) {
  std::vector<std::string> names;
  for (const auto& channel : channels) names.push_back(channel.name);
  return names;
}

bool is_needed_by(const record::UnitInfo& unit, const std::string& channel) {
  return std::ranges::count(unit.gradients, channel) + std::ranges::count(unit.three_point, channel) > 0;
}

interlocks::UnitLimits make_unit_limits(const UnitSettings& unit, const std::vector<std::string>& channels) {
  interlocks::UnitLimits limits{
      .name = unit.info.name, .continue_when_silent = unit.continue_when_silent, .thermometers = {}};
  for (std::size_t i = 0; i < channels.size(); ++i)
    if (is_needed_by(unit.info, channels[i])) limits.thermometers.push_back(i);
  std::optional<DegreesPerHour> largest_bias;
  if (const auto stated = unit.largest_bias_deg_per_h) largest_bias = DegreesPerHour{*stated};
  for (std::size_t i = 0; i < unit.info.axes.size(); ++i)
    limits.axes.push_back({.label = record::axis_label(unit.info, i),
                           .arcsec_per_count = unit.info.axes[i].scale,
                           .earth_rate = unit.info.axes[i].earth_rate,
                           .largest_bias = largest_bias});
  for (auto i = unit.info.values.size() - unit.analogue_values; i < unit.info.values.size(); ++i)
    limits.analogue.push_back(unit.info.values[i].name);
  return limits;
}

/// Lists the columns of each thermometer instrument, under its title.
std::vector<interlocks::InstrumentChannels> list_instruments(const RigFile& rig) {
  std::vector<interlocks::InstrumentChannels> instruments;
  std::size_t column = 0;
  for (const auto& entry : rig.thermometers) {
    instruments.push_back({.name = fmt::format("thermometer {}", instruments.size() + 1)});
    for (std::size_t i = 0; i < entry.channels.size(); ++i) instruments.back().columns.push_back(column++);
  }
  return instruments;
}

/// Records an error for each name that is not permitted. `is_recorded` is true if the rig file comes from a record.
/// More names are permitted in an existing record than in a new one.
void check_names(const TomlTable& root, const RigFile& rig, bool is_recorded) {
  record::RunInfo info;
  info.thermometers = thermometer_channels(rig);
  for (const auto& unit : rig.units) info.units.push_back(unit.info);
  const auto is_noted_already = [&](const record::NameTrouble& trouble) {
    if (trouble.of == record::NameTrouble::Of::unit) return rig.units[trouble.unit].info.name.empty();
    if (trouble.of != record::NameTrouble::Of::thermometer) return false;
    const auto& name = info.thermometers[trouble.index].name;
    return std::ranges::count(info.thermometers, name, &record::Channel::name) > 1;
  };
  for (const auto& trouble : is_recorded ? record::name_troubles(info) : record::new_name_troubles(info))
    if (!is_noted_already(trouble))
      root.note_error(trouble.of == record::NameTrouble::Of::thermometer ? "thermometer" : "gyro",
                      fmt::format("{}: {}", trouble.what, trouble.why));
}

std::vector<std::string> list_lines(const RigFile& rig) {
  std::vector<std::string> lines{rig.chamber_line};
  for (const auto& gyro : rig.gyro_lines) lines.push_back(gyro.line);
  for (const auto& settings : rig.thermometers) lines.push_back(settings.line);
  for (const auto& settings : rig.analogue_inputs) lines.push_back(settings.line);
  for (const auto& settings : rig.supplies) lines.push_back(settings.line);
  return lines;
}

/// Returns whether two instruments would share a connection. Port 0 is the usual port of the instrument.
bool is_same_line(const drivers::Line& one, const drivers::Line& other) {
  const auto *serial = std::get_if<drivers::SerialLine>(&one), *other_serial = std::get_if<drivers::SerialLine>(&other);
  if (serial && other_serial) return serial->device == other_serial->device;
  const auto *tcp = std::get_if<drivers::TcpLine>(&one), *other_tcp = std::get_if<drivers::TcpLine>(&other);
  if (!tcp || !other_tcp || tcp->host != other_tcp->host) return false;
  return tcp->port == other_tcp->port || tcp->port == 0 || other_tcp->port == 0;
}

/// Records an error if the relay of [safe.also] shares its line with an instrument, because it must work while the line
/// of the chamber is dead.
void check_relay_line(const TomlTable& root, const RigFile& rig) {
  if (!rig.safe_also) return;
  const auto relay = drivers::parse_line(rig.safe_also->line);
  for (const auto& text : list_lines(rig))
    if (const auto line = drivers::parse_line(text); line && relay && is_same_line(*line, *relay))
      root.table("safe").table("also").note_error(
          "line", fmt::format("\"{}\" is the line of an instrument, expected a line of the relay's own", text));
}

/// Lists the tables with the lines of list_lines(), in the same order.
std::vector<TomlTable> list_line_tables(const TomlTable& root) {
  std::vector<TomlTable> tables{root.table("chamber")};
  for (const auto& gyro : root.is_list("gyro") ? root.tables("gyro") : std::vector{root.table("gyro")})
    if (!gyro.has("shares_line_with")) tables.push_back(gyro);
  for (const auto& others : {root.tables("thermometer"), root.tables("analogue_input"), root.tables("supply")})
    tables.insert(tables.end(), others.begin(), others.end());
  return tables;
}

/// Checks that no port or USB device is shared by two instruments. Several instruments may share a network address.
void check_ports(const TomlTable& root, const RigFile& rig) {
  const auto lines = list_lines(rig);
  const auto tables = list_line_tables(root);
  const bool is_complete = tables.size() == lines.size();
  std::set<std::string> taken;
  int hids = 0;
  bool any_hid = false;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const auto line = drivers::parse_line(lines[i]);
    if (!line) continue;
    const auto* serial = std::get_if<drivers::SerialLine>(&*line);
    const auto* hid = std::get_if<drivers::HidLine>(&*line);
    hids += hid != nullptr ? 1 : 0;
    any_hid = any_hid || (hid != nullptr && hid->serial.empty());
    const bool is_exclusive = serial != nullptr || hid != nullptr;
    if (is_exclusive && !taken.insert(serial ? serial->device : lines[i]).second)
      (is_complete ? tables[i] : root)
          .note_error(is_complete ? "line" : "",
                      fmt::format("\"{}\" is the line of two instruments, expected one line per instrument", lines[i]));
  }
  if (any_hid && hids > 1)
    root.note_error("", "\"hid:\" is only for a rig with one USB device, expected serial numbers");
  check_relay_line(root, rig);
}

/// Reads [certificates]: the PEM file with the trusted signers of certificate files.
std::string read_trusted_certificates(const TomlTable& table, const std::string& folder) {
  const std::string name = table.text("trusted", "");
  return name.empty() ? name : (std::filesystem::path(folder) / name).string();
}

/// Reads the certificate file of a thermometer and applies it to its channels.
Result<void> read_certificate_file(NamedCertificate& named, const CertificateReader& reader,
                                   const CertificateDays& allowed, std::vector<record::Channel>& channels) {
  const auto refused = [&](const char* what) { return failure(FaultKind::bad_file, named.location, what); };
  if (!reader.read) return refused("names a certificate file, which cannot be read here");
  if (named.request.trusted.empty())
    return refused("names a certificate file, but no trusted signers: expected [certificates] trusted = \"FILE.pem\"");
  const auto values = reader.read(named.request);
  if (!values) return failure(values.error());
  for (const std::size_t i : named.channels)
    if (auto done = apply_certificate(*values, named.location, allowed, channels[i]); !done) return done;
  return {};
}

/// Applies the certificate files of all thermometers, or on a resume the calibrations of the record.
Result<void> apply_certificates(RigFile& rig, const std::string& trusted, const NamedTexts& known,
                                const CertificateReader& reader) {
  using std::chrono::floor, std::chrono::days;
  const auto today = rig.simulated ? std::chrono::sys_days(floor<days>(kVirtualEpoch)) : reader.today;
  const CertificateDays allowed{.of_run = today, .latest_calibration = std::max(today, reader.today)};
  for (auto& thermometer : rig.thermometers)
    for (NamedCertificate& named : thermometer.certificates) {
      named.request.trusted = trusted;
      Result<void> done;
      if (!known.channels) done = read_certificate_file(named, reader, allowed, thermometer.calibrated);
      for (std::size_t i = 0; known.channels && done && i < named.channels.size(); ++i)
        done = restore_calibration(*known.channels, named.location, thermometer.calibrated[named.channels[i]]);
      if (!done) return done;
    }
  return {};
}

/// Returns whether a line is an address, or a program that communicates with its instrument.
bool is_valid_line(const std::string& line) { return line.starts_with("process:") || drivers::parse_line(line); }

/// Checks that either all lines are virtual, or none. Checks nothing if a line is invalid, because it could be a
/// misspelt "virtual".
void determine_simulated(const TomlTable& root, RigFile& rig) {
  const auto lines = list_lines(rig);
  const auto count = std::count(lines.begin(), lines.end(), kVirtualLine);
  rig.simulated = count == static_cast<std::ptrdiff_t>(lines.size());
  if (!std::ranges::all_of(lines, is_valid_line)) return root.ignore("virtual");
  if (count != 0 && !rig.simulated)
    root.note_error("chamber", "some lines are \"virtual\" and some are not; a rig is wholly virtual or wholly real");
  if (rig.simulated != root.has("virtual"))
    root.note_error("virtual", rig.simulated ? "a virtual rig needs a [virtual] table"
                                             : "a real rig must not have a [virtual] table");
}

}  // namespace

std::string describe(const Limiter& limiter) {
  auto text = "class " + limiter.protection_class;
  if (limiter.lowest) text += fmt::format(", below {:g} °C", limiter.lowest->value);
  if (limiter.highest) text += fmt::format(", above {:g} °C", limiter.highest->value);
  return text;
}

std::string describe_limiter_that_trips_first(const RigFile& rig) {
  if (!rig.limiter) return {};
  std::vector<std::string> keys;
  if (rig.limiter->lowest && rig.limits.air_lowest <= *rig.limiter->lowest)
    keys.push_back(fmt::format("air_lowest = {:g} °C", rig.limits.air_lowest.value));
  if (rig.limiter->highest && rig.limits.air_highest >= *rig.limiter->highest)
    keys.push_back(fmt::format("air_highest = {:g} °C", rig.limits.air_highest.value));
  if (keys.empty()) return {};
  return fmt::format("the limiter trips before the interlock on the air acts ({}); set [limits] inside its settings",
                     fmt::join(keys, ", "));
}

Result<RigFile> parse_rig(std::string_view text, const std::string& file, const NamedTexts& known,
                          const CertificateReader& certificates) {
  const auto root = TomlTable::parse(text, file);
  if (!root) return failure(root.error());
  RigFile rig;
  rig.text = text;
  rig.file = file;
  root->expect("schema", "gyrotherm-rig/1");
  read_name(*root, rig);
  const auto chamber = root->table("chamber");
  read_chamber(chamber, rig);
  std::set<std::string> seen;
  DescriptionReader descriptions(file, known.thermometer_descriptions);
  const auto folder = known.folder.empty() ? parent_folder(file) : known.folder;
  for (const auto& table : root->tables("thermometer"))
    rig.thermometers.push_back(read_thermometer(table, folder, rig.thermometers.size() + 1, seen, descriptions));
  const auto trusted = read_trusted_certificates(root->table("certificates"), folder);
  if (rig.thermometers.empty()) root->note_error("", "missing [[thermometer]], expected at least one");
  const auto channels = channel_names(thermometer_channels(rig));
  auto gyros = read_gyros(*root, file, channels, known.gyro_streams);
  if (gyros) {
    rig.units = std::move(gyros->units);
    rig.gyro_lines = std::move(gyros->lines);
  }
  Result<std::vector<AnalogueSettings>> analogue;
  if (gyros)
    analogue = read_analogue_inputs(*root, file, rig.units, known.analogue_maps);
  else
    root->ignore("analogue_input");
  if (analogue) rig.analogue_inputs = std::move(*analogue);
  Result<std::vector<SupplySettings>> supplies;
  if (gyros && analogue)
    supplies = read_supplies(*root, file, rig.units, known.supply_descriptions);
  else
    root->ignore("supply");
  if (supplies) rig.supplies = std::move(*supplies);
  read_analysis(root->table("analysis"), channels, rig.units);
  read_safe_state(root->table("safe"), rig);
  if (root->has("check_standard")) rig.check_standard = read_check_standard(root->table("check_standard"));
  rig.proof = read_proof_settings(*root);
  rig.limits = interlocks::read_limits(*root, channels, rig.chamber_limits);
  for (const auto& unit : rig.units) rig.limits.units.push_back(make_unit_limits(unit, channels));
  rig.limits.instruments = list_instruments(rig);
  rig.run_limits = interlocks::read_run_limits(*root);
  check_safe_air(*root, rig);
  if (gyros) check_names(*root, rig, known.chamber_map.has_value());
  if (gyros && analogue && supplies)
    determine_simulated(*root, rig);
  else
    root->ignore("virtual");
  check_ports(*root, rig);
  if (const auto room = read_room(root->table("room")); !rig.simulated || root->has("room")) rig.limits.room = room;
  rig.chamber_power = chamber.text("power", "");
  auto map = read_map(chamber, rig, read_word_order_and_framing(chamber, rig), known.chamber_map);
  if (map) check_safe_off(*root, rig, *map, known.chamber_map.has_value());
  if (const auto verdict = root->verdict(); !verdict) return failure(verdict.error());
  if (!descriptions.outcome()) return failure(descriptions.outcome().error());
  if (!gyros) return failure(gyros.error());
  if (!analogue) return failure(analogue.error());
  if (!supplies) return failure(supplies.error());
  if (!map) return failure(map.error());
  rig.chamber_map = std::move(*map);
  if (auto applied = apply_certificates(rig, trusted, known, certificates); !applied) return failure(applied.error());
  if (!rig.simulated) return rig;
  auto gyro_model = simulator::find_gyro_model(text, file, known.gyro_model);
  if (!gyro_model) return failure(gyro_model.error());
  rig.gyro_model = std::move(*gyro_model);
  return rig;
}

Result<RigFile> read_rig(const std::string& given, const CertificateReader& certificates) {
  const auto file = resolve_path(given, kShippedRig);
  if (!file) return failure(file.error());
  return read_text_file(*file).and_then(
      [&](const std::string& text) { return parse_rig(text, *file, {}, certificates); });
}

Result<void> add_warm_ups(profile::Profile& profile, const RigFile& rig) {
  if (!rig.limits.room) return {};
  return profile::add_warm_ups(profile, make_warm_up(*rig.limits.room, rig.chamber_limits));
}

bool records_humidity(const RigFile& rig) {
  constexpr const char* kHumidity = "humidity";
  const auto* item = rig.chamber_map.find(kHumidity);
  return rig.chamber_map.reads_humidity && item != nullptr && item->readable;
}

bool records_dew_point(const RigFile& rig) { return rig.chamber_map.reads_humidity; }

std::vector<std::string> collect_analogue_map_texts(const RigFile& rig) {
  std::vector<std::string> texts;
  for (const auto& settings : rig.analogue_inputs) texts.push_back(settings.map.registers.text);
  return texts;
}

std::vector<std::string> collect_thermometer_texts(const RigFile& rig) {
  std::vector<std::string> texts;
  for (const auto& settings : rig.thermometers)
    if (settings.description) texts.push_back(settings.description->unit.text);
  return texts;
}

std::vector<std::string> collect_supply_texts(const RigFile& rig) {
  std::vector<std::string> texts;
  for (const auto& settings : rig.supplies) texts.push_back(settings.description.unit.text);
  return texts;
}

std::vector<record::Channel> list_channels(const RigFile& rig) {
  auto channels = thermometer_channels(rig);
  if (rig.units.size() < 2) return channels;
  for (auto& channel : channels) {
    channel.unit_under_test.clear();
    int units = 0;
    for (const auto& unit : rig.units)
      if (is_needed_by(unit.info, channel.name)) channel.unit_under_test = ++units == 1 ? unit.info.name : "";
  }
  return channels;
}

const GyroLine& find_gyro_line(const RigFile& rig, std::size_t unit) {
  const auto has_it = [unit](const GyroLine& line) {
    return std::ranges::any_of(line.shares, [unit](const auto& share) { return share.unit == unit; });
  };
  return *std::ranges::find_if(rig.gyro_lines, has_it);
}

}  // namespace gyrotherm::rig
