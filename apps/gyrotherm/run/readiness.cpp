// SPDX-License-Identifier: Apache-2.0
#include "apps/gyrotherm/run/readiness.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <variant>

#include "acquisition/record/run_info.hpp"
#include "core/clock.hpp"
#include "drivers/line/byte_streams.hpp"
#include "sequencer/prove/make_safe_proof.hpp"
#include "sequencer/prove/proof.hpp"
#include "simulator/laboratory_parameters.hpp"

namespace gyrotherm::app {
namespace {

Finding check_calibrations(const rig::RigFile& rig, Duration utc) {
  const auto channels = list_channels(rig);
  const auto overdue = overdue_calibrations(channels, utc);
  if (overdue.empty()) return {"calibrations", FindingState::ok, fmt::format("0 of {} overdue", channels.size()), ""};
  return {"calibrations", FindingState::warning, fmt::format("{}", fmt::join(overdue, "; ")),
          "renew the certificate, or correct the date in the rig file"};
}

Finding check_limiter(const rig::RigFile& rig) {
  if (!rig.limiter)
    return {"limiter", FindingState::warning, "the rig file does not contain the settings of the chamber's own limiter",
            "add [chamber.limiter]; the limiter is the safety function, this program is not"};
  return {"limiter", FindingState::ok, describe(*rig.limiter) + "; verify these settings on the chamber", ""};
}

Finding check_proofs(const rig::RigFile& rig, Duration utc) {
  const auto state = judge_proofs(rig, prove::find_proofs(rig), utc);
  const auto words = fmt::format("{}", fmt::join(state.lines, "; "));
  if (state.is_valid) return {"proof tests", FindingState::ok, words.empty() ? "passed" : "passed; " + words, ""};
  return {"proof tests", rig.proof.refuses_runs ? FindingState::fault : FindingState::warning, words,
          fmt::format("gyrotherm prove {}", rig.file)};
}

Finding rename_finding(Finding finding, const char* what) {
  finding.what = what;
  return finding;
}

}  // namespace

std::vector<ConnectedInstrument> instrument_lines(const rig::RigFile& rig) {
  std::vector<ConnectedInstrument> lines{{"chamber", rig.chamber_line, rig.chamber_map.link.modbus.port}};
  for (std::size_t i = 0; i < rig.thermometers.size(); ++i)
    lines.push_back({.title = fmt::format("thermometer {}", i + 1),
                     .line = rig.thermometers[i].line,
                     .program = rig.simulated ? drivers::ProgramCommand{} : rig.thermometers[i].command});
  for (const auto& gyro : rig.gyro_lines) lines.push_back({line_title(gyro, rig.units), gyro.line});
  for (std::size_t i = 0; i < rig.analogue_inputs.size(); ++i)
    lines.push_back(
        {rig::analogue_title(i), rig.analogue_inputs[i].line, rig.analogue_inputs[i].map.registers.link.modbus.port});
  for (std::size_t i = 0; i < rig.supplies.size(); ++i)
    lines.push_back({rig::supply_title(i), rig.supplies[i].line, rig.supplies[i].description.unit.link.modbus.port});
  return lines;
}

std::string unstable_name(const std::string& line) {
  const auto parsed = drivers::parse_line(line);
  const auto* serial = parsed ? std::get_if<drivers::SerialLine>(&*parsed) : nullptr;
  if (serial == nullptr || !drivers::has_unstable_name(serial->device)) return {};
  auto stable = *serial;
  stable.device = drivers::stable_name(serial->device);
  return fmt::format("{} depends on the order in which adapters are plugged in, expected {}", serial->device,
                     stable.device.empty() ? "its name in /dev/serial/by-id (\"gyrotherm devices\" lists them)"
                                           : fmt::format("\"{}\"", text(drivers::Line(stable))));
}

std::vector<std::string> list_overdue(const rig::RigFile& rig) {
  return overdue_calibrations(list_channels(rig), rig.simulated ? kVirtualEpoch : SteadyClock().now().utc);
}

std::vector<std::string> list_due_proofs(const rig::RigFile& rig) {
  const auto proofs = prove::find_proofs(rig);
  if (!rig.proof.every && proofs.empty()) return {};
  return judge_proofs(rig, proofs, SteadyClock().now().utc).lines;
}

Result<void> check_protection(const rig::RigFile& rig) {
  if (rig.simulated) return {};
  if (const auto why = prove::relay_refusal_reason(rig, rig.file); !why.empty())
    return failure(FaultKind::refused, rig.file, why);
  if (!rig.proof.refuses_runs) return {};
  const auto state = judge_proofs(rig, prove::find_proofs(rig), SteadyClock().now().utc);
  if (state.is_valid) return {};
  return failure(
      FaultKind::refused, rig.file,
      fmt::format("[policy] proof = \"refuse\": {}; \"gyrotherm prove {}\"", fmt::join(state.lines, "; "), rig.file));
}

Finding check_bias_zero(const rig::RigFile& rig) {
  std::vector<std::string> unknown;
  std::size_t axes = 0;
  for (const auto& unit : rig.units)
    for (std::size_t i = 0; i < unit.info.axes.size(); ++i, ++axes)
      if (!unit.info.axes[i].earth_rate) unknown.push_back(axis_label(unit.info, i));
  if (unknown.empty())
    return {"bias reference", FindingState::ok, fmt::format("Earth rate is known on {} of {} axes", axes, axes), ""};
  return {"bias reference", FindingState::warning,
          fmt::format("Earth rate of {} is unknown; the mean of the first hold becomes the bias reference",
                      fmt::join(unknown, ", ")),
          "add latitude to [gyro] or [fixture] of the rig file"};
}

std::vector<Finding> check_readiness(const rig::RigFile& rig, const std::string& record, Duration utc) {
  std::vector<Finding> findings{check_bias_zero(rig), check_calibrations(rig, utc)};
  if (!rig.simulated) findings.push_back(check_limiter(rig));
  if (!rig.simulated && rig.proof.every) findings.push_back(check_proofs(rig, utc));
  const auto parent = std::filesystem::path(record).parent_path().string();
  for (auto& finding : check_disk(parent.empty() ? "." : parent))
    if (finding.what == "disk") findings.push_back(rename_finding(std::move(finding), "disk"));
  if (rig.simulated) return findings;
  for (auto& finding : check_installation())
    if (finding.what == "gyrotherm-make-safe") findings.push_back(rename_finding(std::move(finding), "guard"));
  return findings;
}

void print_readiness(Console& console, const rig::RigFile& rig, const std::vector<Finding>& findings) {
  const auto is_bad = [](const Finding& finding) { return finding.state != FindingState::ok; };
  const auto warnings = std::ranges::count_if(findings, is_bad);
  const bool no_go = std::ranges::any_of(findings, [](const auto& one) { return one.state == FindingState::fault; });
  for (const auto& finding : findings) {
    if (rig.simulated && !is_bad(finding)) continue;
    const auto* level = finding.state == FindingState::ok      ? "go"
                        : finding.state == FindingState::fault ? "NO-GO"
                                                               : "WARNING";
    console.print_message(fmt::format("{:<8} {:<17} {}{}", level, finding.what, finding.found,
                                      finding.fix.empty() ? "" : "; " + finding.fix));
  }
  if (rig.simulated) return;
  console.print_message(no_go           ? std::string("NO-GO: expect this run to fail")
                        : warnings == 0 ? std::string("GO")
                                        : fmt::format("GO WITH {} WARNING{}", warnings, warnings == 1 ? "" : "S"));
}

}  // namespace gyrotherm::app
