// SPDX-License-Identifier: Apache-2.0
/// The calibration report of one unit under test as data, with the contents that ISO/IEC 17025:2017 requires of a
/// calibration certificate (7.8.2 and 7.8.4). The file calibration.json is the single source. Page, PDF, digital
/// certificate (DCC) and tables are views of it and therefore contain the same numbers.
///
/// The data are independent of language: results have keys of the table in words.hpp, and texts of the laboratory are
/// stored unchanged. Numbers are exact doubles; only views round them. This report describes the unit; the report of
/// the experiment (report.hpp) describes how the models were trained.
#pragma once

#include <array>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "analysis/model/budget.hpp"
#include "analysis/model/model.hpp"
#include "analysis/model/verification.hpp"
#include "core/result.hpp"

namespace gyrotherm::report {

inline constexpr const char* kCalibrationSchema = "gyrotherm-calibration/1";

/// A text of the laboratory in English, in German, or in both. A view prints the text in its own language if present,
/// otherwise the text in the other language.
struct Texts {
  std::string en{}, de{};
  [[nodiscard]] bool empty() const { return en.empty() && de.empty(); }
  bool operator==(const Texts&) const = default;
};

/// A laboratory or a customer.
struct Party {
  std::string name{};
  std::vector<std::string> address{};  ///< one street or box per line
  std::string postal_code{}, city{};
  std::string country{};  ///< ISO 3166-1, two letters: "DE"
  std::string email{}, phone{};
};

/// A picture embedded in the report.
struct Logo {
  std::string media_type{};  ///< "image/svg+xml" or "image/png"
  std::string base64{};
};

/// A person with a role: "operator", "reviewer", "authorising".
struct Person {
  std::string name{}, role{}, email{};
};

/// The unit under test.
struct CalibratedItem {
  std::string name{};  ///< unit name in the rig: "u1"
  Texts description{};
  std::string manufacturer{}, model{}, serial_number{};
  std::string customers_number{};
  /// Condition in which the laboratory received the item.
  Texts condition{};
  /// Axis labels such as "u1.x"; "" for an axis without a name.
  std::vector<std::string> axes{};
};

/// An instrument of the calibration, with its certificate and uncertainty.
struct Equipment {
  /// Key of words.hpp: "thermometer", "chamber", "gyro_readout", "analogue_input", "reference".
  std::string role{};
  /// Measured channel such as "A"; empty for an instrument without a channel.
  std::string channel{};
  std::string name{}, serial_number{}, certificate{};
  /// The name by language, if the laboratory states both.
  Texts names{};
  /// SHA-256 of the certificate file from which the calibration was read; empty: not read from a file.
  std::string certificate_sha256{};
  /// Days such as "2026-11-25"; empty if unknown.
  std::string calibrated{}, due{};
  /// Standard uncertainty (k = 1) of a thermometer's calibration and of its drift.
  double standard_uncertainty_k = std::numeric_limits<double>::quiet_NaN();
  double drift_k_in_a_year = std::numeric_limits<double>::quiet_NaN();
  /// True if the calibration was overdue on the day of a run.
  bool overdue{};
};

/// An influence on the results: "relative humidity", 35 to 45 %.
struct Influence {
  /// Key of words.hpp; if empty, `name` is used instead.
  std::string key{};
  Texts name{};
  std::string unit{};
  double low{}, high{};
};

/// A deviation of the run from its plan.
struct Deviation {
  std::string utc{};  ///< "2026-11-25T14:03:07Z"; empty: unknown
  std::string run{};
  /// Key of words.hpp: "gap", "paused", "interlock", "fault", "dropped", "returned", "note", …
  std::string kind{};
  /// Text of the record or of a person, unchanged.
  std::string text{};
  /// The same text by language, if the order states both.
  Texts translations{};
  /// Duration; NaN if unknown.
  double seconds = std::numeric_limits<double>::quiet_NaN();
};

/// A file used to make the report.
struct UsedFile {
  /// Key of words.hpp: "record", "model_found", "model_left", "profile", "rig", "column_map",
  /// "certificate_file".
  std::string role{};
  std::string name{};
  std::string id{};  ///< run id of a record
  std::string sha256{};
  std::string program_version{};  ///< version that wrote the file
  /// Profile name and start of a record.
  std::string profile{};
  std::string started_utc{};
  /// Record only: true if the hash chain of all rows was verified.
  bool chain_verified{};
  /// Stopped or aborted record only: segment in which it ended, from 1, and number of segments of its profile; 0 if the
  /// run was completed.
  int stopped_in_segment{}, segments{};
};

/// A number with its uncertainty.
struct ReportedValue {
  double value = std::numeric_limits<double>::quiet_NaN();
  double standard_uncertainty = std::numeric_limits<double>::quiet_NaN();  ///< u, k = 1; NaN: unknown
  double coverage_factor = std::numeric_limits<double>::quiet_NaN();       ///< k
  double degrees_of_freedom = std::numeric_limits<double>::infinity();     ///< ν_eff
  /// Returns the expanded uncertainty U = k·u for 95 % coverage; NaN if unknown.
  [[nodiscard]] double expanded() const { return coverage_factor * standard_uncertainty; }
};

/// Returns a value with the coverage factor of Student's t. As in a budget, the degrees of freedom are truncated to an
/// integer for this.
[[nodiscard]] ReportedValue value_with_uncertainty(double value, double standard_uncertainty,
                                                   double degrees_of_freedom);

/// One quantity of a result with a value per row.
struct Column {
  /// Key of words.hpp: "bias", "set_point", "temperature_sensitivity".
  std::string quantity{};
  std::string unit{};  ///< "°/h", "°C", "°/√h"; dimensionless: "1"
  std::vector<ReportedValue> values{};
};

/// State of the unit to which a result applies.
enum class Stage {
  uncompensated,
  as_found,  ///< compensated by the model on arrival
  as_left    ///< compensated by the model on departure
};
[[nodiscard]] const char* name(Stage stage);

/// Groups of results in the order of IEEE Std 952-2020 §6.6, as far as a thermal test covers them.
enum class Group { turn_on, warm_up, bias, sensitivity, hysteresis, random_drift, compensation };
[[nodiscard]] const char* name(Group group);

/// A table of results for one axis. All columns have the same length. A single value is a table of one row.
struct ResultTable {
  Group group{};
  /// Key of words.hpp, unique together with axis, stage and run: "stabilised_bias", "allan_coefficients".
  std::string key{};
  /// Axis label; empty for the single unnamed axis of a unit.
  std::string axis{};
  Stage stage{};
  /// Run id; empty for a result from all records.
  std::string run{};
  /// True if the model was fitted to this record (for a result from all records, to one of them). The result is then
  /// not a verification.
  bool in_sample{};
  /// Language-independent addition to the key, such as "A-D" or "hold 3"; may be empty.
  std::string detail{};
  std::vector<Column> columns{};
};

/// Uncertainty budget of the compensated mean of one axis at one stage.
struct ReportedBudget {
  std::string axis{};
  Stage stage{};
  std::string run{};  ///< run id of the averaged record
  model::Budget budget{};
};

/// Rule that decides whether a result meets a limit (ILAC-G8:09/2019).
enum class DecisionRule {
  /// Simple acceptance (4.2.1): a value up to the limit passes if its U is known. The probability of a false acceptance
  /// reaches 50 % at the limit.
  simple,
  /// Guard band (4.2.3): a value up to limit − U passes; between limit − U and limit + U the verdict is conditional.
  guard_band
};
[[nodiscard]] const char* name(DecisionRule rule);

/// Verdicts from best to worst; the order of the enumerators decides the overall verdict, which is the worst one.
enum class Verdict { pass, conditional_pass, conditional_fail, not_known, fail };
[[nodiscard]] const char* name(Verdict verdict);

/// A limit required by the order: the greatest permitted magnitude of a value.
struct ReportedLimit {
  /// KEY.QUANTITY of a result: "compensation.rmse", "stabilised_bias.bias".
  std::string quantity{};
  /// If absent, the limit applies to each stage that has the result.
  std::optional<Stage> stage{};
  double at_most{};
};

/// Comparison of a result with a limit. The value comes from the worst row of the result: the row with the worst
/// verdict and, among those, the lowest probability.
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
  /// Probability that the true magnitude is within the limit, from Student's t; NaN if U is unknown.
  double probability = std::numeric_limits<double>::quiet_NaN();
};

/// Compares a value with a limit by a decision rule. The verdict is not_known if the value is unknown, or if U is
/// unknown and the rule requires it.
[[nodiscard]] Conformity compare_with_limits(const ReportedValue& value, double limit, DecisionRule rule);

/// A model that was evaluated on the same record, for comparison with the model as left.
struct ComparedModel {
  std::string axis{};
  std::string inputs{}, method{};
  double rmse_deg_per_h{}, std_deg_per_h{}, expanded_deg_per_h{};
  bool left{};         ///< model as left
  bool recommended{};  ///< recommended model of the experiment
  bool simple{};       ///< best linear model
};

/// A line of a figure; a NaN interrupts the line.
struct FigureLine {
  std::string key{};
  std::string detail{};  ///< such as thermometer "A"
  Stage stage{};
  std::vector<double> x{}, y{};
  std::vector<double> error{};  ///< standard deviation of y, or empty
};

/// A figure of one axis.
struct FigureData {
  /// Key of words.hpp: "course", "bias_by_temperature", "allan_deviation", "residual".
  std::string key{};
  std::string axis{};
  std::string run{};
  std::string x_key{}, x_unit{}, y_key{}, y_unit{};
  bool logarithmic{};  ///< both axes
  std::vector<FigureLine> lines{};
};

enum class ReportState { draft, authorised, superseded };
[[nodiscard]] const char* name(ReportState state);

/// Name of the authorising person, and the time of authorisation.
struct Authorisation {
  std::string name{}, utc{};
};

/// A report that replaces this one, or that this one replaces.
struct OtherReport {
  std::string number{};
  std::string sha256{};
  Texts reason{};
};

/// Quantities that depend on the bias reference. The store of a site has the same list (apps/site/migrations).
inline constexpr std::array<std::string_view, 5> kReferenceDependent{"bias", "mean", "rmse", "largest",
                                                                     "compensated_bias"};
[[nodiscard]] bool depends_on_bias_reference(std::string_view quantity);

/// Bias reference of an axis in one record.
struct BiasReference {
  std::string axis{}, run{};
  std::string zero{};  ///< "nothing removed"
  bool operator==(const BiasReference&) const = default;
};

/// Block temperatures in the training records of an axis' model. Outside this range the model extrapolates, regardless
/// of the range of the chamber.
struct TrainedRange {
  std::string axis{};
  Stage stage{};                             ///< as_found or as_left
  std::optional<model::BlockRange> block{};  ///< absent: not stated by the model
  bool operator==(const TrainedRange&) const = default;
};

/// Verification of a model by one record of an axis.
struct ModelVerification {
  std::string axis{};
  Stage stage{};  ///< as_found or as_left
  std::string run{};
  model::Verdict verdict{};
  int clusters{};
  /// Clusters with an input outside the trained range.
  int outside{};
  /// Term that is farthest outside, such as "A-D", and its distance relative to its range; empty and 0 if there is
  /// none.
  std::string farthest_term{};
  double farthest{};
  /// Observed coverage of the intervals; absent for a model without an uncertainty, and if the bias reference is a mean
  /// of the record.
  std::optional<model::Coverage> coverage{};
};

struct CalibrationReport {
  /// Number from the order; empty for a draft without one.
  std::string number{};
  ReportState state{};
  std::optional<Authorisation> authorised{};
  std::optional<OtherReport> replaces{}, replaced_by{};
  bool simulated{};  ///< true if any record is simulated
  /// Required keys without a value: "order.toml: customer.name".
  std::vector<std::string> missing{};
  Texts title{};  ///< empty: standard title

  Party laboratory{};
  std::optional<Logo> logo{};
  Party customer{};
  std::vector<Person> people{};
  CalibratedItem item{};
  std::string received{}, begun{}, ended{}, issued{};  ///< days
  std::string place_kind{};                            ///< "laboratory", "customer" or "other"
  Texts place{};
  Texts method{}, traceability{}, remarks{};
  /// Further statements of the laboratory.
  std::vector<Texts> statements{};
  std::vector<Influence> influences{};
  std::vector<Equipment> equipment{};
  std::vector<Deviation> deviations{};

  /// Bias reference common to all axes and records: "earth rate removed".
  std::string bias_zero{};
  /// Bias reference per axis and record, if they differ.
  std::vector<BiasReference> bias_zeros{};
  double cluster_length_s{};
  std::vector<TrainedRange> trained_ranges{};  ///< one per model
  /// One per model and record; empty in reports of earlier builds.
  std::vector<ModelVerification> verifications{};
  /// Thermometers whose mean is the "temperature" of the results; empty in reports of gyrotherm 0.1.0.
  std::vector<std::string> block_thermometers{};
  std::vector<ResultTable> results{};
  std::vector<ReportedBudget> budgets{};
  DecisionRule rule{};
  std::vector<Conformity> conformity{};
  std::vector<ComparedModel> compared{};
  std::vector<FigureData> figures{};
  std::vector<UsedFile> files{};
  std::string program_version{};
};

/// Returns the bias reference of a table; empty if the report does not state it.
[[nodiscard]] const std::string& find_bias_reference(const CalibrationReport& report, const ResultTable& table);
/// Returns true if a quantity of a table contains an unknown constant: it depends on the bias reference, which is a
/// mean of the record itself. Such a value has no uncertainty and cannot be compared with a limit or with another
/// record.
[[nodiscard]] bool has_unknown_zero(const CalibrationReport& report, const ResultTable& table,
                                    std::string_view quantity);
/// Returns true if a result of the report has an unknown zero.
[[nodiscard]] bool has_unknown_zero(const CalibrationReport& report);

/// Returns the worst verdict of the report; nothing if no limits were agreed.
[[nodiscard]] std::optional<Verdict> overall_verdict(const CalibrationReport& report);

/// Returns the results of a group in their order.
[[nodiscard]] std::vector<const ResultTable*> results_in_group(const CalibrationReport& report, Group group);

/// Returns the channels without a calibration certificate among those that measured the temperatures of the results. A
/// certified thermometer without a channel, such as one in `laboratory.toml`, covers all channels. Returns
/// one empty name if the report lists no thermometer. A result is metrologically traceable only if the list is empty.
[[nodiscard]] std::vector<std::string> find_uncertified_thermometers(const CalibrationReport& report);
/// Returns true if the calibration of a thermometer was overdue on the day of a run.
[[nodiscard]] bool has_overdue_thermometer(const CalibrationReport& report);

/// Returns the key of words.hpp for the state of the item to which the results relate. It depends on whether there are
/// results as left.
[[nodiscard]] const char* scope_key(const CalibrationReport& report);

/// Returns the column for a quantity; null if the table has none.
[[nodiscard]] const Column* find_column(const ResultTable& table, std::string_view quantity);

/// Returns calibration.json, ending in a newline. The text depends only on the report.
[[nodiscard]] std::string to_json(const CalibrationReport& report);

/// Reads calibration.json. Fails with bad_file on syntax errors, another schema, a missing key, a wrong type or columns
/// of unequal length.
[[nodiscard]] Result<CalibrationReport> calibration_from_json(std::string_view json, const std::string& file);

/// Returns the results as CSV for other programs, one line per value: the keys of calibration.json, then value, u, k, U
/// = k·u, degrees of freedom and unit. Numbers are exact and have a decimal point; an unknown or infinite number is
/// empty. The first column contains "DRAFT", "SUPERSEDED", "SIMULATED" or two of these marks, or is empty. RFC 4180:
/// lines end in CR LF, and a field with a comma, a quote or a line break is quoted. A text field that a spreadsheet
/// would execute as a formula gets a leading apostrophe.
[[nodiscard]] std::string results_to_csv(const CalibrationReport& report);

}  // namespace gyrotherm::report
