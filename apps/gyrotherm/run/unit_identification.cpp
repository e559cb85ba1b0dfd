// SPDX-License-Identifier: Apache-2.0
#include "apps/gyrotherm/run/unit_identification.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <optional>
#include <set>
#include <system_error>
#include <utility>

#include "acquisition/record/record.hpp"
#include "acquisition/record/record_files.hpp"
#include "acquisition/record/status.hpp"
#include "apps/gyrotherm/run/remote_prompt.hpp"
#include "core/file.hpp"
#include "core/text.hpp"
#include "report/order.hpp"
#include "sequencer/rig/unit_serials.hpp"

namespace gyrotherm::app {
namespace {

namespace fs = std::filesystem;

/// Answer for an empty position. An empty text has the same meaning on a terminal only.
constexpr const char* kEmptyPosition = "-";

report::CalibratedItem as_item(const record::UnitInfo& unit) {
  return {.name = unit.name, .model = unit.model, .serial_number = unit.serial_number};
}

/// The order of a run, with its file; neither without --order.
struct Order {
  std::string file;
  std::optional<report::OrderFile> content;
};

Result<Order> read_order(const std::string& file) {
  if (file.empty()) return Order{};
  return read_text_file(file)
      .and_then([&](const std::string& text) { return report::parse_order(text, file); })
      .map([&](report::OrderFile content) {
        return Order{file, std::move(content)};
      });
}

/// Checks one unit against the order.
Result<void> check_in_order(const Order& order, const record::UnitInfo& unit, const std::string& from) {
  return order.content ? report::check_units(*order.content, {as_item(unit)}, from) : Result<void>{};
}

Result<void> apply_options(rig::RigFile& rig, const std::vector<std::string>& units) {
  for (const auto& text : units) {
    const auto serial = rig::parse_unit_serial(text, rig);
    if (!serial) return failure(serial.error());
    if (auto taken = identify_unit(rig, *serial); !taken) return taken;
  }
  return {};
}

/// Takes the serial numbers of the units that the order names by their position, or that of the only unit.
Result<void> take_serials_of_order(rig::RigFile& rig, const Order& order) {
  if (!order.content) return {};
  for (const auto& name : find_unidentified(rig)) {
    const auto* ordered = report::find_ordered_unit(*order.content, {.name = name});
    if (ordered == nullptr || ordered->item.serial_number.empty()) continue;
    if (ordered->name.empty() && rig.units.size() > 1) continue;
    if (auto taken = identify_unit(rig, {name, ordered->item.serial_number}); !taken) return taken;
  }
  return {};
}

/// Takes the models that the order states and the rig file leaves open.
void take_models_of_order(rig::RigFile& rig, const Order& order) {
  for (auto& unit : rig.units) {
    if (!order.content || unit.info.serial_number.empty() || !unit.info.model.empty()) continue;
    if (const auto* ordered = report::find_ordered_unit(*order.content, as_item(unit.info)))
      unit.info.model = ordered->item.model;
  }
}

Fault missing_serials_fault(const rig::RigFile& rig, const std::vector<std::string>& names) {
  std::string options;
  for (const auto& name : names) options += fmt::format(" --unit {}=SERIAL", name);
  return {FaultKind::usage, rig.file,
          fmt::format("no serial number for {}, expected{}{}; --wait-for-units asks on the live page",
                      fmt::join(names, ", "), options,
                      rig.units.size() > 1 ? ", without SERIAL for an empty position" : "")};
}

/// Applies the answer to a prompt. Fails without a change if it is not valid for the rig and the order.
Result<void> apply_answer(rig::RigFile& rig, const Order& order, const std::string& name, const std::string& answer) {
  const bool is_empty = trimmed(answer, " \t\r\n") == kEmptyPosition;
  const auto serial = rig::parse_unit_serial(name + "=" + (is_empty ? "" : answer), rig);
  if (!serial) return failure(serial.error());
  auto identified = rig;
  if (auto taken = identify_unit(identified, *serial); !taken) return taken;
  for (const auto& unit : list_units_in_use(identified))
    if (auto ordered = unit.name == name ? check_in_order(order, unit, "this answer") : Result<void>{}; !ordered)
      return ordered;
  rig = std::move(identified);
  return {};
}

/// Asks for the serial number of a unit until an answer is valid. Fails with usage at the end of the input.
Result<void> ask_for_serial(Console& console, rig::RigFile& rig, const Order& order, const std::string& name) {
  const auto question = rig.units.size() == 1
                            ? std::string("serial number of the unit (scan or type): ")
                            : fmt::format("position {}: serial number (scan or type; empty: no unit): ", name);
  for (;;) {
    const auto answer = console.ask(question);
    if (!answer) return failure(missing_serials_fault(rig, find_unidentified(rig)));
    const auto applied = apply_answer(rig, order, name, *answer);
    if (applied) return {};
    console.print_message(applied.error().what);
  }
}

/// Asks for the serial numbers on the live page.
Result<void> ask_on_page(Console& console, rig::RigFile& rig, const Order& order, const std::string& record) {
  const auto prompt = RemotePrompt::open(console, record, rig.simulated);
  if (!prompt) return failure(prompt.error());
  for (const auto& name : find_unidentified(rig)) {
    const auto question =
        rig.units.size() == 1
            ? std::string("answer with the serial number of the unit")
            : fmt::format("position {}: answer with its serial number, or {} if it is empty", name, kEmptyPosition);
    const auto accept = [&](const std::string& answer) -> Result<std::string> {
      if (trimmed(answer).empty()) return failure(FaultKind::usage, record, question);
      return apply_answer(rig, order, name, answer).map([&] { return fmt::format("{} {}", name, trimmed(answer)); });
    };
    if (auto asked = (*prompt)->ask(question, accept); !asked) return asked;
  }
  return {};
}

/// Asks for each missing serial number, on the terminal or on the page. Fails with usage if neither is possible.
Result<void> complete_serials(Console& console, rig::RigFile& rig, const Order& order,
                              const IdentificationOptions& options, const PlannedRun& run) {
  const auto missing = find_unidentified(rig);
  if (missing.empty()) return {};
  if (options.wait) return ask_on_page(console, rig, order, run.record);
  if (!console.can_ask()) return failure(missing_serials_fault(rig, missing));
  for (const auto& name : missing)
    if (auto asked = ask_for_serial(console, rig, order, name); !asked) return asked;
  return {};
}

/// Checks all units in use that have a serial number against the order.
Result<void> check_all_in_order(const rig::RigFile& rig, const Order& order) {
  for (const auto& unit : list_units_in_use(rig))
    if (auto ordered = unit.serial_number.empty() ? Result<void>{} : check_in_order(order, unit, "this run"); !ordered)
      return ordered;
  return {};
}

/// Adds the records in a folder and in the folders directly below it.
void add_records(const fs::path& folder, std::set<std::string>& records) {
  const auto add = [&](const fs::path& from) {
    for (const auto& path : record::list_records(from.string())) {
      std::error_code error;
      const auto whole = fs::weakly_canonical(path, error);
      records.insert(error ? path : whole.string());
    }
  };
  const auto root = folder.empty() ? fs::path(".") : folder;
  add(root);
  std::error_code error;
  for (fs::directory_iterator at(root, fs::directory_options::skip_permission_denied, error), end; !error && at != end;
       at.increment(error)) {
    std::error_code unknown;
    if (at->is_directory(unknown)) add(at->path());
  }
}

bool is_complete(const std::string& record) {
  const auto status = record::read_status(record);
  return status && status->finished && status->overview.state == RunState::complete;
}

/// Returns a sentence for each unit that has finished a run of the same profile in the same order. Records that cannot
/// be read are ignored.
std::vector<std::string> find_earlier_runs(const rig::RigFile& rig, const Order& order, const PlannedRun& run) {
  std::set<std::string> records;
  add_records(fs::path(order.file).parent_path(), records);
  add_records(run.folder, records);
  std::vector<std::string> found;
  for (const auto& path : records) {
    const auto info = record::read_info(path);
    const bool is_same = info && info->order_number == order.content->number && info->profile_name == run.profile &&
                         info->virtual_rig == rig.simulated;
    if (!is_same || !is_complete(path)) continue;
    for (const auto& unit : list_units_in_use(rig))
      if (!unit.serial_number.empty() &&
          std::ranges::count(info->units, unit.serial_number, &record::UnitInfo::serial_number) > 0)
        found.push_back(fmt::format("{} has finished \"{}\" in the order {}: {}", unit.serial_number, run.profile,
                                    order.content->number, path));
  }
  return found;
}

/// Fails with refused if a unit has finished this run already, unless the operator confirms it.
Result<void> check_is_first(Console& console, const rig::RigFile& rig, const Order& order,
                            const IdentificationOptions& options, const PlannedRun& run) {
  if (!order.content || order.content->number.empty() || options.again) return {};
  for (const auto& sentence : find_earlier_runs(rig, order, run)) {
    const auto answer = console.can_ask() ? console.ask(sentence + "\nrun it again? (y/n): ") : std::nullopt;
    if (!answer || (trimmed(*answer) != "y" && trimmed(*answer) != "yes"))
      return failure(FaultKind::refused, order.file, sentence + "; --again runs it again");
  }
  return {};
}

}  // namespace

void add_unit_option(CLI::App& command, std::vector<std::string>& units) {
  command
      .add_option("--unit", units,
                  "serial number of the unit at a position of the rig, such as u1=0042; u1= for an empty position; "
                  "repeat it for each position")
      ->type_name("POSITION=SERIAL")
      ->allow_extra_args(false);
}

void add_identification_options(CLI::App& command, IdentificationOptions& options) {
  add_unit_option(command, options.units);
  command.add_flag("--wait-for-units", options.wait,
                   "ask for missing serial numbers on the live page, or by \"gyrotherm tell RUN.db resume SERIAL\"");
  command.add_flag("--again", options.again,
                   "start although a unit has already finished a run of this profile in the order");
}

Result<void> identify_units(Console& console, rig::RigFile& rig, const IdentificationOptions& options,
                            const PlannedRun& run) {
  const auto order = read_order(options.order);
  if (!order) return failure(order.error());
  if (order->content) rig.identification.order_number = order->content->number;
  auto identified = check_serials_differ(rig).and_then([&] { return apply_options(rig, options.units); });
  if (!identified) return identified;
  // A dry run is simulated and needs no serial numbers.
  if (!rig.simulated)
    identified = take_serials_of_order(rig, *order).and_then([&] { return check_all_in_order(rig, *order); });
  if (!rig.simulated && identified) identified = complete_serials(console, rig, *order, options, run);
  if (identified) identified = check_all_in_order(rig, *order);
  if (identified) identified = check_is_first(console, rig, *order, options, run);
  if (!identified) return identified;
  take_models_of_order(rig, *order);
  if (order->content && order->content->number.empty())
    console.print_message(fmt::format("warning: {} has no number, so the record does not name the order", order->file));
  if (!options.units.empty() || order->content || !rig.simulated)
    console.print_message("units: " + describe_identification(rig));
  return {};
}

Result<void> keep_units_of_record(rig::RigFile& rig, const std::vector<std::string>& units, const std::string& record) {
  const auto info = record::read_info(record);
  if (!info) return failure(info.error());
  for (const auto& text : units)
    if (auto same = rig::parse_unit_serial(text, rig).and_then(
            [&](const rig::UnitSerial& serial) { return rig::compare_with_record(serial, *info, record); });
        !same)
      return same;
  for (const auto& unit : rig.units)
    if (const auto* recorded = record::find_unit(*info, unit.info.name))
      if (!unit.info.serial_number.empty() && unit.info.serial_number != recorded->serial_number)
        return failure(FaultKind::usage, record,
                       fmt::format("contains the serial number {} of {}, but {} gives it {}",
                                   recorded->serial_number.empty() ? "none" : recorded->serial_number, unit.info.name,
                                   rig.file, unit.info.serial_number));
  restore_identification(rig, *info);
  return {};
}

}  // namespace gyrotherm::app
