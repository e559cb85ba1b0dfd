// SPDX-License-Identifier: Apache-2.0
#include "report/document.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <regex>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "report/dcc.hpp"
#include "report/document_parts.hpp"
#include "tests/support/markup.hpp"
#include "tests/support/sample_calibration.hpp"

namespace gyrotherm::report {
namespace {

constexpr Language kLanguages[] = {Language::english, Language::german};

/// Collects all text of a document, including the captions of figures.
struct Text {
  std::string all;
  void take(const std::string& text) { all += text + "\n"; }
  void operator()(const Heading& heading) { take(heading.text); }
  void operator()(const Paragraph& paragraph) { take(paragraph.text); }
  void operator()(const Definitions& definitions) {
    for (const auto& [what, value] : definitions.lines) take(what + ": " + value);
  }
  void operator()(const KeyFigures& keys) {
    take(keys.title);
    for (const KeyFigures::Entry& one : keys.figures) take(one.value + " " + one.unit + " " + one.label);
  }
  void operator()(const DocumentTable& table) {
    take(table.caption);
    for (const std::string& name : table.header) take(name);
    for (const auto& row : table.rows)
      for (const Cell& cell : row) take(cell.text + "\n" + cell.note);
  }
  void operator()(const DocumentFigure& figure) { take(figure.caption); }
};

std::string text_of(const Document& document) {
  Text text;
  text.take(document.title);
  for (const Block& block : document.blocks) std::visit(text, block);
  text.take(document.end);
  return text.all;
}

std::string text_of(const CalibrationReport& report, Language language = Language::english) {
  return text_of(make_document(report, language));
}

template <class T>
std::vector<T> all_of(const Document& document) {
  std::vector<T> found;
  for (const Block& block : document.blocks)
    if (const T* one = std::get_if<T>(&block)) found.push_back(*one);
  return found;
}

bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

TEST(Document, HasEveryValueWithItsUncertainty) {
  const CalibrationReport report = sample_calibration();
  for (const Language language : kLanguages) {
    const std::string text = text_of(report, language);
    for (const ResultTable& table : report.results)
      for (const Column& column : table.columns)
        for (const ReportedValue& value : column.values)
          EXPECT_TRUE(has(text, format(language, value)) || has(text, format_result(language, value)))
              << table.key << " " << column.quantity;
    for (const Conformity& one : report.conformity) EXPECT_TRUE(has(text, format(language, one.value)));
  }
}

TEST(Document, NamesOnlyAuthorisingPersonWhoAuthorised) {
  CalibrationReport report = sample_calibration();
  report.people.push_back({"Z. Second", "authorising", "z@lab.de"});
  for (const Language language : kLanguages) {
    EXPECT_FALSE(has(text_of(report, language), "Z. Second"));
    EXPECT_TRUE(has(text_of(report, language), "A. Metrologist, a@example.org"));
  }
  report.state = ReportState::draft;
  report.authorised.reset();
  EXPECT_TRUE(has(text_of(report), "Z. Second")) << "a draft lists all who may authorise";
}

TEST(Document, HasContentsRequiredByIso17025) {
  const CalibrationReport report = sample_calibration();
  const std::string text = text_of(report);
  for (const std::string& part : {report.number,
                                  report.laboratory.name,
                                  report.laboratory.address[0],
                                  report.customer.name,
                                  report.customer.city,
                                  report.method.en,
                                  report.traceability.en,
                                  report.item.serial_number,
                                  report.item.condition.en,
                                  report.place.en,
                                  std::string("2 November 2026"),
                                  std::string("10 November 2026"),
                                  std::string("20 November 2026"),
                                  report.people[0].name,
                                  report.authorised->name,
                                  report.replaces->number,
                                  report.replaces->sha256,
                                  report.files[0].sha256,
                                  report.equipment[0].certificate,
                                  std::string("relate only to the item"),
                                  std::string("except in full"),
                                  std::string("guard band"),
                                  std::string("coverage factor k"),
                                  std::string("approximately 95 %"),
                                  report.deviations[0].text,
                                  std::string("overdue"),
                                  std::string("End of the calibration report C-2026-0042")})
    EXPECT_TRUE(has(text, part)) << part;
}

TEST(Document, IsGermanOnRequest) {
  const std::string text = text_of(sample_calibration(), Language::german);
  for (const char* part : {"Kalibrierbericht", "Erweiterungsfaktor k", "Nach Justierung", "10. November 2026",
                           "Ringlaserkreisel", "Erddrehrate abgezogen", "Bedingt nicht konform"})
    EXPECT_TRUE(has(text, part)) << part;
  EXPECT_FALSE(has(text, "As left"));
}

TEST(Document, TranslatesFixedTextsOfEvents) {
  CalibrationReport report = sample_calibration();
  report.deviations = {{.kind = "paused", .text = "suspended: paused by ada"}};
  const std::string german = text_of(report, Language::german);
  EXPECT_TRUE(has(german, "angehalten: angehalten von ada"));
  EXPECT_TRUE(has(german, "Wortlaut der Aufzeichnung"));
  EXPECT_TRUE(has(text_of(report), "suspended: paused by ada"));
  EXPECT_TRUE(has(text_of(report), "wording of the record"));
  report.deviations = {{.kind = "stated", .text = "Door open."}};
  EXPECT_FALSE(has(text_of(report), "wording of the record")) << "no event of a record";
}

TEST(Document, NamesChannelOfOverdueThermometer) {
  CalibrationReport report = sample_calibration();
  report.equipment = {{.role = "thermometer", .channel = "B", .name = "dcon 2 at virtual, input 3", .overdue = true},
                      {.role = "thermometer", .channel = "C", .names = {"Bridge", "Brücke"}, .overdue = true},
                      {.role = "chamber", .name = "F4T", .overdue = true}};
  EXPECT_TRUE(
      has(text_of(report),
          "overdue: Thermometer B (dcon 2 at virtual, input 3), Thermometer C (Bridge), Temperature chamber F4T."));
  EXPECT_TRUE(has(text_of(report, Language::german),
                  "Thermometer B (dcon 2 an virtueller Leitung, Eingang 3), Thermometer C (Brücke), Klimakammer F4T."));
}

TEST(Document, KeepsTrailingZerosOfResultsWithoutU) {
  CalibrationReport report = sample_calibration();
  for (ResultTable& table : report.results)
    if (table.key == "whole_run") table.columns[3].values[0] = {.value = 0.684};
  const std::string text = text_of(report);
  EXPECT_TRUE(has(text, "0.6840"));
  EXPECT_TRUE(has(text, "0.0005\n")) << "a setting has no trailing zeros";
}

TEST(Document, MentionsNumberOfCustomerOnlyIfGiven) {
  CalibrationReport report = sample_calibration();
  EXPECT_TRUE(has(text_of(report), "and the customer’s number of the item"));
  report.item.customers_number.clear();
  EXPECT_FALSE(has(text_of(report), "number of the item"));
  EXPECT_TRUE(has(text_of(report, Language::german), "Name und Anschrift des Auftraggebers."));
}

TEST(Document, NamesOnlyDataThatCustomerProvided) {
  CalibrationReport report = sample_calibration();
  report.customer = {.name = "Navigation Works"};
  EXPECT_TRUE(has(text_of(report), "Provided by the customer: name of the customer, and the customer’s number"));
  report.customer = {.city = "Kiel"};
  report.item.customers_number.clear();
  EXPECT_TRUE(has(text_of(report), "Provided by the customer: address of the customer."));
  report.customer = {};
  for (const Language language : {Language::english, Language::german})
    for (const char* part : {"Provided by the customer", "Vom Auftraggeber bereitgestellt"})
      EXPECT_FALSE(has(text_of(report, language), part));
}

TEST(Document, PrintsBothEndsOfInfluenceWithSameDecimals) {
  CalibrationReport report = sample_calibration();
  const auto row_of = [&](double low, double high) {
    report.influences = {{.key = "air_temperature", .unit = "°C", .low = low, .high = high}};
    return text_of(report);
  };
  EXPECT_TRUE(has(row_of(19.5, 50.48), "19.50\n\n50.48"));
  EXPECT_TRUE(has(row_of(-40.4, 50.49), "−40.40\n\n50.49"));
  EXPECT_TRUE(has(row_of(35, 45), "35\n\n45"));
  EXPECT_TRUE(has(row_of(0, 0.125), "0.000\n\n0.125"));
}

TEST(Document, HasSameStructureInBothLanguages) {
  const CalibrationReport report = sample_calibration();
  const Document english = make_document(report, Language::english), german = make_document(report, Language::german);
  ASSERT_EQ(english.blocks.size(), german.blocks.size());
  for (std::size_t k = 0; k < english.blocks.size(); ++k)
    EXPECT_EQ(english.blocks[k].index(), german.blocks[k].index()) << k;
}

TEST(Document, ListsMissingDataOfDraft) {
  CalibrationReport report = sample_calibration();
  report.state = ReportState::draft;
  report.authorised.reset();
  report.missing = {"order.toml: customer.name"};
  report.number.clear();
  const Document document = make_document(report, Language::english);
  EXPECT_EQ(document.title, "Calibration report (draft)");
  EXPECT_EQ(document.mark, "DRAFT · SIMULATED");
  EXPECT_EQ(document.number, "–");
  const auto* first = std::get_if<Paragraph>(&document.blocks.front());
  ASSERT_NE(first, nullptr);
  EXPECT_EQ(first->style, Paragraph::Style::caution);
  EXPECT_TRUE(has(first->text, "order.toml: customer.name"));
  EXPECT_TRUE(has(text_of(document), "Not authorised"));
}

TEST(Document, ListsBiasReferencesThatDiffer) {
  CalibrationReport report = sample_calibration();
  EXPECT_TRUE(has(text_of(report), "Earth rate removed"));
  report.bias_zero.clear();
  report.bias_zeros = {{"u1.x", report.files[0].id, "earth rate removed"},
                       {"u1.y", report.files[0].id, "nothing removed"}};
  for (const std::string& text : {text_of(report), *make_dcc(report, {})}) {
    EXPECT_TRUE(std::regex_search(text, std::regex("u1.x[^:]*: Earth rate removed"))) << text;
    EXPECT_TRUE(std::regex_search(text, std::regex("u1.y[^:]*: Nothing removed"))) << text;
  }
  EXPECT_EQ(calibration_from_json(to_json(report), "calibration.json")->bias_zeros, report.bias_zeros);
}

TEST(Document, StatesTrainedRangeOfModel) {
  CalibrationReport report = sample_calibration();
  // The range is −17.6 to 58.4 °C; it is rounded inwards to whole degrees.
  EXPECT_TRUE(has(text_of(report), "u1.x: The model was trained at block temperatures from −17 to 58 °C."));
  EXPECT_TRUE(has(text_of(report, Language::german),
                  "u1.x: Das Modell wurde bei Temperaturen des Blocks von −17 bis 58 °C trainiert."));
  EXPECT_EQ(calibration_from_json(to_json(report), "calibration.json")->trained_ranges, report.trained_ranges);
  report.trained_ranges.front().block.reset();
  EXPECT_TRUE(has(text_of(report), "u1.x: The model does not state the block temperatures"));
  EXPECT_TRUE(has(text_of(report, Language::german), "u1.x: Das Modell gibt nicht an"));
  report.trained_ranges.clear();
  EXPECT_FALSE(has(text_of(report), "block temperatures")) << "no statement without a model";
}

TEST(Document, PrefersTrainedRangeOfModelAsLeft) {
  CalibrationReport report = sample_calibration();
  report.trained_ranges = {
      {"u1.x", Stage::as_found, model::BlockRange{1, 39, {"A"}}},
      {"u1.x", Stage::as_left, model::BlockRange{-17.6, 58.4, {"A", "B"}, {{"shell", -38.9, 60}}}}};
  EXPECT_TRUE(has(text_of(report), "−17 to 58 °C"));
  EXPECT_TRUE(has(text_of(report), "The thermometers of the block are A, B."));
  EXPECT_TRUE(has(text_of(report), "The thermometer shell ranged from −38 to 60 °C."));
  report.trained_ranges.pop_back();
  EXPECT_TRUE(has(text_of(report), "1 to 39 °C"));
  report.trained_ranges.front().block->thermometers.clear();
  EXPECT_FALSE(has(text_of(report), "at block temperatures")) << "gyrotherm 0.1.0 counted the shell";
  EXPECT_TRUE(has(text_of(report), "does not state which of them are on the block"));
}

TEST(Document, NamesReplacementOfSupersededReport) {
  CalibrationReport report = sample_calibration();
  report.simulated = false;
  report.state = ReportState::superseded;
  report.replaced_by = OtherReport{.number = "C-2026-0099"};
  const Document document = make_document(report, Language::english);
  EXPECT_EQ(document.mark, "SUPERSEDED");
  EXPECT_TRUE(has(text_of(document), "replaced by the report C-2026-0099"));
}

TEST(Document, MarksInSampleResults) {
  CalibrationReport report = sample_calibration();
  EXPECT_FALSE(has(text_of(report), "They do not verify the model"));
  for (ResultTable& table : report.results) table.in_sample = table.stage == Stage::as_left;
  EXPECT_TRUE(has(text_of(report), "They do not verify the model"));
  const auto keys = all_of<KeyFigures>(make_document(report, Language::english));
  ASSERT_FALSE(keys.empty());
  EXPECT_TRUE(has(keys[0].figures[0].label, "in-sample"));
}

TEST(Document, BeginsWithMeanOfEachAxis) {
  const auto keys = all_of<KeyFigures>(make_document(sample_calibration(), Language::english));
  ASSERT_EQ(keys.size(), 2u);
  EXPECT_EQ(keys[0].title, "Axis u1.x");
  ASSERT_EQ(keys[0].figures.size(), 4u);
  EXPECT_TRUE(keys[0].figures[0].best);
  EXPECT_EQ(keys[0].figures[0].value, format(Language::english, value_with_uncertainty(0.002, 0.00003, 41.7)));
  EXPECT_TRUE(has(keys[0].figures[0].label, "as left (k\u00a0=\u00a02.02, ν\u00a0=\u00a041)"))
      << keys[0].figures[0].label;
  EXPECT_TRUE(has(keys[0].figures[3].label, "as found"));
}

/// A limit applies to one quantity of one axis, stage and record. The other figures have no verdict and no colour.
TEST(Document, KeyFigureHasOnlyVerdictOfItsOwnLimit) {
  CalibrationReport report = sample_calibration();
  const auto own = report.conformity[1];  // compensated mean of u1.x, as left: pass
  report.conformity.clear();
  const auto figures = [&](std::size_t axis) {
    return all_of<KeyFigures>(make_document(report, Language::english)).at(axis).figures;
  };
  for (std::size_t axis = 0; axis < 2; ++axis)
    for (const KeyFigures::Entry& one : figures(axis)) EXPECT_FALSE(one.best) << one.label;
  const auto judge = [&](const char* quantity, Verdict verdict, auto change) {
    Conformity one = own;
    one.quantity = quantity;
    one.verdict = verdict;
    change(one);
    report.conformity.push_back(one);
  };
  const auto keep = [](Conformity&) {};
  judge("compensated_mean.compensated_bias", Verdict::pass, keep);
  judge("stabilised_bias.bias", Verdict::fail, keep);
  judge("compensated_mean.compensated_bias", Verdict::fail, [](Conformity& one) { one.run = "another"; });
  judge("compensated_mean.compensated_bias", Verdict::conditional_fail, [](Conformity& one) { one.axis = "u1.y"; });
  judge("whole_run.rmse", Verdict::conditional_pass, keep);
  judge("whole_run.std", Verdict::fail, [](Conformity& one) { one.stage = Stage::uncompensated; });
  judge("compensated_mean.compensated_bias", Verdict::fail, [](Conformity& one) { one.stage = Stage::as_found; });
  const auto x = figures(0), y = figures(1);
  ASSERT_EQ(x.size(), 4u);
  EXPECT_TRUE(x[0].best && x[0].label.ends_with("; Pass")) << x[0].label;
  EXPECT_TRUE(!x[1].best && x[1].label.ends_with("; Conditional pass")) << x[1].label;
  EXPECT_TRUE(!x[2].best && !has(x[2].label, ";")) << x[2].label;
  EXPECT_TRUE(!x[3].best && x[3].label.ends_with("; Fail")) << x[3].label;
  EXPECT_TRUE(!y[0].best && y[0].label.ends_with("; Conditional fail")) << y[0].label;
  for (std::size_t k = 1; k < y.size(); ++k) EXPECT_TRUE(!y[k].best && !has(y[k].label, ";")) << y[k].label;
  judge("compensated_mean.compensated_bias", Verdict::not_known, keep);
  EXPECT_FALSE(figures(0)[0].best) << "the worst of two limits of one quantity";
}

/// The model is trained on the ramp run and verified on the random run, which has another bias.
TEST(Document, ComparesStagesOfOneRecord) {
  CalibrationReport report = sample_calibration();
  report.files.push_back({.role = "record", .name = "random.db", .id = "second", .sha256 = std::string(64, 'd')});
  const std::size_t count = report.results.size();
  for (std::size_t k = 0; k < count; ++k) {
    ResultTable again = report.results[k];
    again.run = "second";
    if (again.key == "whole_run" && again.stage == Stage::uncompensated)
      again.columns[2].values[0] = value_with_uncertainty(0.5, 0.01, 60);
    if (again.key == "whole_run" && again.stage == Stage::as_left)
      again.columns[2].values[0] = value_with_uncertainty(0.05, 0.001, 60);
    if (again.key == "compensated_mean" && again.stage == Stage::as_found)
      again.columns[0].values[0] = value_with_uncertainty(0.3, 0.01, 60);
    report.results[k].in_sample = report.results[k].stage == Stage::as_left;
    report.results.push_back(std::move(again));
  }
  const Document document = make_document(report, Language::english);
  const std::string text = text_of(document);
  const std::string raw = quantity_text(Language::english, value_with_uncertainty(0.5, 0.01, 60), "°/h");
  EXPECT_TRUE(has(text, raw)) << "uncompensated result of the unseen record";
  EXPECT_TRUE(has(text, ", 10 times as large")) << text.substr(0, 3000);
  const auto keys = all_of<KeyFigures>(document);
  EXPECT_EQ(keys[0].figures[3].value, format(Language::english, value_with_uncertainty(0.3, 0.01, 60))) << "as found";
}

/// The first record meets the limit and the second one does not, or has the larger RMSE.
TEST(Document, SummarisesWorstRecordByName) {
  for (const bool fails : {false, true}) {
    CalibrationReport report = sample_calibration();
    report.files.push_back({.role = "record", .name = "random.db", .id = "second", .sha256 = std::string(64, 'd')});
    const double rmse = fails ? 0.001 : 0.09;
    const std::size_t count = report.results.size();
    for (std::size_t k = 0; k < count; ++k) {
      ResultTable again = report.results[k];
      again.run = "second";
      if (again.stage == Stage::as_left && again.key == "whole_run")
        again.columns[2].values[0] = value_with_uncertainty(rmse, 0.0002, 60);
      if (again.stage == Stage::as_left && again.key == "compensated_mean")
        again.columns[0].values[0] = value_with_uncertainty(-0.013, 0.008, 60);
      report.results.push_back(std::move(again));
    }
    if (fails) {
      Conformity one = report.conformity[1];
      one.quantity = "stabilised_bias.bias";
      one.run = "second";
      one.verdict = Verdict::conditional_fail;
      report.conformity.push_back(one);
    } else {
      report.conformity.clear();
    }
    const Document document = make_document(report, Language::english);
    const auto keys = all_of<KeyFigures>(document);
    const auto& figures = keys.at(0).figures;
    EXPECT_EQ(figures.at(0).value, format(Language::english, value_with_uncertainty(-0.013, 0.008, 60))) << fails;
    EXPECT_EQ(figures.at(1).value, format(Language::english, value_with_uncertainty(rmse, 0.0002, 60))) << fails;
    for (const KeyFigures::Entry& one : figures) EXPECT_TRUE(has(one.label, ", R2")) << one.label;
    EXPECT_TRUE(has(text_of(document), "u1.x, R2: As left, the unit has a mean bias of ")) << fails;
    EXPECT_TRUE(has(text_of(report, Language::german), "u1.x, R2: Nach Justierung hat")) << fails;
  }
  const auto single = all_of<KeyFigures>(make_document(sample_calibration(), Language::english)).at(0);
  EXPECT_FALSE(has(single.figures.at(0).label, "R1")) << "the only record";
}

TEST(Document, ShowsStagesInAdjacentColumns) {
  const auto tables = all_of<DocumentTable>(make_document(sample_calibration(), Language::english));
  const auto found = std::ranges::find_if(tables, [](const DocumentTable& table) {
    return remove_word_joiners(table.caption).ends_with(": Hold bias /\u00a0(°/h)");
  });
  ASSERT_NE(found, tables.end());
  EXPECT_EQ(found->header, (std::vector<std::string>{"Set point /\u00a0°C", "Temperature /\u00a0°C", "Uncompensated",
                                                     "As found", "As left"}));
  ASSERT_EQ(found->rows.size(), 3u);
  EXPECT_EQ(found->rows[1][0].text, "−40");
  EXPECT_EQ(found->rows[1][4].note, "k\u00a0=\u00a02.03, ν\u00a0=\u00a035");
}

TEST(Document, NamesRecordInResultsOfSeveralRecords) {
  CalibrationReport report = sample_calibration();
  report.files.push_back({.role = "record", .name = "random.db", .id = "second", .sha256 = std::string(64, 'd')});
  ResultTable again = report.results.back();
  again.run = "second";
  report.results.push_back(again);
  report.budgets.back().run = "second";
  const Document document = make_document(report, Language::english);
  const auto tables = all_of<DocumentTable>(document);
  EXPECT_TRUE(std::ranges::any_of(tables, [](const DocumentTable& table) {
    return table.header.size() > 1 && table.header[1] == "Record" && table.rows.back()[1].text == "R2";
  }));
  EXPECT_TRUE(has(text_of(document), " s: u1.y, As left, R2")) << "the budget of this record";
  EXPECT_TRUE(has(text_of(document), "hash chain of the following records was not verified: random.db"));
}

/// Results that only one record has, such as its most effective gradient, are in a separate table.
TEST(Document, NamesRecordInTableOfOneOfSeveralRecords) {
  CalibrationReport report = sample_calibration();
  report.files.push_back({.role = "record", .name = "random.db", .id = "second", .sha256 = std::string(64, 'd')});
  const auto found = std::ranges::find(report.results, "stabilised_bias", &ResultTable::key);
  ASSERT_NE(found, report.results.end());
  ResultTable again = *found;
  again.run = "second";
  for (Column& column : again.columns) column.values.pop_back();
  report.results.push_back(again);
  std::set<std::string> records;
  int tables = 0;
  for (const DocumentTable& table : all_of<DocumentTable>(make_document(report, Language::english))) {
    if (!remove_word_joiners(table.caption).ends_with(": Hold bias /\u00a0(°/h)")) continue;
    ++tables;
    ASSERT_EQ(table.header[0], "Record") << table.caption;
    records.insert(table.rows[0][0].text);
  }
  EXPECT_EQ(records, (std::set<std::string>{"R1", "R2"}));
  EXPECT_EQ(tables, 3) << "two tables for the first axis and one for the second";
}

TEST(Document, NamesRecommendedModelOnlyIfOneExists) {
  CalibrationReport report = sample_calibration();
  EXPECT_TRUE(has(text_of(report), "recommended by a predefined rule and with the best simple model"));
  for (ComparedModel& model : report.compared) model.recommended = false;
  EXPECT_FALSE(has(text_of(report), "recommended by a predefined rule and with the best simple model"));
  EXPECT_TRUE(has(text_of(report), "recommends no model"));
  EXPECT_TRUE(has(text_of(report, Language::german), "empfiehlt kein Modell"));
}

TEST(Document, HasRectangularTables) {
  for (const Language language : kLanguages)
    for (const DocumentTable& table : all_of<DocumentTable>(make_document(sample_calibration(), language)))
      for (const auto& row : table.rows) EXPECT_EQ(row.size(), table.header.size()) << table.caption;
}

TEST(Document, MarksFiguresLikeItsPages) {
  CalibrationReport report = sample_calibration();
  const auto check = [&](const char* mark) {
    const Document document = make_document(report, Language::english);
    EXPECT_EQ(document.mark, mark);
    const auto figures = all_of<DocumentFigure>(document);
    EXPECT_EQ(figures.size(), 6u);
    for (const DocumentFigure& figure : figures)
      for (const std::string& svg : {figure.svg, figure.narrow_svg}) {
        if (svg.empty()) continue;
        const std::string marked = std::string(">") + mark + "</text>";
        if (!document.mark.empty()) EXPECT_EQ(tests::count_occurrences(svg, marked), 2) << figure.caption;
        EXPECT_EQ(has(svg, "DRAFT"), has(document.mark, "DRAFT"));
        EXPECT_EQ(has(svg, "SIMULATED"), has(document.mark, "SIMULATED"));
      }
  };
  check("SIMULATED");
  report.state = ReportState::draft;
  check("DRAFT · SIMULATED");
  report.simulated = false;
  check("DRAFT");
  report.state = ReportState::authorised;
  check("");
}

TEST(Document, DrawsFiguresInItsLanguage) {
  const auto figures = all_of<DocumentFigure>(make_document(sample_calibration(), Language::german));
  ASSERT_EQ(figures.size(), 6u);
  std::set<std::string> ids;
  for (const DocumentFigure& figure : figures) {
    EXPECT_EQ(tests::markup_error(figure.svg), "") << figure.caption;
    EXPECT_TRUE(ids.insert(figure.id).second);
  }
  EXPECT_TRUE(has(figures[1].svg, ">0,2</text>")) << figures[1].svg.substr(0, 3000);
  EXPECT_TRUE(has(figures[1].svg, "Nach Justierung"));
  EXPECT_TRUE(has(figures[1].svg, "SIMULIERT"));
  EXPECT_FALSE(has(figures[1].svg, "SIMULATED"));
}

TEST(Document, DashesThermometerLinesBeyondPalette) {
  FigureData figure = sample_calibration().figures[0];
  ASSERT_EQ(figure.lines[0].key, "set_point");
  figure.lines.resize(2);
  for (const char* name : {"B", "C", "D", "E", "F", "G", "H", "shell"}) {
    figure.lines.push_back(figure.lines[1]);
    figure.lines.back().detail = name;
  }
  std::set<std::pair<std::string, bool>> looks;
  for (std::size_t k = 0; k < figure.lines.size(); ++k)
    EXPECT_TRUE(looks.emplace(line_colour(figure, k), is_line_dashed(figure, k)).second) << figure.lines[k].detail;
  EXPECT_FALSE(is_line_dashed(figure, 8)) << "H is the eighth line";
  EXPECT_TRUE(is_line_dashed(figure, 9)) << "shell";
}

TEST(Document, IsCompleteForEmptyReport) {
  for (const Language language : kLanguages) EXPECT_FALSE(text_of(CalibrationReport{}, language).empty());
}

TEST(Calibration, RefusesUnknownKeysWithTheirPath) {
  CalibrationReport report = sample_calibration();
  report.results[1].columns[0].quantity = "set_pont";
  auto read = calibration_from_json(to_json(report), "calibration.json");
  ASSERT_FALSE(read);
  EXPECT_TRUE(has(text(read.error()), "results[1].columns[0].quantity")) << text(read.error());
  report = sample_calibration();
  report.deviations[0].kind = "say.coverage";
  EXPECT_FALSE(calibration_from_json(to_json(report), "calibration.json"));
  report = sample_calibration();
  report.conformity[0].quantity = "compensated_mean.size";
  EXPECT_FALSE(calibration_from_json(to_json(report), "calibration.json"));
}

}  // namespace
}  // namespace gyrotherm::report
