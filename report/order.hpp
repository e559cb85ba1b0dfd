// SPDX-License-Identifier: Apache-2.0
/// What people add to a calibration report: laboratory.toml, which is the laboratory's own and the same for each order,
/// and order.toml, of one order.
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

/// The laboratory, and what it says in each of its reports.
struct LaboratoryFile {
  Party party{};
  std::optional<Logo> logo{};
  Texts title{}, method{}, traceability{};
  std::vector<Texts> statements{};
  std::vector<Equipment> equipment{};  ///< beside what the records name
  std::vector<Person> people{};
};

/// A unit under test as its customer knows it. What is empty is taken from the record.
struct OrderedUnit {
  std::string name{};   ///< in the rig; empty: the only one
  std::string place{};  ///< in its file: "order.toml:12:1"
  CalibratedItem item{};
};

/// One order: of one unit, or of a lot whose units have reports of their own.
struct OrderFile {
  std::string number{};  ///< of the report; of a lot each unit's name is added
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

/// Reads laboratory.toml; a logo that it names is read beside it, SVG or PNG, at most 1 MB. Fails with bad_file, every
/// mistake with its place.
[[nodiscard]] Result<LaboratoryFile> parse_laboratory(std::string_view toml, const std::string& file);

/// Reads order.toml. Fails with bad_file, every mistake with its place.
[[nodiscard]] Result<OrderFile> parse_order(std::string_view toml, const std::string& file);

/// Fails with bad_file if the order names another type or serial number of a unit than `from`, a record or a rig, has:
/// it may only say what that does not; and if it has a unit without a name where there are several to report on, for
/// what it says of one would be said of each.
[[nodiscard]] Result<void> check_units(const OrderFile& order, const std::vector<CalibratedItem>& items,
                                       const std::string& from);

/// Puts what people have written into a report of that unit, and notes what a report must have and they have not
/// written: "laboratory.toml: name". Without a file all of its keys are missing, and so is each key whose text is an
/// example's (is_placeholder()) and each person of the order whose role laboratory.toml does not give: it alone gives
/// the role authorising, and if it names operators or reviewers, the order's are among them. What the report says
/// already of type and serial number stays.
void add_order(CalibrationReport& report, const std::optional<LaboratoryFile>& laboratory,
               const std::optional<OrderFile>& order);

/// Checks that `by` is one of the persons of a report with the role authorising. Fails with usage and their names.
[[nodiscard]] Result<void> check_may_authorise(const CalibrationReport& report, const std::string& by);

/// Holds the results against the limits of an order, each row for itself: the worst verdict stands for all, of equal
/// ones the least probable. Those of a model on a record that it was fitted to are not held against any. A limit of
/// which there is no result is not_known.
void hold_against(CalibrationReport& report, const std::vector<ReportedLimit>& limits, DecisionRule rule);

/// Returns true for a text that was copied from an example and not replaced: an unfinished one ("…", "...", "todo",
/// "tbd", "fixme", "xxx"), an address in the domains reserved for examples (RFC 2606), and the names and sentences of
/// the examples in docs/calibration-report.md.
[[nodiscard]] bool is_placeholder(std::string_view text);

/// Returns the placeholders that a report has, each with the key that it came from:
/// `laboratory.toml: traceability.en, which is "Temperatures are … through …", a text of an example`.
[[nodiscard]] std::vector<std::string> placeholders_in(const CalibrationReport& report);

}  // namespace gyrotherm::report
