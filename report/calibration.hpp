// SPDX-License-Identifier: Apache-2.0
/// The calibration report that a laboratory signs, of one unit under test, as data: what ISO/IEC 17025:2017 asks of a
/// calibration certificate (7.8.2 and 7.8.4). The file calibration.json is the one source; page, PDF, certificate (DCC)
/// and tables are views of it, so that all of them say the same numbers.
///
/// Nothing here is in a language: what the program says of a result is a key of the table of words (words.hpp), what
/// people have written is kept as they wrote it. Numbers are exact doubles; rounding is for views. It is a report of
/// the unit: how the models came to be is the report of the experiment (report.hpp).
#pragma once

#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "analysis/model/budget.hpp"
#include "analysis/model/model.hpp"
#include "core/result.hpp"

namespace gyrotherm::report {

inline constexpr const char* kCalibrationSchema = "gyrotherm-calibration/1";

/// What people wrote, in English, in German, or in both; a view takes its own language, else the other one.
struct Texts {
  std::string en{}, de{};
  [[nodiscard]] bool empty() const { return en.empty() && de.empty(); }
  bool operator==(const Texts&) const = default;
};

/// A laboratory, or its customer.
struct Party {
  std::string name{};
  std::vector<std::string> address{};  ///< street or box, a line each
  std::string postal_code{}, city{};
  std::string country{};  ///< two letters of ISO 3166-1: "DE"
  std::string email{}, phone{};
};

/// A picture that stands in the report itself.
struct Logo {
  std::string media_type{};  ///< "image/svg+xml" or "image/png"
  std::string base64{};
};

/// Somebody, and what they did: "operator", "reviewer", "authorising".
struct Person {
  std::string name{}, role{}, email{};
};

/// What is calibrated.
struct CalibratedItem {
  std::string name{};  ///< of the unit in the rig: "u1", "gyro"
  Texts description{};
  std::string manufacturer{}, model{}, serial_number{};
  std::string customers_number{};   ///< the customer's own; may be empty
  Texts condition{};                ///< as received
  std::vector<std::string> axes{};  ///< their labels: "u1.x"; one that has no name is ""
};

/// An instrument that took part, its certificate and how well it is known.
struct Equipment {
  std::string role{};  ///< a key of words.hpp: "thermometer", "chamber", "gyro_readout", "analogue_input", "reference"
  std::string channel{};  ///< "A"; empty: it measures no channel
  std::string name{}, serial_number{}, certificate{};
  std::string calibrated{}, due{};                                           ///< days, "2026-11-25"; empty: not known
  double standard_uncertainty_k = std::numeric_limits<double>::quiet_NaN();  ///< of a thermometer, k = 1
  double drift_k_in_a_year = std::numeric_limits<double>::quiet_NaN();       ///< … , k = 1
  bool overdue{};                                                            ///< on the day of a run
};

/// Something that influences the results: "relative humidity", 35 to 45 %.
struct Influence {
  std::string key{};  ///< of words.hpp: "air_temperature"; empty: `name` says it
  Texts name{};
  std::string unit{};
  double low{}, high{};
};

/// Where the run was not as planned.
struct Deviation {
  std::string utc{};   ///< "2026-11-25T14:03:07Z"; empty: not known
  std::string run{};   ///< the record's run id
  std::string kind{};  ///< a key of words.hpp: "gap", "paused", "interlock", "fault", "dropped", "returned", "note", …
  std::string text{};                                         ///< as the record has it, or as somebody wrote it
  double seconds = std::numeric_limits<double>::quiet_NaN();  ///< how long, where that is known
};

/// A file that the report rests on.
struct UsedFile {
  std::string role{};  ///< a key of words.hpp: "record", "model_found", "model_left", "profile", "rig"
  std::string name{};  ///< without its folder
  std::string id{};    ///< a record's run id
  std::string sha256{};
  std::string program_version{};  ///< that wrote it
  std::string profile{};          ///< of a record: its name
  std::string started_utc{};      ///< … and when it began
  bool chain_verified{};          ///< a record: every row was seen to be as it was written
};

/// A number and how uncertain it is.
struct ReportedValue {
  double value = std::numeric_limits<double>::quiet_NaN();
  double standard_uncertainty = std::numeric_limits<double>::quiet_NaN();  ///< u, k = 1; NaN: not given
  double coverage_factor = std::numeric_limits<double>::quiet_NaN();       ///< k
  double degrees_of_freedom = std::numeric_limits<double>::infinity();     ///< ν_eff
  /// U = k·u, 95 %; NaN: not given.
  [[nodiscard]] double expanded() const { return coverage_factor * standard_uncertainty; }
};

/// A value whose k is Student's t for its degrees of freedom, cut to a whole number, as in a budget.
[[nodiscard]] ReportedValue with_uncertainty(double value, double standard_uncertainty, double degrees_of_freedom);

/// One quantity of a result, a value for each row.
struct Column {
  std::string quantity{};  ///< a key of words.hpp: "bias", "set_point", "temperature_sensitivity"
  std::string unit{};      ///< "°/h", "°C", "°/√h"; "1" of a mere number
  std::vector<ReportedValue> values{};
};

/// Which state of the unit a result speaks of.
enum class Stage {
  uncompensated,
  as_found,  ///< with the model that the unit came with
  as_left    ///< with the model that it leaves with
};
[[nodiscard]] const char* name(Stage stage);

/// A group of results, in the order of IEEE Std 952-2020 §6.6 as far as a thermal test gives them.
enum class Group { turn_on, warm_up, bias, sensitivity, hysteresis, random_drift, compensation };
[[nodiscard]] const char* name(Group group);

/// A table of one axis: the columns are as long as each other. A single figure is one row.
struct ResultTable {
  Group group{};
  std::string key{};   ///< of words.hpp, and unique with axis, stage and run: "stabilised_bias", "allan_coefficients"
  std::string axis{};  ///< its label; empty of a unit with one axis that has no name
  Stage stage{};
  std::string run{};     ///< run id of its record; empty: of all together
  bool in_sample{};      ///< the model was fitted to this record, or to one of all: no verification
  std::string detail{};  ///< what the key leaves open, in no language: "A-D", "hold 3"; may be empty
  std::vector<Column> columns{};
};

/// The budget behind the compensated mean of one axis at one stage.
struct ReportedBudget {
  std::string axis{};
  Stage stage{};
  std::string run{};  ///< run id of the record whose mean it is of
  model::Budget budget{};
};

/// By what a result is held against a limit (ILAC-G8:09/2019).
enum class DecisionRule {
  simple,     ///< it passes up to the limit, U being known (4.2.1); at it a pass is wrong with 50 % or more
  guard_band  ///< it passes up to the limit less U; between that and the limit plus U conditionally (4.2.3)
};
[[nodiscard]] const char* name(DecisionRule rule);

/// From the best to the worst: where one fails, all together do, whatever is not known of another.
enum class Verdict { pass, conditional_pass, conditional_fail, not_known, fail };
[[nodiscard]] const char* name(Verdict verdict);

/// A limit that the order asks for. The magnitude of a value must not be greater.
struct ReportedLimit {
  std::string quantity{};        ///< KEY.QUANTITY of a result: "compensation.rmse", "stabilised_bias.bias"
  std::optional<Stage> stage{};  ///< nothing: of each stage in which there is one
  double at_most{};
};

/// A result held against a limit: its row that is worst, by verdict and then by probability.
struct Conformity {
  std::string quantity{};
  std::string axis{};
  Stage stage{};
  std::string run{};
  std::string unit{};
  ReportedValue value{};
  double limit{};
  DecisionRule rule{};
  Verdict verdict{};
  /// That the true magnitude is within the limit, by Student's t; NaN: U is not known.
  double probability = std::numeric_limits<double>::quiet_NaN();
};

/// Holds a value against a limit by a rule; not_known without a value, or without U where the rule asks for it.
[[nodiscard]] Conformity held_against(const ReportedValue& value, double limit, DecisionRule rule);

/// A model that was tried on the same record, beside the one that the unit leaves with.
struct ComparedModel {
  std::string axis{};
  std::string inputs{}, method{};
  double rmse_deg_per_h{}, std_deg_per_h{}, expanded_deg_per_h{};
  bool left{};         ///< the unit leaves with this one
  bool recommended{};  ///< by the rule of the experiment
  bool simple{};       ///< the best of the straight planes
};

/// Values that a figure draws; NaN breaks a line.
struct FigureLine {
  std::string key{};     ///< of words.hpp: "temperature", "bias", "compensated"
  std::string detail{};  ///< "A"
  Stage stage{};
  std::vector<double> x{}, y{};
  std::vector<double> error{};  ///< standard deviations of y; empty: none are drawn
};

/// A figure of one axis.
struct FigureData {
  std::string key{};  ///< of words.hpp: "course", "bias_by_temperature", "allan_deviation", "residual"
  std::string axis{};
  std::string run{};
  std::string x_key{}, x_unit{}, y_key{}, y_unit{};
  bool logarithmic{};  ///< both axes
  std::vector<FigureLine> lines{};
};

enum class ReportState { draft, authorised, superseded };
[[nodiscard]] const char* name(ReportState state);

/// Who says that it may be issued, and when.
struct Authorisation {
  std::string name{}, utc{};
};

/// Another report that this one replaces, or is replaced by.
struct OtherReport {
  std::string number{};
  std::string sha256{};  ///< of its calibration.json
  Texts reason{};
};

/// What the bias of an axis is counted from in one record.
struct BiasZero {
  std::string axis{}, run{};
  std::string zero{};  ///< "nothing removed"
  bool operator==(const BiasZero&) const = default;
};

/// The range of the block over which the model of an axis was trained. Beyond it the model extrapolates, whatever air
/// the chamber can make.
struct TrainedRange {
  std::string axis{};
  Stage stage{};                             ///< as_found or as_left
  std::optional<model::BlockRange> block{};  ///< absent: the model does not state it
  bool operator==(const TrainedRange&) const = default;
};

struct CalibrationReport {
  std::string number{};  ///< the order's; of a draft without one empty
  ReportState state{};
  std::optional<Authorisation> authorised{};
  std::optional<OtherReport> replaces{}, replaced_by{};
  bool simulated{};                    ///< any of the records
  std::vector<std::string> missing{};  ///< keys that a report must have: "order.toml: customer.name"
  Texts title{};                       ///< empty: the words' own

  Party laboratory{};
  std::optional<Logo> logo{};
  Party customer{};
  std::vector<Person> people{};
  CalibratedItem item{};
  std::string received{}, begun{}, ended{}, issued{};  ///< days
  std::string place_kind{};                            ///< "laboratory", "customer" or "other"
  Texts place{};
  Texts method{}, traceability{}, remarks{};
  std::vector<Texts> statements{};  ///< further ones of the laboratory
  std::vector<Influence> influences{};
  std::vector<Equipment> equipment{};
  std::vector<Deviation> deviations{};

  std::string bias_zero{};             ///< what all biases are counted from: "earth rate removed"
  std::vector<BiasZero> bias_zeros{};  ///< where they are not counted from the same: what each is
  double cluster_length_s{};
  std::vector<TrainedRange> trained_ranges{};  ///< one per model
  std::vector<ResultTable> results{};
  std::vector<ReportedBudget> budgets{};
  DecisionRule rule{};
  std::vector<Conformity> conformity{};
  std::vector<ComparedModel> compared{};
  std::vector<FigureData> figures{};
  std::vector<UsedFile> files{};
  std::string program_version{};
};

/// The verdict over all: the worst of them; nothing where no limit was given.
[[nodiscard]] std::optional<Verdict> verdict_of(const CalibrationReport& report);

/// The results of a group in their order.
[[nodiscard]] std::vector<const ResultTable*> results_of(const CalibrationReport& report, Group group);

/// The column of a table by its quantity; null if there is none.
[[nodiscard]] const Column* find_column(const ResultTable& table, std::string_view quantity);

/// calibration.json, ending in a newline. Equal reports give equal bytes.
[[nodiscard]] std::string to_json(const CalibrationReport& report);

/// Fails with bad_file on syntax, another schema, a missing key, a wrong type, columns of unequal length.
[[nodiscard]] Result<CalibrationReport> calibration_from_json(std::string_view json, const std::string& file);

/// Returns the results as one table for other programs, a line for each value of each result: its keys as in
/// calibration.json, then value, u, k, U = k·u, degrees of freedom and unit. Numbers are exact, with a point; an
/// unknown or infinite one is empty. The first column is "DRAFT", "SUPERSEDED", "SIMULATED", two of them, or empty.
/// RFC 4180: lines end in CR LF, a field with a comma, a quote or a line break is quoted. A field of text that a
/// spreadsheet would run as a formula begins with an apostrophe.
[[nodiscard]] std::string csv_of(const CalibrationReport& report);

}  // namespace gyrotherm::report
