// SPDX-License-Identifier: Apache-2.0
#include "report/cautions.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "analysis/data/dataset.hpp"
#include "report/dcc.hpp"
#include "report/document.hpp"
#include "tests/support/markup.hpp"
#include "tests/support/sample_calibration.hpp"

namespace gyrotherm::report {
namespace {

constexpr Language kEnglish = Language::english, kGerman = Language::german;

ModelVerification good_verification() { return sample_calibration().verifications.front(); }

TEST(Cautions, AreAbsentFromGoodVerification) {
  for (const Language language : {kEnglish, kGerman}) EXPECT_EQ(describe_cautions(language, good_verification()), "");
  ModelVerification in_sample = good_verification();
  in_sample.verdict.gain = model::Gain::in_sample;
  in_sample.verdict.intervals_hold.reset();
  EXPECT_EQ(describe_cautions(kEnglish, in_sample), "");
}

TEST(Cautions, StateMeansOutsideTrainedRange) {
  ModelVerification one = good_verification();
  one.clusters = 432;
  one.outside = 374;
  EXPECT_TRUE(describe_cautions(kEnglish, one).starts_with("In 374 of 432 means the model was used outside"));
  EXPECT_TRUE(describe_cautions(kEnglish, one).ends_with("U includes the uncertainty of the extrapolation."));
  EXPECT_TRUE(describe_cautions(kGerman, one).starts_with("Bei 374 von 432 Mittelwerten"));
  one.coverage.reset();
  EXPECT_EQ(describe_cautions(kEnglish, one).find("U includes"), std::string::npos) << "a model without U";
}

TEST(Cautions, StateMissingImprovement) {
  ModelVerification one = good_verification();
  one.verdict.gain = model::Gain::does_not_improve;
  EXPECT_EQ(describe_cautions(kEnglish, one), "The model does not reduce the bias of this record.");
  for (const model::Gain gain : {model::Gain::undecided, model::Gain::not_enough_data}) {
    one.verdict.gain = gain;
    EXPECT_EQ(describe_cautions(kEnglish, one), "The record does not show that the model reduces the bias.");
  }
}

TEST(Cautions, StateReducedOffsetAsSuch) {
  ModelVerification one = good_verification();
  one.verdict.gain = model::Gain::undecided;
  one.verdict.only_offset = true;
  EXPECT_EQ(describe_cautions(kEnglish, one),
            "The model reduces only a constant offset of this record, not its variation.");
  EXPECT_EQ(describe_cautions(kGerman, one),
            "Das Modell verringert nur einen konstanten Versatz dieser Aufzeichnung, nicht ihre Streuung.");
  CalibrationReport report = sample_calibration();
  report.verifications.front() = one;
  const auto again = calibration_from_json(to_json(report), "calibration.json");
  ASSERT_TRUE(again) << text(again.error());
  EXPECT_TRUE(again->verifications.front().verdict.only_offset);
  EXPECT_FALSE(again->verifications.back().verdict.only_offset);
}

TEST(Cautions, StateObservedShareOfIntervalsThatDoNotHold) {
  ModelVerification one = good_verification();
  one.verdict.intervals_hold = false;
  one.coverage->seen = 0.7449;
  EXPECT_NE(describe_cautions(kEnglish, one).find("74.5\u00a0% of the means"), std::string::npos);
  EXPECT_NE(describe_cautions(kEnglish, one).find("contain 95\u00a0%"), std::string::npos);
  EXPECT_NE(describe_cautions(kGerman, one).find("74,5\u00a0% der Mittelwerte"), std::string::npos);
  one.verdict.gain = model::Gain::does_not_improve;
  EXPECT_TRUE(describe_cautions(kEnglish, one).starts_with("The model does not reduce"));
}

/// Returns the caution paragraphs before and after the end of the first section.
std::pair<std::vector<std::string>, std::vector<std::string>> caution_paragraphs(const Document& document) {
  std::pair<std::vector<std::string>, std::vector<std::string>> found;
  int sections = 0;
  for (const Block& block : document.blocks) {
    if (const auto* heading = std::get_if<Heading>(&block); heading != nullptr && !heading->sub) ++sections;
    const auto* paragraph = std::get_if<Paragraph>(&block);
    if (paragraph == nullptr || paragraph->style != Paragraph::Style::caution) continue;
    (sections < 2 ? found.first : found.second).push_back(paragraph->text);
  }
  return found;
}

TEST(Cautions, AreOnFirstPageAndAtResults) {
  CalibrationReport report = sample_calibration();
  report.simulated = false;
  report.equipment.clear();
  const auto before = caution_paragraphs(make_document(report, kEnglish));
  EXPECT_TRUE(before.first.empty());
  for (ModelVerification& one : report.verifications) {
    if (one.axis == "u1.y") one.outside = one.stage == Stage::as_left ? 7 : 2160;
  }
  for (const Language language : {kEnglish, kGerman}) {
    const auto [first, later] = caution_paragraphs(make_document(report, language));
    ASSERT_EQ(first.size(), 1u) << "only the last stage is on the first page";
    EXPECT_TRUE(first.front().starts_with("u1.y, "));
    EXPECT_NE(first.front().find(" 7 "), std::string::npos) << first.front();
    EXPECT_EQ(later.size(), before.second.size() + 2);
  }
}

TEST(Cautions, StateStopAndFailedSensorOfRecord) {
  CalibrationReport report = sample_calibration();
  EXPECT_TRUE(list_record_cautions(kEnglish, report).empty());
  const auto record = std::ranges::find(report.files, "record", &UsedFile::role);
  record->stopped_in_segment = 3;
  record->segments = 5;
  const std::string run = record->id;
  report.deviations = {{.run = run, .kind = "note", .text = "warning: the lid was open"},
                       {.run = run, .kind = "note", .text = "the warning: none"},
                       {.run = run, .kind = "alarm", .text = "warning: of an alarm"}};
  const auto english = list_record_cautions(kEnglish, report), german = list_record_cautions(kGerman, report);
  ASSERT_EQ(english.size(), 2u);
  EXPECT_EQ(english[0].text, "The run was stopped in segment 3 of 5. “Whole run” is its part until then.");
  EXPECT_EQ(english[0].run, run);
  EXPECT_EQ(english[1].text, "Warning of the record: the lid was open.");
  EXPECT_EQ(german[0].text,
            "Der Prüflauf wurde in Abschnitt 3 von 5 beendet. „Gesamter Prüflauf“ ist sein Teil bis dahin.");
  EXPECT_EQ(german[1].text, "Warnung der Aufzeichnung: the lid was open.");
  const auto [first, later] = caution_paragraphs(make_document(report, kEnglish));
  for (const RecordCaution& one : english) EXPECT_NE(std::ranges::find(first, one.text), first.end()) << one.text;
  const auto dcc = make_dcc(report, {});
  ASSERT_TRUE(dcc);
  EXPECT_EQ(tests::count_occurrences(*dcc, "Caution about the record"), 2);
  const auto again = calibration_from_json(to_json(report), "calibration.json");
  ASSERT_TRUE(again) << text(again.error());
  EXPECT_EQ(to_json(*again), to_json(report));
  EXPECT_EQ(to_json(sample_calibration()).find("stopped_in_segment"), std::string::npos);
}

TEST(Cautions, StateUnknownZeroOfRecord) {
  CalibrationReport report = sample_calibration();
  const auto records = static_cast<std::size_t>(std::ranges::count(report.files, "record", &UsedFile::role));
  const std::string run = std::ranges::find(report.files, "record", &UsedFile::role)->id;
  report.bias_zero = data::kOwnReference;
  const auto english = list_record_cautions(kEnglish, report), german = list_record_cautions(kGerman, report);
  ASSERT_EQ(english.size(), records);
  ASSERT_EQ(german.size(), records);
  EXPECT_TRUE(
      english.front().text.starts_with("The bias reference is the mean of the record’s own first hold, so the"));
  EXPECT_TRUE(
      german.front().text.starts_with("Bezug der Nullpunktabweichung ist der Mittelwert der ersten Haltephase"));
  for (const Language language : {kEnglish, kGerman}) {
    const Document document = make_document(report, language);
    const auto cautions = caution_paragraphs(document).first;
    EXPECT_TRUE(std::ranges::any_of(cautions, [&](const std::string& one) {
      return one.find(translate(language, "say.unknown_zero")) != std::string::npos;
    }));
    const std::string page = to_html(document);
    EXPECT_NE(page.find(translate(language, "say.no_u_unknown_zero")), std::string::npos);
    EXPECT_EQ(page.find(translate(language, "say.no_u")), std::string::npos);
    const bool is_english = language == kEnglish;
    EXPECT_NE(page.find(is_english ? "the standard deviation is" : "Prüflauf beträgt die Standardabweichung"),
              std::string::npos);
    EXPECT_EQ(page.find(is_english ? "has a mean bias of" : "eine mittlere Nullpunktabweichung von"),
              std::string::npos);
    EXPECT_EQ(page.find(is_english ? "the root mean square error is" : "Prüflauf beträgt der quadratische"),
              std::string::npos);
  }
  const auto dcc = make_dcc(report, {});
  ASSERT_TRUE(dcc);
  for (const Language language : {kEnglish, kGerman})
    EXPECT_NE(dcc->find(translate(language, "say.unknown_zero")), std::string::npos);
  report.bias_zero.clear();
  report.bias_zeros = {{"u1.x", run, std::string(data::kOwnReference)}, {"u1.y", run, "earth rate removed"}};
  const auto of_axis = list_record_cautions(kEnglish, report);
  ASSERT_EQ(of_axis.size(), 1u);
  EXPECT_EQ(of_axis.front().run, run);
  EXPECT_TRUE(of_axis.front().text.starts_with("u1.x: The bias reference"));
}

TEST(Cautions, AreStatementsOfDigitalCertificate) {
  CalibrationReport report = sample_calibration();
  EXPECT_EQ(make_dcc(report, {})->find("gyrotherm_caution"), std::string::npos);
  report.verifications.back().verdict.intervals_hold = false;
  const auto dcc = make_dcc(report, {});
  ASSERT_TRUE(dcc);
  EXPECT_EQ(tests::count_occurrences(*dcc, "refType=\"gyrotherm_caution\""), 1);
  for (const char* text : {"The uncertainty of the model is too small", "Die Unsicherheit des Modells"})
    EXPECT_NE(dcc->find(text), std::string::npos) << text;
}

TEST(Cautions, AreOptionalInCalibrationFile) {
  CalibrationReport report = sample_calibration();
  report.verifications.front().outside = 3;
  report.verifications.front().farthest_term = "A-D";
  report.verifications.front().farthest = 0.25;
  const auto again = calibration_from_json(to_json(report), "calibration.json");
  ASSERT_TRUE(again) << text(again.error());
  EXPECT_EQ(to_json(*again), to_json(report));
  report.verifications.clear();
  EXPECT_EQ(to_json(report).find("\"verifications\""), std::string::npos);
  EXPECT_TRUE(calibration_from_json(to_json(report), "calibration.json"));
}

}  // namespace
}  // namespace gyrotherm::report
