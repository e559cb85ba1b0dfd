// SPDX-License-Identifier: Apache-2.0
/// Checks whether a run is possible here: the machine, the connected devices, and the lines of a rig. A line may be
/// opened; nothing is written to it.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <iterator>
#include <optional>
#include <set>
#include <string>
#include <variant>
#include <vector>

#include "apps/console/command.hpp"
#include "apps/gyrotherm/devices.hpp"
#include "apps/gyrotherm/machine_checks.hpp"
#include "apps/gyrotherm/rig_source.hpp"
#include "apps/gyrotherm/run/readiness.hpp"
#include "core/json.hpp"
#include "drivers/chamber/chamber_lock.hpp"
#include "drivers/line/hid_line.hpp"
#include "drivers/line/line_address.hpp"
#include "sequencer/rig/rig_file.hpp"
#include "sequencer/run/chamber_ownership.hpp"

namespace gyrotherm::app {
namespace {

struct DoctorArguments {
  std::string rig, folder = ".";
};

constexpr auto kConnectTimeout = std::chrono::seconds(2);

Finding check_tcp(drivers::TcpLine line, std::uint16_t usual_port) {
  if (line.port == 0) line.port = usual_port;
  const auto stream = drivers::make_stream(line, {}, kConnectTimeout);
  const auto address = text(drivers::Line(line));
  if (const auto opened = stream->write({}, kConnectTimeout); !opened)
    return {"", FindingState::fault, text(opened.error()),
            fmt::format("check power, cable and address (ping {}); the display of the instrument shows its "
                        "address",
                        line.host)};
  return {"", FindingState::ok, address + " accepts a connection", ""};
}

Finding check_serial(const drivers::SerialLine& line) {
  if (std::error_code error; !std::filesystem::exists(line.device, error))
    return {"", FindingState::fault, line.device + " does not exist",
            "plug in the adapter; gyrotherm devices lists the connected ones"};
  const auto node = node_at(line.device);
  if (!node.allowed)
    return {"", FindingState::fault, fmt::format("{} may not be opened by this user", line.device),
            serial_access_command(node)};
  if (const auto why = unstable_name(text(drivers::Line(line))); !why.empty())
    return {"", FindingState::warning, why, "write the stable name into the rig file"};
  return {"", FindingState::ok, line.device + " may be opened", ""};
}

Finding check_hid(const drivers::HidLine& line, const std::vector<Device>& devices) {
  std::vector<Device> matching;
  for (const auto& device : devices)
    if (!device.driver.empty() && (line.serial.empty() || device.serial == line.serial)) matching.push_back(device);
  if (matching.empty())
    return {"", FindingState::fault,
            line.serial.empty() ? "the device is not plugged in" : line.serial + " is not plugged in",
            "plug it in; gyrotherm devices lists the connected ones"};
  const auto& device = matching.front();
  if (!device.node.allowed)
    return {"", FindingState::fault, device.node.path + " may not be opened by this user", device.fix};
  return {"", FindingState::ok, device.node.path + " may be opened", ""};
}

/// Checks that the program exists and may be run. Does not start it, because its effects are unknown.
Finding check_program(const drivers::ProgramCommand& program) {
  const auto found = find_program(program);
  if (!found)
    return {
        "", FindingState::fault, text(found.error()),
        fmt::format("install it or make it executable; `command` in the rig file is relative to {}", program.folder)};
  return {"", FindingState::ok, *found + " is executable", ""};
}

Finding check_line(const ConnectedInstrument& connected, const std::vector<Device>& devices) {
  if (!connected.program.words.empty()) return check_program(connected.program);
  const auto line = drivers::parse_line(connected.line);
  if (!line)
    return {"", FindingState::fault, text(line.error()), "gyrotherm check --rig prints the position",
            FaultKind::bad_file};
  if (const auto* tcp = std::get_if<drivers::TcpLine>(&*line)) return check_tcp(*tcp, connected.usual_port);
  if (const auto* serial = std::get_if<drivers::SerialLine>(&*line)) return check_serial(*serial);
  if (const auto* hid = std::get_if<drivers::HidLine>(&*line)) return check_hid(*hid, devices);
  return {"", FindingState::ok, "virtual", ""};
}

/// Checks the lines of a rig. Some instruments accept only one connection, so the lines of an active run are not
/// opened.
std::vector<Finding> check_lines(const rig::RigFile& rig, const std::vector<Device>& devices) {
  if (!rig.simulated)
    if (const auto holder = drivers::ChamberLock::holder(run::chamber_lock_name(rig)))
      return {{"rig", FindingState::warning,
               fmt::format("the chamber is in use by {}; its lines were not tested", holder->words),
               "repeat the test after the run"}};
  std::vector<Finding> findings;
  std::set<std::string> seen;
  for (const auto& connected : instrument_lines(rig)) {
    if (rig.simulated && !seen.insert(connected.line).second) continue;
    auto finding = check_line(connected, devices);
    finding.what = rig.simulated ? "lines" : connected.title;
    findings.push_back(std::move(finding));
  }
  return findings;
}

/// Checks the devices when no rig was named. A port without access is only a warning then, because it may not be
/// needed.
std::vector<Finding> check_devices(const std::vector<Device>& devices) {
  std::vector<Finding> findings;
  for (const auto& device : devices) {
    if (device.line.empty()) continue;
    findings.push_back(
        {device.node.path, device.node.allowed ? FindingState::ok : FindingState::warning,
         device.description + (device.node.allowed ? " may be opened" : " may not be opened by this user"),
         device.fix});
  }
  if (findings.empty())
    findings.push_back({"devices", FindingState::ok, "no serial port and no HID thermometer found", ""});
  return findings;
}

std::vector<Finding> check_calibrations(const rig::RigFile& rig) {
  constexpr const char* kName = "calibrations";
  std::vector<Finding> findings;
  for (auto& sentence : list_overdue(rig))
    findings.push_back(
        {kName, FindingState::warning, std::move(sentence), "calibrate it, or correct \"due\" in the rig file"});
  if (findings.empty()) findings.push_back({kName, FindingState::ok, "none is overdue", ""});
  return findings;
}

void append(std::vector<Finding>& to, std::vector<Finding> more) { std::ranges::move(more, std::back_inserter(to)); }

Result<std::vector<Finding>> run_checks(const DoctorArguments& options) {
  auto findings = check_installation();
  append(findings, check_disk(options.folder));
  findings.push_back(check_clock());
  append(findings, check_limits());
  const auto devices = all_devices();
  append(findings, check_devices(devices));
  append(findings, check_serial_adapters(devices));
  if (options.rig.empty()) return findings;
  const auto rig = load_rig(options.rig);
  if (!rig) return failure(rig.error());
  append(findings, check_lines(*rig, devices));
  append(findings, check_calibrations(*rig));
  return findings;
}

std::string describe(const std::vector<Finding>& findings) {
  std::string words;
  for (const auto& finding : findings) {
    words += fmt::format("{:<8} {:<20} {}\n", finding.state == FindingState::fault ? "FAULT" : name(finding.state),
                         finding.what, finding.found);
    if (!finding.fix.empty()) words += fmt::format("         fix: {}\n", finding.fix);
  }
  return words;
}

Json findings_json(const std::vector<Finding>& findings) {
  auto json = Json::array();
  for (const auto& [what, state, found, fix, kind] : findings)
    json.push_back({{"what", what}, {"state", name(state)}, {"found", found}, {"fix", fix}});
  return {{"schema", "gyrotherm-doctor/1"}, {"findings", json}};
}

Result<Exit> doctor(Console& console, const DoctorArguments& options) {
  const auto findings = run_checks(options);
  if (!findings) return failure(findings.error());
  console.print_report(console.json ? json_text(findings_json(*findings)) + "\n" : describe(*findings));
  const auto first = std::ranges::find(*findings, FindingState::fault, &Finding::state);
  if (first == findings->end()) return Exit::done;
  const auto faults = std::ranges::count(*findings, FindingState::fault, &Finding::state);
  return failure(first->kind, first->what,
                 first->found + (faults > 1 ? fmt::format(" (and {} more)", faults - 1) : std::string()));
}

}  // namespace

void add_doctor(Program& program) {
  auto [command, options] =
      add_command(program, "doctor",
                  "Checks whether this machine is ready for a run, and prints a fix for each problem: installation, "
                  "disk, clock, limits, permissions, programs that disturb serial adapters, and the lines and "
                  "calibrations of a rig. It writes to no instrument.",
                  "gyrotherm doctor --rig virtual --folder .", doctor);
  command.add_option("--rig", options.rig, "also check the lines and calibrations of this rig")->type_name(value::kRig);
  command.add_option("--folder", options.folder, "folder for records (default: current folder)")
      ->type_name(value::kFolder);
}

}  // namespace gyrotherm::app
