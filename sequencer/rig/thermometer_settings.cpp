// SPDX-License-Identifier: Apache-2.0
#include "sequencer/rig/thermometer_settings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "acquisition/record/run_info.hpp"
#include "core/toml_reader.hpp"
#include "drivers/chamber/text_file_reader.hpp"
#include "drivers/line/byte_streams.hpp"
#include "drivers/thermometer/dcon_thermometer.hpp"
#include "drivers/thermometer/mcc_usb_temp.hpp"
#include "drivers/thermometer/text_thermometer.hpp"
#include "sequencer/rig/line_settings.hpp"

namespace gyrotherm::rig {
namespace {

enum class SensorKind { rtd, thermocouple, thermistor, semiconductor };
constexpr auto kKinds =
    make_vocabulary<SensorKind::rtd, SensorKind::semiconductor>("rtd", "thermocouple", "thermistor", "semiconductor");
constexpr Vocabulary<drivers::MccWires, 2> kWires{
    {{"2-wire", drivers::MccWires::two_wire_two_sensors}, {"4-wire", drivers::MccWires::four_wire}}};
using Type = drivers::MccThermocoupleType;
constexpr auto kTypes = make_vocabulary<Type::j, Type::n>("J", "K", "T", "E", "R", "S", "B", "N");

float number(const TomlTable& table, const char* key) { return static_cast<float>(table.number(key)); }
float number(const TomlTable& table, const char* key, float fallback) {
  return table.has(key) ? number(table, key) : fallback;
}

/// Reads a sensor. `kind` = "rtd" (the default: platinum, 100 Ω, IEC 60751; `r0_ohm`, `a_per_k`, `b_per_k2`,
/// `c_per_k4`), "thermocouple" (`type`), "thermistor" (Steinhart–Hart `a`, `b`, `c`) or "semiconductor" (`offset`,
/// `scale`, `differential`). `wires` of "rtd" and "thermistor": "2-wire" (the default) or "4-wire", which permit a
/// sensor at every input.
drivers::MccSensor read_sensor(const TomlTable& table) {
  switch (one_of(kKinds, table, "kind", "rtd")) {
    case SensorKind::thermocouple: return drivers::MccThermocouple{one_of(kTypes, table, "type")};
    case SensorKind::thermistor:
      return drivers::MccThermistor{.wires = one_of(kWires, table, "wires", "2-wire"),
                                    .a = number(table, "a"),
                                    .b = number(table, "b"),
                                    .c = number(table, "c")};
    case SensorKind::semiconductor:
      return drivers::MccSemiconductor{.differential = table.boolean("differential", false),
                                       .offset = number(table, "offset"),
                                       .scale = number(table, "scale")};
    case SensorKind::rtd: break;
  }
  drivers::MccRtd rtd{.wires = one_of(kWires, table, "wires", "2-wire")};
  rtd.r0_ohm = number(table, "r0_ohm", rtd.r0_ohm);
  rtd.a_per_k = number(table, "a_per_k", rtd.a_per_k);
  rtd.b_per_k2 = number(table, "b_per_k2", rtd.b_per_k2);
  rtd.c_per_k4 = number(table, "c_per_k4", rtd.c_per_k4);
  if (!(rtd.r0_ohm > 0)) table.note_error("r0_ohm", "expected a resistance above zero");
  return rtd;
}

using Kind = drivers::ThermometerKind;

constexpr Vocabulary<std::uint8_t, 4> kDconTypes{{{"J", 0x0E}, {"K", 0x0F}, {"T", 0x10}, {"E", 0x11}}};
constexpr std::size_t kMaxCoefficients = 10;

std::size_t count_inputs(const ThermometerSettings& settings) {
  if (settings.description) return settings.description->inputs;
  return kind_row(settings.kind).inputs * (settings.kind == Kind::dcon ? settings.addresses.size() : 1);
}

/// Records an error if this kind of instrument cannot use its line.
void check_instrument_line(const TomlTable& table, const ThermometerSettings& settings) {
  const auto line = drivers::parse_line(settings.line);
  if (settings.kind != Kind::mcc_usb_temp || is_empty_line(table, settings.line))
    return check_line(table, settings.line);
  if (!line) return table.note_error("line", line.error().what);
  if (!std::holds_alternative<drivers::HidLine>(*line) && settings.line != kVirtualLine)
    table.note_error("line", "a USB-TEMP is an HID device; expected \"hid:SERIAL\" or \"hid:\"");
}

void read_link(const TomlTable& table, ThermometerSettings& settings) {
  const auto link = table.table("link");
  settings.echo = link.boolean("echo", false);
  const auto line = drivers::parse_line(settings.line);
  if (settings.echo && line && !drivers::is_byte_line(*line))
    link.note_error("echo", "only a tcp:// or serial: line can echo");
}

void read_dcon(const TomlTable& table, ThermometerSettings& settings) {
  if (table.has("addresses")) settings.addresses.clear();
  for (const double address : table.numbers("addresses")) {
    if (!(address >= 0 && address <= 255 && address == static_cast<std::uint8_t>(address)))
      table.note_error("addresses", fmt::format("\"addresses\" has {}, expected whole numbers from 0 to 255", address));
    else if (std::ranges::count(settings.addresses, static_cast<std::uint8_t>(address)) > 0)
      table.note_error("addresses", fmt::format("\"addresses\" has {} twice", address));
    else
      settings.addresses.push_back(static_cast<std::uint8_t>(address));
  }
  if (settings.addresses.empty()) table.note_error("addresses", "expected at least one address");
  settings.checksum = table.boolean("checksum", false) ? drivers::DconChecksum::on : drivers::DconChecksum::off;
  if (table.has("type")) settings.type = one_of(kDconTypes, table, "type");
}

/// Reads the command of a driver program, which communicates with its instrument by itself.
void read_command(const TomlTable& table, const std::string& folder, ThermometerSettings& settings) {
  settings.command = {.words = table.texts("command"), .folder = folder};
  settings.line = "process:" + text(settings.command);
  if (settings.command.words.empty() || settings.command.words.front().empty())
    table.note_error("command", "no \"command\", expected a program and its arguments, as [\"python3\", \"acme.py\"]");
  if (!table.has("line")) return;
  settings.line = table.text("line");
  if (settings.line != kVirtualLine) table.note_error("line", "a program has no line; expected none, or \"virtual\"");
}

drivers::LinkSettings read_text_link(const TomlTable& table) {
  return drivers::read_line_settings(table.table("link"));
}

/// Reads the description and selects its link for the line.
Result<drivers::ThermometerDescription> read_description(const TomlTable& table, const std::string& rig_file,
                                                         const std::string& line_text,
                                                         const std::optional<std::string>& known) {
  const auto named = read_named(table, "description", rig_file, kShippedThermometer, known);
  if (!named) return failure(named.error());
  const auto parameters = drivers::read_text_parameters(table.table("parameter"));
  auto description = drivers::parse_thermometer_description(named->text, named->path, parameters);
  if (description) note_unknown_parameter(description->unit, table, parameters);
  const auto line = drivers::parse_line(line_text);
  if (!description || !line) return description;
  auto linked = select_link_for(std::move(description->unit), *line);
  if (!linked) return failure(FaultKind::bad_file, table.location("line"), linked.error().what);
  description->unit = apply_link_settings(std::move(*linked), table, line_text, read_text_link(table));
  return description;
}

std::optional<std::chrono::sys_days> read_day(const TomlTable& table, const char* key) {
  if (!table.has(key)) return std::nullopt;
  const auto text = table.text(key);
  const auto day = record::parse_day(text);
  if (!day) table.note_error(key, fmt::format("\"{}\" is \"{}\", expected a day like \"2027-03-01\"", key, text));
  return day;
}

/// Adds a certificate file that a table names for the channels numbered `channels`. Returns true if it names one.
bool add_certificate_file(const TomlTable& table, const std::string& folder, std::vector<std::size_t> channels,
                          ThermometerSettings& settings) {
  auto named = read_named_certificate(table, folder);
  if (!named) return false;
  named->channels = std::move(channels);
  settings.certificates.push_back(std::move(*named));
  return true;
}

/// Notes an error if a calibration is due before its day.
void check_days(const TomlTable& table) {
  const auto calibrated = read_day(table, "calibrated"), due = read_day(table, "due");
  if (calibrated && due && *due < *calibrated)
    table.note_error("due", fmt::format("is before \"calibrated\", {}", record::format_day(*calibrated)));
}

/// Applies a table's certificate to all of `channels` without their own.
void read_certificate(const TomlTable& table, std::span<record::Channel> channels) {
  const auto certificate = table.text("certificate", "");
  const auto due = read_day(table, "due");
  for (auto& channel : channels) {
    if (channel.certificate.empty()) channel.certificate = certificate;
    if (!channel.due) channel.due = due;
  }
}

enum class Distribution { normal, rectangular };
constexpr auto kDistributions =
    make_vocabulary<Distribution::normal, Distribution::rectangular>("normal", "rectangular");

/// Reads a number above zero; nothing if the key is absent.
std::optional<double> read_positive_number(const TomlTable& table, const char* key) {
  if (!table.has(key)) return std::nullopt;
  const double value = table.number(key);
  if (value > 0 && std::isfinite(value)) return value;
  table.note_error(key, "expected a number above zero");
  return std::nullopt;
}

/// Reads the standard uncertainty of a certificate: the stated value divided by its coverage factor (default 2), or the
/// half-width of rectangular limits divided by √3 (GUM 4.3.3, 4.3.7).
record::ThermometerUncertainty read_uncertainty(const TomlTable& table) {
  constexpr double kUsualCoverage = 2, kMostUncertain_k = 5;
  record::ThermometerUncertainty uncertainty{
      .rectangular = one_of(kDistributions, table, "distribution", "normal") == Distribution::rectangular,
      .calibrated = read_day(table, "calibrated")};
  const auto value = read_positive_number(table, "uncertainty"),
             coverage = read_positive_number(table, "coverage_factor");
  if (uncertainty.rectangular && coverage)
    table.note_error("coverage_factor",
                     "rectangular limits have no coverage factor: expected one of coverage_factor and \"rectangular\"");
  for (const auto* key : {"coverage_factor", "distribution"})
    if (table.has(key) && !table.has("uncertainty"))
      table.note_error(key, "applies only to an \"uncertainty\", which is missing");
  if (value && *value > kMostUncertain_k)
    table.note_error("uncertainty",
                     fmt::format("{:g} K is no uncertainty of a usable thermometer, expected at most {:g} K", *value,
                                 kMostUncertain_k));
  const double divisor = uncertainty.rectangular ? std::numbers::sqrt3 : coverage.value_or(kUsualCoverage);
  if (value) uncertainty.calibration = Kelvins{*value / divisor};
  if (const auto drift = read_positive_number(table, "drift_k_per_year")) uncertainty.drift_in_a_year = Kelvins{*drift};
  return uncertainty;
}

/// Applies a table's uncertainty to all of `channels` without their own.
void apply_uncertainty(const TomlTable& table, std::span<record::Channel> channels) {
  const auto stated = read_uncertainty(table);
  for (auto& channel : channels) {
    auto& known = channel.uncertainty;
    if (!known.calibration) {
      known.calibration = stated.calibration;
      known.rectangular = stated.rectangular;
    }
    if (!known.drift_in_a_year) known.drift_in_a_year = stated.drift_in_a_year;
    if (!known.calibrated) known.calibrated = stated.calibrated;
  }
}

/// Notes an error for a calibration that changes a reading within the usual range of a chamber by more than 10 K, such
/// as one with exchanged coefficients, or with an offset from kelvins.
void check_correction(const TomlTable& table, const char* key, const std::vector<double>& coefficients) {
  constexpr double kMostCorrection_k = 10;
  for (const double reading : {-40.0, 0.0, 25.0, 85.0}) {
    double corrected = 0;
    for (auto c = coefficients.rbegin(); c != coefficients.rend(); ++c) corrected = corrected * reading + *c;
    if (std::abs(corrected - reading) <= kMostCorrection_k) continue;
    return table.note_error(key,
                            fmt::format("makes {:g} °C out of a reading of {:g} °C, expected a correction of at most "
                                        "{:g} K",
                                        corrected, reading, kMostCorrection_k));
  }
}

void read_calibration(const TomlTable& table, const std::string& folder, ThermometerSettings& settings) {
  auto& channels = settings.calibrated;
  const auto name = table.text("channel");
  const auto found = std::find_if(channels.begin(), channels.end(), [&](const auto& c) { return c.name == name; });
  if (found == channels.end()) {
    if (!name.empty()) table.note_error("channel", fmt::format("\"{}\" is not a channel of this thermometer", name));
    for (const auto* key : {"offset", "polynomial", "certificate", "due", "uncertainty", "coverage_factor",
                            "distribution", "drift_k_per_year", "calibrated", "serial_number"})
      table.ignore(key);
    return;
  }
  if (table.has("offset") && table.has("polynomial"))
    table.note_error("offset", "a polynomial includes the offset: expected one of the two");
  const bool is_first = settings.individually_calibrated.insert(name).second;
  if (!is_first || found->offset != Kelvins{} || !found->polynomial.empty())
    table.note_error("channel", fmt::format("channel \"{}\" has a calibration already", name));
  if (table.has("offset")) found->offset = {table.number("offset")};
  found->polynomial = table.numbers("polynomial");
  if (table.has("polynomial") && (found->polynomial.size() < 2 || found->polynomial.size() > kMaxCoefficients))
    table.note_error("polynomial", fmt::format("expected 2 to {} coefficients, the constant first", kMaxCoefficients));
  if (table.has("offset")) check_correction(table, "offset", {found->offset.value, 1});
  if (table.has("polynomial")) check_correction(table, "polynomial", found->polynomial);
  const auto index = static_cast<std::size_t>(found - channels.begin());
  if (add_certificate_file(table, folder, {index}, settings)) found->certificate = table.text("certificate");
  read_certificate(table, {&*found, 1});
  apply_uncertainty(table, {&*found, 1});
  check_days(table);
}

/// Adds the certificate file of a thermometer for all channels without their own certificate.
void read_common_certificate(const TomlTable& table, const std::string& folder, ThermometerSettings& settings) {
  const auto has_own_values = [](const record::Channel& one) {
    return one.offset != Kelvins{} || !one.polynomial.empty() || one.uncertainty.calibration ||
           one.uncertainty.calibrated;
  };
  std::vector<std::size_t> channels;
  for (std::size_t i = 0; i < settings.calibrated.size(); ++i)
    if (settings.calibrated[i].certificate.empty()) channels.push_back(i);
  const auto all = channels;
  if (!add_certificate_file(table, folder, std::move(channels), settings)) return;
  for (const std::size_t i : all)
    if (const auto& one = settings.calibrated[i]; has_own_values(one))
      table.note_error("certificate", fmt::format("contradicts the calibration of channel \"{}\"", one.name));
}

void read_offsets(const TomlTable& table, std::vector<record::Channel>& channels) {
  const auto offsets = table.numbers("offsets");
  if (!offsets.empty() && !channels.empty() && offsets.size() != channels.size())
    table.note_error("offsets", fmt::format("{} offsets for {} channels", offsets.size(), channels.size()));
  for (std::size_t i = 0; i < std::min(offsets.size(), channels.size()); ++i) {
    channels[i].offset = {offsets[i]};
    check_correction(table, "offsets", {offsets[i], 1});
  }
}

/// Returns "dcon 2 at serial:/dev/ttyUSB0, module 01, input 3"; inputs count from 1.
std::string describe_input(const ThermometerSettings& settings, std::size_t number, std::size_t input) {
  auto name = fmt::format("{} {}", settings.driver, number);
  if (const auto& description = settings.description)
    name = fmt::format("{} {}, thermometer {}", description->unit.vendor, description->unit.name, number);
  const auto instrument = fmt::format("{} at {}", name, settings.line);
  if (settings.kind != Kind::dcon || settings.addresses.empty())
    return fmt::format("{}, input {}", instrument, input + 1);
  const auto module = std::min(input / drivers::kDconInputs, settings.addresses.size() - 1);
  return fmt::format("{}, module {:02X}, input {}", instrument, settings.addresses[module],
                     input % drivers::kDconInputs + 1);
}

void read_channels(const TomlTable& table, std::size_t number, std::set<std::string>& seen,
                   ThermometerSettings& settings) {
  settings.channels = table.texts("channels");
  const bool is_wrong_type = table.has("channels") && !table.is_list("channels");  // noted by texts()
  if (!is_wrong_type && (settings.channels.empty() || settings.channels.size() > count_inputs(settings)))
    table.note_error("channels",
                     fmt::format("{} channels, expected 1 to {}", settings.channels.size(), count_inputs(settings)));
  for (std::size_t i = 0; i < settings.channels.size(); ++i) {
    const auto& name = settings.channels[i];
    if (!seen.insert(name).second) table.note_error("channels", fmt::format("channel \"{}\" is listed twice", name));
    settings.calibrated.push_back({.name = name, .instrument = describe_input(settings, number, i), .offset = {}});
  }
}

}  // namespace

DescriptionReader::DescriptionReader(std::string rig_file, std::vector<std::string> known)
    : rig_file_(std::move(rig_file)), known_(std::move(known)) {}

std::optional<drivers::ThermometerDescription> DescriptionReader::read(const TomlTable& thermometer,
                                                                       const std::string& line) {
  const auto known = next_ < known_.size() ? std::optional(known_[next_]) : std::nullopt;
  ++next_;
  auto description = read_description(thermometer, rig_file_, line, known);
  if (description) return std::move(*description);
  if (outcome_) outcome_ = failure(std::move(description.error()));
  return std::nullopt;
}

ThermometerSettings read_thermometer(const TomlTable& table, const std::string& folder, std::size_t number,
                                     std::set<std::string>& seen, DescriptionReader& descriptions) {
  ThermometerSettings settings;
  settings.place = table.location();
  settings.kind = one_of(drivers::kThermometerDrivers, table, "driver");
  settings.driver = kind_row(settings.kind).name;
  if (settings.kind == Kind::process) {
    read_command(table, folder, settings);
  } else {
    settings.line = table.text("line");
    check_instrument_line(table, settings);
  }
  if (table.has("link") && settings.kind != Kind::text) read_link(table, settings);
  if (settings.kind == Kind::dcon) read_dcon(table, settings);
  if (settings.kind == Kind::text) settings.description = descriptions.read(table, settings.line);
  if (settings.kind == Kind::mcc_usb_temp && table.has("sensor")) settings.sensor = read_sensor(table.table("sensor"));
  read_channels(table, number, seen, settings);
  read_offsets(table, settings.calibrated);
  for (const auto& calibration : table.tables("calibration")) read_calibration(calibration, folder, settings);
  read_common_certificate(table, folder, settings);
  read_certificate(table, settings.calibrated);
  apply_uncertainty(table, settings.calibrated);
  check_days(table);
  return settings;
}

std::unique_ptr<drivers::Thermometer> make_thermometer(const ThermometerSettings& settings, const std::string& place,
                                                       const drivers::Line& line) {
  if (const auto* hid = std::get_if<drivers::HidLine>(&line))
    return make_usb_temp(settings, place,
                         drivers::make_hid_line({drivers::kMccKinds.begin(), drivers::kMccKinds.end()}, hid->serial));
  drivers::LineDefaults defaults{.serial = kind_row(settings.kind).serial};
  if (settings.description) {
    const auto& link = settings.description->unit.link.modbus;
    defaults = {.port = link.port, .serial = link.serial};
  }
  auto stream = make_stream(line, defaults, kConnectWithin);
  if (settings.echo || (settings.description && settings.description->unit.link.modbus.echo))
    stream = drivers::make_echo_stream(
        std::move(stream), nullptr,
        settings.description ? settings.description->unit.link.text.longest_answer : drivers::kUsualStrayBytes);
  return make_thermometer(settings, place, std::move(stream), false);
}

std::unique_ptr<drivers::Thermometer> make_process_thermometer(const ThermometerSettings& settings,
                                                               const std::string& place) {
  auto program = std::make_unique<drivers::ProcessStream>(settings.command);
  auto* const started = program.get();
  return drivers::make_process_thermometer(
      std::move(program), place, {.channels = settings.channels.size(), .end_program = [started] { started->kill(); }});
}

std::unique_ptr<drivers::Thermometer> make_thermometer(const ThermometerSettings& settings, const std::string& place,
                                                       std::unique_ptr<drivers::ByteStream> stream, bool simulated,
                                                       const Clock* clock) {
  if (settings.kind == Kind::process)
    return drivers::make_process_thermometer(std::move(stream), place,
                                             {.channels = settings.channels.size(), .clock = clock});
  if (settings.description) {
    auto description = *settings.description;
    auto& wire = description.unit.link.text;
    if (simulated) wire.after_read = wire.after_write = {};
    return drivers::make_text_thermometer(std::move(description), std::move(stream), place, clock);
  }
  if (const auto make = kind_row(settings.kind).make) return make(std::move(stream), place, clock, simulated);
  drivers::DconOptions options{.checksum = settings.checksum, .type = settings.type, .clock = clock};
  if (simulated) options.pause = {};
  return make_dcon_modules(std::move(stream), place, settings.addresses, options);
}

std::unique_ptr<drivers::Thermometer> make_usb_temp(const ThermometerSettings& settings, const std::string& place,
                                                    std::unique_ptr<drivers::HidReports> reports, const Clock* clock) {
  drivers::MccOptions options{.clock = clock};
  for (std::size_t i = 0; i < std::min(settings.channels.size(), drivers::kMccInputs); ++i)
    options.sensors[i] = settings.sensor;
  return make_mcc_usb_temp(std::move(reports), place, options);
}

}  // namespace gyrotherm::rig
