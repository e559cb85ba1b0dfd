// SPDX-License-Identifier: Apache-2.0
#include "report/comparison.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include "analysis/data/dataset.hpp"
#include "core/file.hpp"
#include "report/document.hpp"
#include "tests/support/check_study.hpp"
#include "tests/support/sample_calibration.hpp"

namespace gyrotherm::report {
namespace {

/// Returns a report of the same unit one year later. The bias of each hold is greater by 0.01 °/h, and the model as
/// found is the previous model as left.
CalibrationReport a_year_later() {
  CalibrationReport now = sample_calibration();
  now.number = "C-2027-0042";
  now.begun = "2027-11-10";
  for (UsedFile& file : now.files) {
    if (file.role == "model_left") file.role = "model_found";
    if (file.role == "record" && !file.started_utc.empty()) file.started_utc.replace(0, 4, "2027");
  }
  for (ResultTable& table : now.results) {
    if (table.key != "stabilised_bias") continue;
    for (Column& column : table.columns)
      if (column.quantity == "bias")
        for (ReportedValue& value : column.values) value.value += 0.01;
  }
  return now;
}

const ComparedResult* find(const Comparison& comparison, const std::string& key, const std::string& condition,
                           Stage before_at) {
  const auto found = std::ranges::find_if(comparison.results, [&](const ComparedResult& one) {
    return one.key == key && one.condition == condition && one.before_at == before_at && one.axis == "u1.x";
  });
  return found == comparison.results.end() ? nullptr : &*found;
}

/// Returns the caution paragraphs of a comparison that contain a text.
std::ptrdiff_t count_cautions(const Comparison& comparison, Language language, const std::string& text) {
  const Document document = make_document(comparison, language);
  return std::ranges::count_if(document.blocks, [&](const Block& block) {
    const auto* paragraph = std::get_if<Paragraph>(&block);
    return paragraph != nullptr && paragraph->style == Paragraph::Style::caution &&
           paragraph->text.find(text) != std::string::npos;
  });
}

TEST(Comparison, StatesReportsThatAreNotValid) {
  CalibrationReport before = sample_calibration(), now = a_year_later();
  const auto valid = compare(before, now);
  ASSERT_TRUE(valid);
  EXPECT_EQ(describe(*valid).find("caution"), std::string::npos);
  EXPECT_EQ(count_cautions(*valid, Language::english, "C-202"), 0);
  before.state = ReportState::superseded;
  now.state = ReportState::draft;
  now.number.clear();
  const auto comparison = compare(before, now);
  ASSERT_TRUE(comparison);
  EXPECT_NE(describe(*comparison).find("caution: C-2026-0042 is superseded"), std::string::npos);
  EXPECT_NE(describe(*comparison).find("caution: a report without a number is a draft"), std::string::npos);
  EXPECT_EQ(count_cautions(*comparison, Language::english, "C-2026-0042 has been replaced"), 1);
  EXPECT_EQ(count_cautions(*comparison, Language::english, "– is a draft"), 1);
  EXPECT_EQ(count_cautions(*comparison, Language::german, "C-2026-0042 ist ersetzt"), 1);
  EXPECT_EQ(count_cautions(*comparison, Language::german, "– ist ein Entwurf"), 1);
  const auto json = nlohmann::json::parse(to_json(*comparison));
  EXPECT_EQ(json["before_state"], "superseded");
  EXPECT_EQ(json["now_state"], "draft");
}

TEST(Comparison, ReturnsChangeWithUncertaintyAndNormalisedError) {
  const auto comparison = compare(sample_calibration(), a_year_later());
  ASSERT_TRUE(comparison) << text(comparison.error());
  EXPECT_EQ(comparison->days_between, 365);
  EXPECT_TRUE(comparison->same_model);
  const ComparedResult* one = find(*comparison, "stabilised_bias", "set_point -40", Stage::uncompensated);
  ASSERT_NE(one, nullptr);
  EXPECT_NEAR(one->change, 0.01, 1e-12);
  // Reference calculation: in both reports u = 0.00031 with 35 degrees of freedom, so Student's t is 2.0301.
  const double u = 0.00031 * 2.0301;
  EXPECT_NEAR(one->expanded, std::sqrt(2.0) * u, 1e-7);
  EXPECT_NEAR(one->normalised_error, 0.01 / (std::sqrt(2.0) * u), 1e-3);
  EXPECT_NEAR(one->in_a_year, 0.01 * 365.25 / 365, 1e-9);
}

TEST(Comparison, ComparesAsLeftWithAsFound) {
  const auto comparison = compare(sample_calibration(), a_year_later());
  ASSERT_TRUE(comparison);
  const ComparedResult* one = find(*comparison, "compensated_mean", "", Stage::as_left);
  ASSERT_NE(one, nullptr);
  EXPECT_EQ(one->now_at, Stage::as_found);
  EXPECT_NEAR(one->change, 0.0131 - 0.002, 1e-12);
}

/// Adds a copy of the record as the second one of its profile, with all measured values greater by `shift`.
void add_second_record(CalibrationReport& report, double shift) {
  const auto first = std::ranges::find(report.files, "record", &UsedFile::role);
  UsedFile second = *first;
  const std::string run = first->id;
  second.id = run + " again";
  report.files.push_back(second);
  const std::vector<ResultTable> tables = report.results;
  for (ResultTable table : tables) {
    if (table.run != run) continue;
    table.run = second.id;
    for (Column& column : table.columns)
      for (ReportedValue& value : column.values)
        if (std::isfinite(value.standard_uncertainty)) value.value += shift;
    report.results.push_back(std::move(table));
  }
}

TEST(Comparison, SkipsRecordOfBothReports) {
  CalibrationReport before = sample_calibration(), now = a_year_later();
  for (CalibrationReport* one : {&before, &now}) one->files.front().profile = "random";
  const auto usual = compare(before, now)->results.size();
  add_second_record(before, 0.1);
  UsedFile shared = before.files.back();
  now.files.push_back(shared);
  for (const ResultTable& table : before.results)
    if (table.run == shared.id) now.results.push_back(table);
  EXPECT_EQ(compare(before, now)->results.size(), usual) << "the second record of both is the same one";
  now.files.back().sha256.back() = '0';
  EXPECT_EQ(compare(before, now)->results.size(), 2 * usual) << "another file";
  now.files = before.files;
  const auto same = compare(before, now);
  ASSERT_TRUE(same) << "both reports have the same records, and nothing else can be compared";
  EXPECT_EQ(same->results.size(), 2 * usual);
}

TEST(Comparison, PairsRecordsOfOneProfileInOrder) {
  CalibrationReport before = sample_calibration(), now = a_year_later();
  for (CalibrationReport* one : {&before, &now}) one->files.front().profile = "random";
  const auto once = compare(before, now);
  ASSERT_TRUE(once);
  add_second_record(before, 0.1);
  EXPECT_EQ(compare(before, now)->results.size(), once->results.size()) << "the second record has no counterpart";
  add_second_record(now, 0.1);
  const auto twice = compare(before, now);
  ASSERT_TRUE(twice);
  ASSERT_EQ(twice->results.size(), 2 * once->results.size());
  for (const ComparedResult& one : once->results)
    EXPECT_EQ(std::ranges::count_if(twice->results,
                                    [&](const ComparedResult& other) {
                                      return other.profile == "random, 2" && other.axis == one.axis &&
                                             other.key == one.key && other.quantity == one.quantity &&
                                             other.condition == one.condition && other.before_at == one.before_at &&
                                             std::abs(other.change - one.change) < 1e-9;
                                    }),
              1)
        << one.key;
  EXPECT_NE(describe(*twice).find(", random, 2, R2 → R2"), std::string::npos);
  const std::string first = std::ranges::find(now.files, "record", &UsedFile::role)->id;
  for (ResultTable& table : now.results)
    if (table.run == first) table.in_sample = true;
  const auto unseen = compare(before, now);
  ASSERT_TRUE(unseen);
  EXPECT_EQ(unseen->results.size(), once->results.size()) << "the records at the same position form the pair";
}

/// Sets the start of a record, by its position.
void set_start(CalibrationReport& report, std::size_t position, const char* utc) {
  for (UsedFile& file : report.files)
    if (file.role == "record" && position-- == 0) file.started_utc = utc;
}

TEST(Comparison, PairsOneRecordForAllResultsOfStage) {
  CalibrationReport before = sample_calibration(), now = a_year_later();
  for (CalibrationReport* one : {&before, &now}) one->files.front().profile = "random";
  add_second_record(before, 0.1);
  set_start(before, 0, "2026-01-01T08:00:00Z");
  set_start(before, 1, "2026-01-31T08:00:00Z");
  set_start(now, 0, "2027-01-01T08:00:00Z");
  const std::string first = std::ranges::find(before.files, "record", &UsedFile::role)->id;
  for (ResultTable& table : before.results)
    if (table.run == first && table.stage == Stage::as_left) table.in_sample = true;
  // Only the second record has this gradient: it is no result of the first pair.
  std::erase_if(before.results, [&](const ResultTable& table) {
    return table.run == first && table.stage == Stage::uncompensated && table.detail == "A-D";
  });
  const auto comparison = compare(before, now);
  ASSERT_TRUE(comparison);
  int uncompensated = 0, as_left = 0;
  for (const ComparedResult& one : comparison->results) {
    if (one.before_record.empty()) continue;  // a result of all records
    const bool is_raw = one.before_at == Stage::uncompensated;
    ++(is_raw ? uncompensated : as_left);
    EXPECT_EQ(one.before_record, is_raw ? "R1" : "R2") << one.key;
    EXPECT_EQ(one.now_record, "") << "the later report has one record";
    EXPECT_EQ(one.days_between, is_raw ? 365 : 335) << one.key;
    EXPECT_NEAR(one.in_a_year, one.change * 365.25 / (is_raw ? 365 : 335), 1e-12);
    EXPECT_EQ(one.profile, "random");
    EXPECT_FALSE(is_raw && one.detail == "A-D");
  }
  EXPECT_GT(uncompensated, 0);
  EXPECT_GT(as_left, 0);
  EXPECT_NE(describe(*comparison).find(", as left → as found, random, R2 → R1, 335 days\n"), std::string::npos)
      << describe(*comparison);
  EXPECT_NE(to_html(make_document(*comparison, Language::english)).find("R2 → R1, 335 days"), std::string::npos);
  EXPECT_NE(to_html(make_document(*comparison, Language::german)).find("R1 → R1, 365 Tage"), std::string::npos);
  const auto json = nlohmann::json::parse(to_json(*comparison));
  EXPECT_EQ(json["results"].back()["before_record"], "R2");
  EXPECT_EQ(json["results"].back()["days_between"], 335);
}

TEST(Comparison, UsesDaysOfReportsWhenStartIsUnknown) {
  CalibrationReport before = sample_calibration(), now = a_year_later();
  set_start(before, 0, "");
  const auto comparison = compare(before, now);
  ASSERT_TRUE(comparison);
  for (const ComparedResult& one : comparison->results) EXPECT_EQ(one.days_between, 365);
}

TEST(Comparison, SkipsConditions) {
  const auto comparison = compare(sample_calibration(), a_year_later());
  ASSERT_TRUE(comparison);
  EXPECT_TRUE(std::ranges::none_of(comparison->results,
                                   [](const ComparedResult& one) { return one.quantity == "temperature"; }));
}

TEST(Comparison, RefusesOtherUnit) {
  CalibrationReport now = a_year_later();
  now.item.serial_number = "0043";
  const auto comparison = compare(sample_calibration(), now);
  ASSERT_FALSE(comparison);
  EXPECT_EQ(comparison.error().kind, FaultKind::usage);
}

/// The Earth rate is not a drift of the gyro.
TEST(Comparison, SkipsBiasWhenReferencesDiffer) {
  CalibrationReport before = sample_calibration(), now = a_year_later();
  const auto expect_no_bias = [&] {
    const auto comparison = compare(before, now);
    ASSERT_TRUE(comparison) << "a standard deviation does not depend on the reference";
    EXPECT_FALSE(comparison->results.empty());
    for (const ComparedResult& one : comparison->results)
      for (const char* quantity : {"bias", "mean", "rmse", "largest", "compensated_bias"})
        EXPECT_NE(one.quantity, quantity) << one.key;
  };
  now.bias_zero = "nothing removed";
  expect_no_bias();
  before.bias_zero = now.bias_zero = data::kOwnReference;  // different references
  expect_no_bias();
}

TEST(Comparison, SkipsValuesWithoutUsableUncertainty) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  const CalibrationReport later = a_year_later();
  const std::size_t all = compare(sample_calibration(), later)->results.size();
  const auto change = [](CalibrationReport report, double value, double u, double k) {
    for (ResultTable& table : report.results)
      for (Column& column : table.columns)
        if (table.key == "stabilised_bias" && column.quantity == "bias")
          for (ReportedValue& one : column.values)
            one = {.value = value, .standard_uncertainty = u, .coverage_factor = k};
    return report;
  };
  for (const auto& [value, u, k] : {std::array{0.1, 0.0, 2.0}, {kNaN, 0.01, 2.0}, {0.1, 0.01, kNaN}}) {
    const auto comparison = compare(change(sample_calibration(), value, u, k), change(later, value, u, k));
    ASSERT_TRUE(comparison);
    EXPECT_LT(comparison->results.size(), all);
    for (const ComparedResult& one : comparison->results) {
      EXPECT_TRUE(std::isfinite(one.normalised_error)) << one.key;
      EXPECT_NE(one.key, "stabilised_bias");
    }
  }
}

/// An unknown E_n hides no exceedance, wherever it is.
TEST(Comparison, SortsUnknownNormalisedErrorLast) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  Comparison comparison;
  for (const double error : {kNaN, 0.5, kNaN, -3.0, 0.0, kNaN, 2.0, kNaN})
    comparison.results.push_back({.normalised_error = error});
  std::vector<double> sorted;
  for (const ComparedResult* one : sort_by_normalised_error(comparison)) sorted.push_back(one->normalised_error);
  EXPECT_EQ(std::vector(sorted.begin(), sorted.begin() + 4), (std::vector{-3.0, 2.0, 0.5, 0.0}));
  EXPECT_EQ(std::ranges::count_if(sorted, [](double one) { return std::isnan(one); }), 4);
  EXPECT_EQ(count_disagreements(comparison), 2u);
}

/// The SQL of the site store cannot use this module. It must have the same list and the same keyword.
TEST(Comparison, HasSameReferenceDependentQuantitiesAsStore) {
  const auto sql = read_text_file(GYROTHERM_SOURCE_DIR "/apps/site/migrations/0001-store.sql");
  ASSERT_TRUE(sql);
  std::smatch list;
  ASSERT_TRUE(std::regex_search(*sql, list, std::regex(R"('quantity' IN \(([^)]*)\) AS depends_on_it)")));
  const std::string quantities = list[1];
  const std::regex quoted("'([^']*)'");
  std::set<std::string> there;
  for (std::sregex_iterator one(quantities.begin(), quantities.end(), quoted), end; one != end; ++one)
    there.insert((*one)[1]);
  EXPECT_EQ(there, std::set<std::string>(kReferenceDependent.begin(), kReferenceDependent.end()));
  ASSERT_TRUE(std::regex_search(*sql, list, std::regex("WHEN n.zero = '([^']*)'")));
  EXPECT_EQ(list[1], std::string(data::kOwnReference));
}

TEST(Comparison, CountsDisagreeingResults) {
  const auto comparison = compare(sample_calibration(), a_year_later());
  ASSERT_TRUE(comparison);
  const std::string text = describe(*comparison);
  EXPECT_NE(text.find("SIMULATED RLG-1 0042: C-2027-0042 against C-2026-0042, 365 days later"), std::string::npos);
  EXPECT_NE(text.find("(|E_n| > 1)"), std::string::npos);
  EXPECT_NE(to_json(*comparison).find("\"schema\": \"gyrotherm-comparison/1\""), std::string::npos);
}

TEST(Comparison, NamesConditionsWithTheirUnit) {
  const auto comparison = compare(sample_calibration(), a_year_later());
  ASSERT_TRUE(comparison);
  EXPECT_NE(describe(*comparison).find("stabilised_bias.bias at set point -40 °C, °/h, "), std::string::npos)
      << describe(*comparison);
  const auto english = to_html(make_document(*comparison, Language::english));
  EXPECT_NE(english.find("Set point −40\u00a0°C"), std::string::npos);
  EXPECT_EQ(english.find("Set point -40"), std::string::npos);
  for (const char* twice : {"Mean compensated bias: Mean compensated bias", "Bias: Bias"})
    EXPECT_EQ(english.find(twice), std::string::npos) << twice;
}

TEST(Comparison, HasPageWithEachChange) {
  const auto comparison = compare(sample_calibration(), a_year_later());
  ASSERT_TRUE(comparison);
  for (const Language language : {Language::english, Language::german}) {
    const Document document = make_document(*comparison, language);
    const std::string page = to_html(document);
    const auto contains = [&](const std::string& text) { return page.find(text) != std::string::npos; };
    for (const ComparedResult& one : comparison->results) {
      EXPECT_TRUE(contains(format(language, change_with_uncertainty(one)))) << one.key;
      EXPECT_TRUE(contains(format_number(language, one.normalised_error, 2))) << one.key;
    }
    EXPECT_TRUE(contains(sentence(language, "title.of", count_disagreements(*comparison), comparison->results.size())));
    EXPECT_TRUE(contains(std::string(translate(language, "mark.simulated"))));
    EXPECT_TRUE(contains("C-2027-0042"));
  }
}

TEST(Comparison, NamesGradientOfSensitivity) {
  const auto comparison = compare(sample_calibration(), a_year_later());
  ASSERT_TRUE(comparison);
  EXPECT_TRUE(std::ranges::any_of(comparison->results, [](const ComparedResult& one) { return one.detail == "A-D"; }));
  EXPECT_NE(to_html(make_document(*comparison, Language::english)).find("Sensitivity to temperature gradients A-D"),
            std::string::npos);
  EXPECT_NE(describe(*comparison).find("gradient_sensitivity.gradient_sensitivity A-D"), std::string::npos);
  EXPECT_NE(to_json(*comparison).find("\"detail\": \"A-D\""), std::string::npos);
}

TEST(Comparison, CountsChangesInSingularAndPlural) {
  auto comparison = compare(sample_calibration(), a_year_later());
  ASSERT_TRUE(comparison);
  const auto all = comparison->results.size();
  ASSERT_GT(all, 2u);
  for (ComparedResult& one : comparison->results) one.normalised_error = 0;
  comparison->results[0].normalised_error = 2;
  EXPECT_NE(
      to_html(make_document(*comparison, Language::english)).find(fmt::format("1 of {} results has changed", all)),
      std::string::npos);
  EXPECT_NE(
      to_html(make_document(*comparison, Language::german)).find(fmt::format("1 von {} Ergebnissen hat sich um", all)),
      std::string::npos);
  EXPECT_NE(describe(*comparison).find(fmt::format("1 of {} results differs by more", all)), std::string::npos);
  comparison->results[1].normalised_error = -3;
  EXPECT_NE(to_html(make_document(*comparison, Language::german)).find(fmt::format("2 von {} Ergebnissen haben", all)),
            std::string::npos);
  EXPECT_NE(describe(*comparison).find(fmt::format("2 of {} results differ by more", all)), std::string::npos);
}

TEST(Comparison, ReportsNoChange) {
  CalibrationReport now = sample_calibration();
  std::erase_if(now.results, [](const ResultTable& table) { return table.stage != Stage::uncompensated; });
  const auto comparison = compare(sample_calibration(), now);
  ASSERT_TRUE(comparison);
  EXPECT_EQ(count_disagreements(*comparison), 0U);
  const std::string page = to_html(make_document(*comparison, Language::english));
  EXPECT_NE(page.find("No result has changed"), std::string::npos);
  EXPECT_EQ(page.find("is not the as-left model of the previous one"), std::string::npos)
      << "values without compensation need no model";
}

/// Returns ten check runs of the rig of the sample reports, one each month of 2027. A
/// thermometer changes with the run `from`, counted from 0.
standard::CheckedStandard monthly_checks(int from, const CalibrationReport& report) {
  auto history = tests::make_history(
      {.golden = tests::GoldenGyro::single, .injected = tests::Injected::thermometer, .runs = 10, .thermometer_k = 0.5},
      3, from);
  history.head.rig = std::ranges::find(report.files, "rig", &UsedFile::role)->name;
  history.head.simulated = report.simulated;
  for (std::size_t run = 0; run < history.checks.size(); ++run)
    history.checks[run].started_utc = fmt::format("2027-{:02}-01T00:00:00Z", run + 1);
  return standard::assess_standard(std::move(history), "h.jsonl");
}

/// Returns both reports with one record and the rig, in May and at the end of August 2027.
std::pair<CalibrationReport, CalibrationReport> reports_of_may_and_august() {
  CalibrationReport before = sample_calibration(), now = a_year_later();
  const auto set_record = [](CalibrationReport& report, const char* utc) {
    std::ranges::find(report.files, "record", &UsedFile::role)->started_utc = utc;
    std::erase_if(report.files, [](const UsedFile& file) { return file.role == "rig"; });
    report.files.push_back({.role = "rig", .name = "hall 4"});
  };
  set_record(before, "2027-05-20T08:00:00Z");
  set_record(now, "2027-08-20T08:00:00Z");
  return {before, now};
}

TEST(Comparison, StatesCheckStandardAtEachRecord) {
  const auto [before, now] = reports_of_may_and_august();
  auto comparison = compare(before, now);
  ASSERT_TRUE(comparison);
  ASSERT_TRUE(add_check_standard(*comparison, before, now, monthly_checks(10, before)));
  ASSERT_EQ(comparison->checked.size(), 2u);
  EXPECT_TRUE(comparison->checked[0].is_before);
  EXPECT_EQ(comparison->checked[0].state, "in_control");
  EXPECT_EQ(comparison->checked[0].checked_before, "2027-05-01T00:00:00Z");
  EXPECT_EQ(comparison->checked[0].checked_after, "2027-06-01T00:00:00Z");
  EXPECT_FALSE(is_check_open(*comparison));
  EXPECT_EQ(describe(*comparison).find("warning"), std::string::npos);
  const auto page = to_html(make_document(*comparison, Language::german));
  EXPECT_NE(page.find("Regelkarten des Prüfnormals"), std::string::npos);
  EXPECT_EQ(page.find("nicht beherrscht, nicht erklärt"), std::string::npos);
}

TEST(Comparison, WarnsOfRecordMadeOutOfControl) {
  const auto [before, now] = reports_of_may_and_august();
  auto comparison = compare(before, now);
  ASSERT_TRUE(comparison);
  ASSERT_TRUE(add_check_standard(*comparison, before, now, monthly_checks(8, before)));
  EXPECT_EQ(comparison->checked[0].state, "in_control");
  EXPECT_EQ(comparison->checked[1].state, "out_of_control") << "after the run of August, before the open one";
  EXPECT_TRUE(is_check_open(*comparison));
  EXPECT_NE(describe(*comparison).find("warning: the check standard"), std::string::npos);
  const auto json = nlohmann::json::parse(to_json(*comparison));
  EXPECT_EQ(json["check_standard"][1]["state"], "out_of_control");
  EXPECT_EQ(json["check_standard"][1]["report"], "now");
  const auto document = make_document(*comparison, Language::english);
  const auto is_warning = [](const Block& block) {
    const auto* paragraph = std::get_if<Paragraph>(&block);
    return paragraph != nullptr && paragraph->style == Paragraph::Style::caution &&
           paragraph->text.find("check standard") != std::string::npos;
  };
  EXPECT_EQ(std::ranges::count_if(document.blocks, is_warning), 1);
}

TEST(Comparison, RefusesHistoryOfOtherRigAndWithoutRuns) {
  const auto [before, now] = reports_of_may_and_august();
  auto comparison = compare(before, now);
  ASSERT_TRUE(comparison);
  EXPECT_FALSE(nlohmann::json::parse(to_json(*comparison)).contains("check_standard"));
  auto other = monthly_checks(10, before), virtual_rig = other, empty = other;
  other.history.head.rig = "hall 5";
  virtual_rig.history.head.simulated = !virtual_rig.history.head.simulated;
  empty.history.checks.clear();
  for (const auto& refused : {other, virtual_rig, empty}) {
    const auto added = add_check_standard(*comparison, before, now, refused);
    ASSERT_FALSE(added);
    EXPECT_EQ(added.error().kind, FaultKind::usage);
    EXPECT_TRUE(comparison->checked.empty());
  }
}

}  // namespace
}  // namespace gyrotherm::report
