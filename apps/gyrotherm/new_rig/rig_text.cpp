// SPDX-License-Identifier: Apache-2.0
#include "apps/gyrotherm/new_rig/rig_text.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <sstream>

#include "core/shipped.hpp"
#include "core/text.hpp"
#include "core/toml_text.hpp"
#include "drivers/thermometer/thermometer_kinds.hpp"

namespace gyrotherm::app {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kCommentWidth = 100;
constexpr std::size_t kCommentColumn = 34;

/// Returns a line "key = value", with a comment in one column.
std::string key_line(const std::string& key, const std::string& value, const std::string& comment = "") {
  const auto line = fmt::format("{} = {}", key, value);
  return comment.empty() ? line + "\n" : fmt::format("{:<{}}  # {}\n", line, kCommentColumn - 3, comment);
}

std::string celsius(Celsius value) { return fmt::format("\"{:g} °C\"", value.value); }

std::string number(double value) {
  auto text = fmt::format("{}", value);
  return text.find_first_of(".e") == std::string::npos ? text + ".0" : text;
}

/// Returns the text as comments of limited width.
std::string comment_lines(const std::string& text) {
  std::istringstream words(plain(text));
  std::string lines, line = "#";
  for (std::string word; words >> word;) {
    if (line.size() + 1 + word.size() > kCommentWidth && line != "#") {
      lines += line + "\n";
      line = "#  ";
    }
    line += " " + word;
  }
  return lines + line + "\n";
}

std::string note_lines(const std::vector<InstrumentNote>& notes, const std::string& title) {
  std::string lines;
  for (const auto& note : notes)
    if (note.title == title) lines += comment_lines("Probe: " + note.text);
  return lines;
}

/// Returns a path of an answer, which is relative to the working folder, as the rig file names it.
std::string named_in_rig(const RigAnswers& answers, const std::string& given) {
  if (!is_path(given) || fs::path(given).is_absolute()) return toml_quoted(given);
  const auto folder = fs::absolute(answers.file).lexically_normal().parent_path();
  return toml_quoted(fs::absolute(given).lexically_normal().lexically_relative(folder).string());
}

std::string limiter_lines(const RigAnswers& answers) {
  const std::string heading =
      "\n# The chamber's own limiter (DIN 12880: class 1, 2, 3.1, 3.2 or 3.3) is the safety function of the rig; this\n"
      "# program is not. Set it at the chamber, and enter its settings here.\n";
  if (!answers.limiter)
    return heading + fmt::format("# [chamber.limiter]\n# class = \"3.3\"\n# lowest = {}\n# highest = {}\n",
                                 celsius({answers.air_lowest.value}), celsius({answers.air_highest.value}));
  auto lines = heading + "[chamber.limiter]\n" + key_line("class", toml_quoted(answers.limiter->protection_class));
  if (answers.limiter->lowest) lines += key_line("lowest", celsius(*answers.limiter->lowest));
  if (answers.limiter->highest) lines += key_line("highest", celsius(*answers.limiter->highest));
  return lines;
}

/// Returns the settings of the map that a chamber may need, as comments.
std::string map_lines(const RigAnswers& answers) {
  std::string lines;
  if (answers.word_order)
    lines += key_line("word_order", toml_quoted(name(*answers.word_order)), "found by the probe; the map has another");
  if (!answers.map) return lines;
  if (!answers.map->power_switches.empty())
    lines += key_line("# power", toml_quoted(answers.map->power_switches.front().name),
                      "if this output switches the power of the chamber");
  for (const auto& [parameter, value] : answers.map->parameters)
    lines += key_line("# parameter." + parameter, toml_quoted(value), "parameter of the description");
  return lines;
}

std::string chamber_lines(const RigAnswers& answers, const std::vector<InstrumentNote>& notes) {
  const auto own_file = chamber_file_path(answers);
  const auto map =
      own_file.empty() ? named_in_rig(answers, answers.chamber) : toml_quoted(fs::path(own_file).filename().string());
  auto lines = note_lines(notes, "chamber") + "[chamber]\n" +
               key_line("map", map, own_file.empty() ? "" : "complete it: docs/adding-an-instrument.md") +
               key_line("line", toml_quoted(answers.chamber_line)) + map_lines(answers) +
               key_line("lowest", celsius(answers.lowest), "limits of chamber and unit together") +
               key_line("highest", celsius(answers.highest));
  for (const char* key : {"fastest_heating", "fastest_cooling"})
    lines += key_line(key, fmt::format("\"{:g} °C/min\"", answers.fastest.value));
  lines += key_line("safe_set_point", celsius(answers.safe), "set point after an interlock");
  if (answers.chamber_unit && answers.map && *answers.chamber_unit != answers.map->link.modbus.unit)
    lines += "\n[chamber.link]\n" + key_line("unit", std::to_string(*answers.chamber_unit), "number on the bus");
  return lines + limiter_lines(answers);
}

bool is_driver(const std::string& kind) {
  return std::ranges::any_of(drivers::kThermometerKinds, [&](const auto& row) { return row.name == kind; });
}

std::string channel_list(const std::vector<std::string>& channels) {
  std::vector<std::string> quoted;
  for (const auto& channel : channels) quoted.push_back(toml_quoted(channel));
  return fmt::format("[{}]", fmt::join(quoted, ", "));
}

std::string scanner_lines(const RigAnswers& answers, const ScannerAnswer& scanner, const std::string& notes) {
  std::string lines = "\n" + notes + "[[thermometer]]\n";
  if (scanner.kind == kOther)
    lines += key_line("driver",
                      "\"FILL IN: lakeshore_218, dcon, pt12 or mcc_usb_temp; for a description \\\"text\\\" with "
                      "description = \\\"FILE.toml\\\" (docs/adding-an-instrument.md)\"");
  else if (is_driver(scanner.kind))
    lines += key_line("driver", toml_quoted(scanner.kind));
  else
    lines += key_line("driver", "\"text\"") + key_line("description", named_in_rig(answers, scanner.kind));
  lines += key_line("line", toml_quoted(scanner.line));
  if (!scanner.addresses.empty())
    lines += key_line("addresses", fmt::format("[{}]", fmt::join(scanner.addresses, ", ")));
  if (!scanner.type.empty()) lines += key_line("type", toml_quoted(scanner.type));
  lines += key_line("channels", channel_list(scanner.channels));
  return lines + key_line("# uncertainty", "0.04", "K, from the certificate, k = 2") +
         key_line("# certificate", "\"K-2026-0117\"", "its number, and the day on which it ends:") +
         key_line("# due", "\"2027-01-17\"");
}

std::string gyro_lines(const RigAnswers& answers, const std::vector<InstrumentNote>& notes) {
  auto lines = "\n" + note_lines(notes, "gyro") + "[gyro]\n" + key_line("line", toml_quoted(answers.gyro_line));
  if (answers.stream)
    lines += key_line("stream", named_in_rig(answers, answers.gyro));
  else
    lines += key_line("stream",
                      "\"FILL IN: the file that describes the frames of your gyro (docs/adding-an-instrument.md, \\\"A "
                      "gyro\\\")\"");
  if (!answers.axis.empty()) lines += key_line("axis", toml_quoted(answers.axis));
  if (answers.arcsec_per_pulse) lines += key_line("arcsec_per_pulse", number(*answers.arcsec_per_pulse));
  if (answers.latitude) {
    lines += key_line("latitude", number(*answers.latitude), "degrees, for the Earth rate on the input axis") +
             key_line("azimuth", number(answers.azimuth), "degrees, input axis from true north") +
             key_line("elevation", number(answers.elevation), "degrees, above the horizontal");
  } else {
    lines += key_line("# latitude", "47.3769", "degrees; without it the bias has no absolute zero");
  }
  if (!answers.serial_number.empty()) return lines + key_line("serial_number", toml_quoted(answers.serial_number));
  return lines + key_line("# serial_number", "\"0042\"", "without it the program asks at the start of a run");
}

std::string analysis_lines(const RigAnswers& answers) {
  const auto all = list_channel_names(answers);
  const auto has = [&](const char* name) { return std::ranges::find(all, name) != all.end(); };
  std::vector<std::string> on_block;
  std::ranges::copy_if(all, std::back_inserter(on_block), [](const std::string& name) { return name != "shell"; });
  const bool is_enough = on_block.size() >= 2;
  auto lines = "\n[analysis]\n" + key_line("gradients", channel_list(is_enough ? on_block : all));
  if (has("A") && has("D") && has("shell"))
    lines += key_line("three_point", R"(["A", "D", "shell"])", "cathode, anode, shell");
  return lines;
}

constexpr const char* kModbusSkeleton = R"(schema = "gyrotherm-chamber/1"
name = "FILL IN: the model of the controller"
vendor = "FILL IN: its maker"
source = "FILL IN: the manual, its edition and pages"

[link]
unit = 1                         # number of the controller on the bus
timeout = "500 ms"

[link.tcp]
port = 502
[link.rtu]
serial = "9600,8N1"

[[register]]
name = "air_temperature"
address = "FILL IN: the address of the register with the air temperature, a number from 0"
type = "s16"                     # "f32" for two registers with a floating-point number
scale = 0.1                      # tenths of a degree
confidence = "manual"

[[register]]
name = "set_point"
address = "FILL IN: the address of the register with the set point"
type = "s16"
scale = 0.1
access = "rw"
confidence = "manual"

[[register]]
name = "run"
address = "FILL IN: the address of the register that starts and stops the chamber"
type = "u16"
access = "rw"
codes = { stop = 0, start = 1 }  # as in the manual
confidence = "manual"

[identity]                       # better: a register that only this model has
not_verified = ["make and model"]

[control]
commanded = "run"
on = "start"
off = "stop"

# The program sees by the first true [[state]] that the chamber is off or in manual mode. Use the register that shows
# the state if the manual has another one, and add "not_following" for a manual mode and "alarm" or "door_open" for
# what else it shows.
[[state]]
activity = "off"
register = "run"
is = "stop"

[[state]]
activity = "running"
register = "run"
is = "start"

# [[alarm]]                      # for each alarm that the controller reports
# register = "alarms"
# severity = "stop"              # ends a run
# is = "limiter"
)";

constexpr const char* kTextSkeleton = R"(schema = "gyrotherm-text/1"
kind = "chamber"
name = "FILL IN: the model of the controller"
vendor = "FILL IN: its maker"
source = "FILL IN: the manual, its edition and pages"

[link]
question_end = "\r\n"
answer_end = "\r\n"
timeout = "500 ms"

[link.tcp]
port = "FILL IN: the TCP port of the controller; remove [link.tcp] if it has none"
[link.serial]
settings = "9600,8N1"

[identity]
ask = "FILL IN: the question for make and model, such as *IDN?"
pattern = "FILL IN: a part of the answer that only this model has"
confidence = "manual"

[[item]]
name = "air_temperature"
ask = "FILL IN: the question for the air temperature"
answer = "{value:f.1}"
unit = "°C"
confidence = "manual"

[[item]]
name = "set_point"
ask = "FILL IN: the question for the set point"
answer = "{value:f.1}"
tell = "FILL IN: the command for the set point, with {value:f.1} in place of the number"
unit = "°C"
confidence = "manual"

[[item]]
name = "mode"
ask = "FILL IN: the question for the mode"
answer = "{value:s}"
codes = { off = "FILL IN: the answer of a stopped chamber", run = "FILL IN: the answer of a running one" }
confidence = "manual"

[[item]]
name = "run"
tell = "FILL IN: the command that starts the chamber"
acknowledged = "FILL IN: its acknowledgement"
codes = { now = 0 }
confidence = "manual"

[[item]]
name = "stop"
tell = "FILL IN: the command that stops the chamber"
acknowledged = "FILL IN: its acknowledgement"
codes = { now = 0 }
confidence = "manual"

[sequence]
start = [{ write = "run" }, { wait = { item = "mode", is = "run" }, within = "5 s" }]
stop = [{ write = "stop" }, { wait = { item = "mode", is = "off" }, within = "5 s" }]

[[state]]
activity = "running"
item = "mode"
is = "run"
[[state]]
activity = "off"
item = "mode"
is = "off"
)";

std::string limit_lines(const RigAnswers& answers) {
  return "\n# An interlock ends a run outside these limits. docs/interlocks.md lists every limit and "
         "reaction.\n[limits]\n" +
         key_line("air_lowest", celsius(answers.air_lowest)) + key_line("air_highest", celsius(answers.air_highest)) +
         key_line("# thermometers_lowest", celsius(answers.air_lowest), "limits of the unit") +
         key_line("# thermometers_highest", celsius(answers.air_highest));
}

}  // namespace

std::string rig_argument(const std::string& file) { return file.find('/') == std::string::npos ? "./" + file : file; }

std::string write_rig_text(const RigAnswers& answers, const std::vector<InstrumentNote>& notes) {
  const auto name = fs::path(answers.file).stem().string();
  auto text = fmt::format(
      "# Written by gyrotherm new rig. docs/files.md explains every key. The command\n"
      "#   gyrotherm check --rig {} --connect\n"
      "# identifies every instrument; nothing moves.\n"
      "schema = \"gyrotherm-rig/1\"\nname = {}\ntitle = {}\n\n",
      rig_argument(answers.file), toml_quoted(name), toml_quoted(answers.title));
  text += chamber_lines(answers, notes);
  for (std::size_t i = 0; i < answers.scanners.size(); ++i)
    text += scanner_lines(answers, answers.scanners[i], note_lines(notes, fmt::format("thermometer {}", i + 1)));
  return text + gyro_lines(answers, notes) + analysis_lines(answers) + limit_lines(answers) + "\n[safe]\n" +
         key_line("on_stop", "\"safe\"", "state after \"stop\"; \"hold\": unchanged set point") +
         key_line("off", "false", "true: an abort also ends conditioning");
}

std::string write_chamber_text(const RigAnswers& answers) {
  const bool is_modbus = answers.chamber == kOtherModbus;
  return fmt::format(
      "# Description of a chamber that is not listed, written by gyrotherm new rig. Replace each \"FILL IN\" by the "
      "value\n"
      "# in the chamber's manual. docs/adding-an-instrument.md shows the steps, docs/{} the whole format.\n{}",
      is_modbus ? "chamber-maps.md" : "text-instruments.md", is_modbus ? kModbusSkeleton : kTextSkeleton);
}

}  // namespace gyrotherm::app
