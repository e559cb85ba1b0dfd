// SPDX-License-Identifier: Apache-2.0
#include "apps/gyrotherm/new_rig/rig_questions.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <utility>

#include "apps/gyrotherm/new_rig/line_answers.hpp"
#include "core/file.hpp"
#include "core/toml_reader.hpp"
#include "drivers/gyro/frame_sum.hpp"
#include "drivers/thermometer/thermometer_kinds.hpp"

namespace gyrotherm::app {
namespace {

constexpr double kAirMargin_k = 10;

/// Returns "  watlow_f4t         Watlow F4T" for each shipped file of a kind.
std::vector<std::string> describe_shipped(const ShippedKind& kind) {
  std::vector<std::string> lines;
  for (const auto& name : shipped_names(kind)) {
    const auto path = resolve_path(name, kind);
    const auto text = path ? read_text_file(*path) : Result<std::string>(failure(path.error()));
    const auto table = text ? TomlTable::parse(*text, *path) : Result<TomlTable>(failure(text.error()));
    lines.push_back(table ? fmt::format("  {:<22} {} {}", name, table->text("vendor", ""), table->text("name", ""))
                          : "  " + name);
  }
  return lines;
}

std::string describe_other(const char* answer, const char* meaning) {
  return fmt::format("  {:<22} {}", answer, meaning);
}

std::vector<std::string> line_notes(const std::string& serial) {
  std::vector<std::string> notes{"  by network: tcp://A.B.C.D:PORT",
                                 fmt::format("  at a serial port: serial:/dev/NAME?{}", serial)};
  for (const auto& line : list_connected_lines()) notes.push_back("  connected: " + line);
  return notes;
}

std::optional<Question> ask_chamber(const RigAnswers&) {
  Question question{.option = "--chamber", .text = "Chamber", .accept = accept_chamber};
  question.notes = describe_shipped(kShippedChamberMap);
  question.notes.push_back(describe_other(kOtherModbus, "another chamber with Modbus: writes a map to be completed"));
  question.notes.push_back(describe_other(kOtherText, "another chamber with lines of text: likewise"));
  return question;
}

std::optional<Question> ask_chamber_line(const RigAnswers& answers) {
  std::string serial = "9600,8N1";
  if (answers.map)
    for (const auto& link : answers.map->links)
      if (link.kind == drivers::LinkKind::rtu || link.kind == drivers::LinkKind::text_serial)
        serial = text(link.modbus.serial);
  return Question{.option = "--chamber-line",
                  .text = "Line of the chamber",
                  .accept = accept_chamber_line,
                  .notes = line_notes(serial)};
}

std::optional<Question> ask_chamber_unit(const RigAnswers& answers) {
  if (!answers.map || answers.map->text_link) return std::nullopt;
  return Question{.option = "--chamber-unit",
                  .text = "Unit number of the controller on the Modbus",
                  .fallback = std::to_string(answers.map->link.modbus.unit),
                  .accept = accept_chamber_unit};
}

std::optional<Question> ask_lowest(const RigAnswers&) {
  return Question{
      .option = "--lowest", .text = "Lowest set point, °C, for chamber and unit together", .accept = accept_lowest};
}

std::optional<Question> ask_highest(const RigAnswers&) {
  return Question{.option = "--highest", .text = "Highest set point, °C", .accept = accept_highest};
}

std::optional<Question> ask_fastest(const RigAnswers&) {
  return Question{
      .option = "--fastest", .text = "Fastest rate of heating and cooling, °C/min", .accept = accept_fastest};
}

std::optional<Question> ask_safe(const RigAnswers&) {
  return Question{.option = "--safe",
                  .text = "Safe set point, °C, at which an interlock leaves the chamber",
                  .fallback = "20",
                  .accept = accept_safe};
}

/// Returns the default limit of the air beyond a limit of the set points: halfway to the limiter, if that is nearer.
Celsius place_air_limit(Celsius set_point_limit, std::optional<Celsius> limiter, double margin_k) {
  if (limiter && std::abs(limiter->value - set_point_limit.value) < 2 * std::abs(margin_k))
    return {(limiter->value + set_point_limit.value) / 2};
  return {set_point_limit.value + margin_k};
}

std::optional<Question> ask_air(const RigAnswers& answers) {
  const rig::Limiter limiter = answers.limiter.value_or(rig::Limiter{});
  const auto low = place_air_limit(answers.lowest, limiter.lowest, -kAirMargin_k);
  const auto high = place_air_limit(answers.highest, limiter.highest, kAirMargin_k);
  return Question{.option = "--air",
                  .text = "Lowest and highest temperature of the air, °C, at which a run ends",
                  .fallback = fmt::format("{:g} {:g}", low.value, high.value),
                  .accept = accept_air};
}

std::optional<Question> ask_limiter(const RigAnswers&) {
  return Question{
      .option = "--limiter",
      .text = "Class and settings of the chamber's own limiter, or unknown",
      .fallback = kUnknown,
      .accept = accept_limiter,
      .notes = {"  The limiter is the safety function, this program is not. Classes of DIN 12880: 1, 2, 3.1 (highest),",
                "  3.2 (lowest), 3.3 (both). Such as: 3.3 -50 75"}};
}

std::optional<Question> ask_scanner_kind(const RigAnswers& answers) {
  const auto number = answers.scanners.size();
  Question question{.option = kThermometerOption,
                    .text = fmt::format("Thermometer scanner {}", number),
                    .accept = accept_scanner_kind};
  if (number > 1) {
    question.fallback = kNoMore;
    return question;
  }
  for (const auto& row : drivers::kThermometerKinds)
    if (row.kind != drivers::ThermometerKind::text && row.kind != drivers::ThermometerKind::process)
      question.notes.push_back(fmt::format("  {:<22} {} inputs", row.name, row.inputs));
  for (auto& line : describe_shipped(kShippedThermometer)) question.notes.push_back(std::move(line));
  question.notes.push_back(describe_other(kOther, "another scanner: to be completed"));
  return question;
}

std::optional<Question> ask_scanner_line(const RigAnswers& answers) {
  const auto& kind = answers.scanners.back().kind;
  Question question{.option = kThermometerOption, .text = "  its line", .accept = accept_scanner_line};
  if (kind == "mcc_usb_temp") {
    question.fallback = "hid:";
    question.notes = {"  hid:SERIAL, or hid: if only one is connected"};
    return question;
  }
  const auto row = std::ranges::find_if(drivers::kThermometerKinds, [&](const auto& one) { return one.name == kind; });
  question.notes = line_notes(row == drivers::kThermometerKinds.end() ? "9600,8N1" : text(row->serial));
  return question;
}

std::optional<Question> ask_scanner_addresses(const RigAnswers& answers) {
  if (answers.scanners.back().kind != "dcon") return std::nullopt;
  return Question{.option = kThermometerOption,
                  .text = "  addresses of its modules, in the order of the channels",
                  .fallback = "1",
                  .accept = accept_scanner_addresses};
}

std::optional<Question> ask_scanner_type(const RigAnswers& answers) {
  if (answers.scanners.back().kind != "dcon") return std::nullopt;
  return Question{.option = kThermometerOption,
                  .text = "  its thermocouples, J, K, T or E",
                  .fallback = kNone,
                  .accept = accept_scanner_type};
}

std::optional<Question> ask_scanner_channels(const RigAnswers& answers) {
  const auto free = list_free_channels(answers, count_scanner_inputs(answers.scanners.back()));
  Question question{.option = kThermometerOption,
                    .text = "  its channels, in the order of the inputs",
                    .accept = accept_scanner_channels};
  question.notes = {
      "  A to H: positions on the block of a ring laser gyro, A at the cathode and D at the anode; shell: the",
      "  cabinet. A number n stands for the next n letters."};
  if (!free.empty()) question.fallback = fmt::format("{}", fmt::join(free, " "));
  return question;
}

std::optional<Question> ask_gyro(const RigAnswers&) {
  Question question{.option = "--gyro", .text = "Gyro", .accept = accept_gyro};
  question.notes = describe_shipped(kShippedGyroStream);
  question.notes.push_back(describe_other(kOther, "another gyro: to be completed"));
  return question;
}

std::optional<Question> ask_gyro_line(const RigAnswers& answers) {
  return Question{.option = "--gyro-line",
                  .text = "Line of the gyro",
                  .accept = accept_gyro_line,
                  .notes = line_notes(answers.stream ? text(answers.stream->port) : "115200,8N1")};
}

std::optional<Question> ask_axis(const RigAnswers& answers) {
  if (!answers.stream || answers.stream->frame.all_axes.size() < 2) return std::nullopt;
  return Question{.option = "--gyro-axis",
                  .text = fmt::format("Axis to record, {}", fmt::join(answers.stream->frame.all_axes, " ")),
                  .fallback = answers.stream->frame.axes.front(),
                  .accept = accept_axis};
}

std::optional<Question> ask_arcsec_per_pulse(const RigAnswers& answers) {
  if (answers.stream && drivers::arcsec_per_count(answers.stream->frame, 0)) return std::nullopt;
  if (!answers.stream) return std::nullopt;
  return Question{
      .option = "--arcsec-per-pulse", .text = "Angle of one pulse, seconds of arc", .accept = accept_arcsec_per_pulse};
}

std::optional<Question> ask_latitude(const RigAnswers&) {
  return Question{.option = "--latitude",
                  .text = "Latitude, degrees, north positive, or unknown",
                  .accept = accept_latitude,
                  .notes = {"  Without it the Earth rate is unknown, and the bias has no absolute zero."}};
}

std::optional<Question> ask_azimuth(const RigAnswers& answers) {
  if (!answers.latitude) return std::nullopt;
  return Question{.option = "--azimuth",
                  .text = "Input axis: degrees from true north, clockwise",
                  .fallback = "0",
                  .accept = accept_azimuth};
}

std::optional<Question> ask_elevation(const RigAnswers& answers) {
  if (!answers.latitude) return std::nullopt;
  return Question{.option = "--elevation",
                  .text = "Input axis: degrees above the horizontal, 90 is up",
                  .fallback = "90",
                  .accept = accept_elevation};
}

std::optional<Question> ask_serial_number(const RigAnswers&) {
  return Question{.option = "--serial-number",
                  .text = "Serial number of the unit, or none to be asked at each run",
                  .fallback = kNone,
                  .accept = accept_serial_number};
}

std::optional<Question> ask_title(const RigAnswers& answers) {
  const auto chamber = answers.map ? answers.map->vendor + " " + answers.map->name : "chamber";
  const auto gyro = answers.stream ? answers.stream->name : "gyro";
  return Question{.option = "--title",
                  .text = "Title of the rig",
                  .fallback = fmt::format("{}, {} thermometers, {}", chamber, list_channel_names(answers).size(), gyro),
                  .accept = accept_title};
}

constexpr std::array<MakeQuestion, 9> kChamberQuestions{ask_chamber, ask_chamber_line, ask_chamber_unit,
                                                        ask_lowest,  ask_highest,      ask_fastest,
                                                        ask_safe,    ask_limiter,      ask_air};
constexpr std::array<MakeQuestion, 5> kScannerQuestions{ask_scanner_kind, ask_scanner_line, ask_scanner_addresses,
                                                        ask_scanner_type, ask_scanner_channels};
constexpr std::array<MakeQuestion, 9> kGyroQuestions{ask_gyro,     ask_gyro_line, ask_axis,      ask_arcsec_per_pulse,
                                                     ask_latitude, ask_azimuth,   ask_elevation, ask_serial_number,
                                                     ask_title};

}  // namespace

std::span<const MakeQuestion> chamber_questions() { return kChamberQuestions; }
std::span<const MakeQuestion> scanner_questions() { return kScannerQuestions; }
std::span<const MakeQuestion> gyro_questions() { return kGyroQuestions; }

}  // namespace gyrotherm::app
