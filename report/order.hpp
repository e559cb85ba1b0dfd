// SPDX-License-Identifier: Apache-2.0
/// Data that the laboratory provides for a calibration report: laboratory.toml for all orders, and order.toml for one
/// order.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.hpp"
#include "report/calibration.hpp"

namespace gyrotherm::report {

inline constexpr const char* kLaboratorySchema = "gyrotherm-laboratory/1";
inline constexpr const char* kOrderSchema = "gyrotherm-order/1";

/// The laboratory, and the texts common to all of its reports.
struct LaboratoryFile {
  Party party{};
  std::optional<Logo> logo{};
  Texts title{}, method{}, traceability{};
  std::vector<Texts> statements{};
  /// Equipment that the records do not name.
  std::vector<Equipment> equipment{};
  std::vector<Person> people{};
};

/// A unit under test as described by the customer. Empty members are taken from the record.
struct OrderedUnit {
  /// Name in the rig; empty for the only unit, and for a unit that is found by its serial number.
  std::string name{};
  std::string place{};  ///< position: "order.toml:12:1"
  CalibratedItem item{};
};

/// One order: for one unit, or for a lot whose units have separate reports.
struct OrderFile {
  /// Number of the report; a lot appends the name of each unit.
  std::string number{};
  Party customer{};
  std::vector<Person> people{};
  std::vector<OrderedUnit> units{};
  std::string received{}, issued{};
  std::string place_kind{};
  Texts place{}, method{}, remarks{};
  std::vector<Influence> influences{};
  std::vector<Deviation> deviations{};
  DecisionRule rule{};
  std::vector<ReportedLimit> limits{};
  std::optional<OtherReport> replaces{};
};

/// Reads laboratory.toml and the logo that it names, an SVG or PNG of at most 1 MB in the same folder. Fails with
/// bad_file and lists every error with its position.
[[nodiscard]] Result<LaboratoryFile> parse_laboratory(std::string_view toml, const std::string& file);

/// Reads order.toml. Fails with bad_file and lists every error with its position.
[[nodiscard]] Result<OrderFile> parse_order(std::string_view toml, const std::string& file);

/// Returns the unit of an order that describes `item`: the one with its serial number, otherwise the one with its name,
/// otherwise the only unit if it has no name; null if there is none.
[[nodiscard]] const OrderedUnit* find_ordered_unit(const OrderFile& order, const CalibratedItem& item);

/// Checks the units of an order against a record or a rig, named `from`. Fails with bad_file if the model or serial
/// number in the order differs from that in `from`, because an order may only add missing data; if the order lists
/// serial numbers and that of an item is not among them; and if a unit has neither name nor serial number although
/// `from` has several units, because its data would then apply to all of them.
[[nodiscard]] Result<void> check_units(const OrderFile& order, const std::vector<CalibratedItem>& items,
                                       const std::string& from);

/// Adds the texts of the laboratory and the order to the report of a unit, and lists required texts that are missing:
/// "laboratory.toml: name". If a file is missing, all of its keys are listed. Also missing are keys with an example
/// text (is_placeholder()), and persons of the order whose role laboratory.toml does not confirm: only laboratory.toml
/// gives the role authorising, and if it lists operators or reviewers, those of the order must be among them. The
/// persons of a role in the order replace those of the laboratory, except for the role authorising. The model and
/// serial number already in the report have precedence. If the order or the record (`units_in_record`) has several
/// units, the number of the report ends in the serial number or name of the unit, unless the order is for this unit
/// only.
void add_order(CalibrationReport& report, const std::optional<LaboratoryFile>& laboratory,
               const std::optional<OrderFile>& order, std::size_t units_in_record = 1);

/// Returns the days that contradict each other, as texts of `missing`: the unit is received before its calibration
/// begins and before the report is issued, and the report is issued after the calibration ended. In a simulated report
/// they are not missing, because its days come from a virtual clock; the commands print them.
[[nodiscard]] std::vector<std::string> find_wrong_days(const CalibrationReport& report);

/// Returns the days of a report that an authorisation at `now_utc` contradicts: the calibration has not ended, the day
/// of issue is past, or it is more than 31 days ahead. One day after the day of issue is allowed, because that day is
/// in local time.
[[nodiscard]] std::vector<std::string> find_days_against_authorisation(const CalibrationReport& report,
                                                                       const std::string& now_utc);

/// Checks that `by` has the role authorising among these persons. Fails with usage and lists the persons with that
/// role.
[[nodiscard]] Result<void> check_may_authorise(const std::vector<Person>& people, const std::string& by);

/// Returns the comparison of the worst row with a limit: the row with the worst verdict and, among those, the lowest
/// probability; not_known for a column without values. A row with an unknown value is not_known: only a row that fails
/// is worse.
[[nodiscard]] Conformity find_worst_row(const std::vector<ReportedValue>& values, double limit, DecisionRule rule);

/// Returns the verdict on a column of a table: that of its worst row, or not_known without an uncertainty and a
/// probability if the zero of the result is unknown (has_unknown_zero()).
[[nodiscard]] Conformity judge_column(const CalibrationReport& report, const ResultTable& table, const Column& column,
                                      double limit, DecisionRule rule);

/// Compares the results with the limits of an order, row by row. A result gets the verdict of its worst row; among
/// rows with the same verdict, the worst is the one with the lowest probability of conformity. In-sample results are
/// not compared. A result with an unknown zero (has_unknown_zero()) gets the verdict not_known, and so does each axis
/// of the item and stage without a result, unless it has only in-sample results. A limit without any result gets one
/// row per stage.
void apply_limits(CalibrationReport& report, const std::vector<ReportedLimit>& limits, DecisionRule rule);

/// Returns true for a placeholder that must be replaced before authorisation: an unfinished text ("…", "...", "todo",
/// "tbd", "fixme", "xxx"), an address in a domain reserved for examples (RFC 2606), or a name or sentence from the
/// examples in docs/calibration-report.md.
[[nodiscard]] bool is_placeholder(std::string_view text);

/// Returns the placeholders in a report, each with its key: `laboratory.toml: traceability.en, which is the example
/// text "Temperatures are … through …"`.
[[nodiscard]] std::vector<std::string> find_placeholders(const CalibrationReport& report);

}  // namespace gyrotherm::report
