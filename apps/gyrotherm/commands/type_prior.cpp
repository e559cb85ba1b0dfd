// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <utility>

#include "analysis/model/prior_training.hpp"
#include "apps/console/command.hpp"
#include "apps/gyrotherm/output_file.hpp"
#include "apps/gyrotherm/recorded_run.hpp"
#include "core/file.hpp"

namespace gyrotherm::app {
namespace {

struct TypePriorArguments {
  std::vector<std::string> records;
  std::string out;
  bool force = false, unverified = false;
  data::AxisChoice axis;
  model::PriorOptions prior;
};

/// Record with an optional unit name: "u7=ramp.db".
struct NamedRecord {
  std::string unit;  ///< empty: taken from the record
  std::string path;
};

/// Splits UNIT=RECORD. A "=" after a "/" belongs to the path. Fails with usage if unit or record is empty.
Result<NamedRecord> parse_named_record(const std::string& argument) {
  const auto at = argument.find('=');
  if (at == std::string::npos || argument.find('/') < at) return NamedRecord{{}, argument};
  if (at == 0 || at + 1 == argument.size())
    return failure(FaultKind::usage, "records", fmt::format("\"{}\", expected UNIT=RECORD", argument));
  return NamedRecord{argument.substr(0, at), argument.substr(at + 1)};
}

Result<std::string> unit_name(const NamedRecord& named, const data::Dataset& dataset) {
  if (!named.unit.empty()) return named.unit;
  if (!dataset.identity.empty()) return dataset.identity;
  return failure(FaultKind::usage, named.path,
                 "contains no serial number that identifies the gyro; give it as UNIT=" + named.path);
}

struct SeenRun {
  population::PriorRecord record;
  std::string path;
};

/// Records of all units of a type. Only the samples of the first record are kept.
struct RecordedUnits {
  std::optional<data::Dataset> first;
  std::vector<population::UnitClusters> units;
  std::vector<SeenRun> seen;
  bool simulated{};
};

Result<void> check_unseen(const RecordedUnits& units, const data::Dataset& dataset) {
  for (const auto& [record, path] : units.seen)
    if (record.run_id == dataset.run_id && data::AxisChoice{record.unit, record.axis} == dataset.of)
      return failure(FaultKind::usage, dataset.path, fmt::format("is the same run as {}", path));
  return {};
}

/// Describes a contradiction between the identities of two records and their given names, or returns an empty string.
/// The given names win, because the serial number in a rig file may be wrong; but one gyro counted as two units makes
/// the spread of the type look too small.
std::string contradiction(const population::PriorRecord& a, const population::PriorRecord& b) {
  const bool one_gyro = a.identity == b.identity, one_name = a.name == b.name;
  if (a.identity.empty() || b.identity.empty() || one_gyro == one_name) return {};
  return one_gyro ? fmt::format("the records of \"{}\" and \"{}\" name one gyro ({}), which is counted as two units",
                                a.name, b.name, a.identity)
                  : fmt::format("the records of \"{}\" name two gyros ({} and {})", a.name, a.identity, b.identity);
}

void warn_about_names(Console& console, const RecordedUnits& units) {
  std::set<std::string> reported;
  for (std::size_t i = 0; i < units.seen.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const std::string text = contradiction(units.seen[j].record, units.seen[i].record);
      if (!text.empty() && reported.insert(text).second) console.print_message("warning: " + text);
    }
  }
}

Result<void> add_record(RecordedUnits& units, const NamedRecord& named, data::RecordedRun recorded) {
  data::Dataset& dataset = recorded.dataset;
  if (const auto unseen = check_unseen(units, dataset); !unseen) return unseen;
  if (units.first)
    if (auto one = check_same_reference(dataset, units.first->bias_zero, units.first->path); !one) return one;
  const auto name = unit_name(named, dataset);
  if (!name) return failure(name.error());
  auto unit = std::ranges::find(units.units, *name, &population::UnitClusters::unit);
  if (unit == units.units.end()) unit = units.units.insert(unit, {*name, {}});
  unit->runs.push_back(std::move(recorded.clusters));
  units.simulated = units.simulated || dataset.simulated;
  units.seen.push_back(
      {{*name, dataset.run_id, dataset.of.unit, dataset.of.axis, dataset.identity, dataset.bias_zero}, dataset.path});
  if (!units.first) units.first = std::move(dataset);
  return {};
}

Result<RecordedUnits> load_units(Console& console, const TypePriorArguments& options) {
  RecordedUnits units;
  for (const std::string& argument : options.records) {
    const auto named = parse_named_record(argument);
    if (!named) return failure(named.error());
    auto recorded = load_recorded_run(console, named->path, {{}, options.unverified, options.axis});
    if (!recorded) return failure(recorded.error());
    if (const auto added = add_record(units, *named, std::move(*recorded)); !added) return failure(added.error());
  }
  warn_about_names(console, units);
  return units;
}

std::string describe(const population::TypePrior& prior, const std::vector<population::UnitClusters>& units) {
  constexpr double kSecondsInAnHour = 3600;
  std::string text =
      fmt::format("{}type \"{}\" of {} units\n", prior.simulated ? "SIMULATED: " : "", prior.type, prior.units.size());
  for (const population::UnitClusters& unit : units) {
    double seconds = 0;
    for (const data::Clusters& run : unit.runs) seconds += static_cast<double>(run.start_s.size()) * run.length_s;
    text += fmt::format("  {}: {} record{}, {:.1f} h\n", unit.unit, unit.runs.size(), unit.runs.size() == 1 ? "" : "s",
                        seconds / kSecondsInAnHour);
  }
  text += fmt::format("  {:<14} {:>12} {:>12}  °/h per STD of the input\n", "", "mean", "unit ±");
  const auto row = [&](const std::string& name, Eigen::Index at) {
    text += fmt::format("  {:<14} {:>12.5f} {:>12.5f}\n", name, prior.next_unit.mean(at),
                        std::sqrt(std::max(0.0, prior.next_unit.covariance(at, at))));
  };
  row("constant", 0);
  for (std::size_t k = 0; k < prior.terms.size(); ++k) row(to_string(prior.terms[k]), static_cast<Eigen::Index>(k) + 1);
  text += fmt::format(
      "  unexplained: white noise {:.5f} °/h in a mean over {:g} s, drift {:.5f} °/h with a time constant of {:.1f} h, "
      "turn-on {:.5f} °/h (from the first record)\n",
      prior.noise.white_deg_per_h, prior.cluster_length_s, prior.noise.wander_deg_per_h,
      prior.noise.wander_time_s / kSecondsInAnHour, prior.noise.turn_on_deg_per_h);
  return text;
}

Result<Exit> learn_and_write(Console& console, const TypePriorArguments& options) {
  if (auto free = check_is_free(options.out, options.force); !free) return failure(free.error());
  const auto units = load_units(console, options);
  if (!units) return failure(units.error());
  model::PriorOptions prior_options = options.prior;
  prior_options.simulated = units->simulated;
  auto prior = model::learn_prior(*units->first, units->units, prior_options);
  if (!prior) return failure(prior.error());
  for (const SeenRun& seen : units->seen) prior->records.push_back(seen.record);
  const auto json = to_json(*prior);
  if (auto written = replace_text_file(options.out, json); !written) return failure(written.error());
  console.print_report(console.json ? json : describe(*prior, units->units));
  return Exit::done;
}

}  // namespace

void add_type_prior(Program& program) {
  auto [command, options] = add_command(
      program, "type-prior",
      "Learns a prior from units of one type, so that a few hours of the next unit suffice (train --prior).",
      "gyrotherm type-prior u1/ramp.db u1/random.db u2/ramp.db u3/ramp.db --out prior.json", learn_and_write);
  command
      .add_option("records", options.records,
                  "records of at least three units, each as RECORD or UNIT=RECORD. Without UNIT, records are grouped "
                  "by the serial number of the gyro; virtual records by their seed")
      ->type_name(value::kRecord)
      ->required();
  command.add_option("--out", options.out, "the prior")->check(reject_dash())->type_name(value::kModel)->required();
  add_force_flag(command, options.force);
  command.add_option("--type", options.prior.type, "name of the type, shown in reports")->type_name("NAME");
  command
      .add_option("--inputs", options.prior.inputs,
                  "keywords and terms as for train, except keywords that select (default: seven-point and the "
                  "temperature of the first gradient thermometer)")
      ->type_name("TERMS");
  command.add_flag("--quick", options.prior.quick, "for a trial: omit the correlations of the coefficients");
  add_axis_options(command, options.axis);
  add_unverified_flag(command, options.unverified);
}

}  // namespace gyrotherm::app
