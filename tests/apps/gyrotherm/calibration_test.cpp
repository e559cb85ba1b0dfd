// SPDX-License-Identifier: Apache-2.0
/// Reports of a laboratory on a unit, from records of a virtual rig, and again a year later.
#include "report/calibration.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <tuple>
#include <vector>

#include "acquisition/record/sqlite.hpp"
#include "core/file.hpp"
#include "core/sha256.hpp"
#include "report/dsi.hpp"
#include "report/order.hpp"
#include "report/words.hpp"
#include "tests/apps/gyrotherm/calibrated_unit.hpp"

namespace gyrotherm::app {
namespace {

/// Replaces narrow and non-breaking blanks by plain ones, as pdftotext prints them, and joins lines.
std::string plain_blanks(std::string text) {
  for (const std::string blank : {"\u202f", "\u00a0", "\u2009", "\n"})
    for (auto at = text.find(blank); at != std::string::npos; at = text.find(blank, at))
      text.replace(at, blank.size(), " ");
  return text;
}

TEST_F(CalibrationOfAUnit, WritesAllViews) {
  for (const char* name : {"calibration.json", "calibration.csv", "dcc.xml", "calibration.html", "calibration.de.html",
                           "calibration.pdf", "calibration.de.pdf"})
    EXPECT_TRUE(std::filesystem::exists(in("report/") + name)) << name;
  const auto report = read_report("report");
  EXPECT_TRUE(report.missing.empty());
  EXPECT_TRUE(report.simulated);
  EXPECT_EQ(overall_verdict(report), report::Verdict::fail)
      << "before compensation it far exceeds a tenth of a thousandth";
  EXPECT_NE(read_text(in("report/calibration.html")).find("&lt;script&gt;alert(1)"), std::string::npos);
}

TEST_F(CalibrationOfAUnit, WritesSameNumbersIntoAllViews) {
  const std::string page = plain_blanks(read_text(in("report/calibration.html")));
  const std::string certificate = read_text(in("report/dcc.xml"));
  const auto pdf = shell("pdftotext -layout " + in("report/calibration.pdf") + " -");
  ASSERT_EQ(pdf.exit_code, 0) << pdf.err;
  const std::string paper = plain_blanks(pdf.out);
  int values = 0;
  for (const report::ResultTable& table : read_report("report").results) {
    for (const report::Column& column : table.columns) {
      for (const report::ReportedValue& value : column.values) {
        if (!std::isfinite(value.standard_uncertainty)) continue;
        const std::string text = plain_blanks(report::format(report::Language::english, value));
        EXPECT_NE(page.find(text), std::string::npos) << table.key << "." << column.quantity << " " << text;
        EXPECT_NE(paper.find(text), std::string::npos) << table.key << "." << column.quantity << " " << text;
        EXPECT_NE(certificate.find(report::dsi_value(value)), std::string::npos) << table.key << " " << text;
        ++values;
      }
    }
  }
  EXPECT_GT(values, 30);
}

TEST_F(CalibrationOfAUnit, StatesTrainedRangeOfBlock) {
  const auto model = nlohmann::json::parse(read_text(in("model.json")));
  const auto& block = model["trained_on"][0]["block"];
  const auto ranges = read_report("report").trained_ranges;
  ASSERT_EQ(ranges.size(), 1U);
  EXPECT_EQ(ranges[0].stage, report::Stage::as_left);
  ASSERT_TRUE(ranges[0].block);
  EXPECT_EQ(ranges[0].block->low_c, block["low_c"]);
  EXPECT_EQ(ranges[0].block->high_c, block["high_c"]);
  EXPECT_NE(read_text(in("report/calibration.html")).find("The model was trained at block temperatures from "),
            std::string::npos);
  EXPECT_NE(read_text(in("report/calibration.de.html")).find("Das Modell wurde bei Temperaturen des Blocks von "),
            std::string::npos);
}

TEST_F(CalibrationOfAUnit, AppliesAsLeftLimitsToUnseenRunOnly) {
  int as_left = 0;
  for (const report::Conformity& one : read_report("report").conformity) {
    if (one.stage != report::Stage::as_left) continue;
    ++as_left;
    EXPECT_EQ(one.run, read_report("report").files[3].id) << "the random run";
  }
  EXPECT_GT(as_left, 0);
}

/// A coefficient known to a tenth of its value has fifty degrees of freedom (GUM G.3).
TEST_F(CalibrationOfAUnit, GivesNoiseDegreesOfFreedomOfBudget) {
  int coefficients = 0;
  for (const report::ResultTable& table : read_report("report").results) {
    if (table.group != report::Group::random_drift) continue;
    const report::ReportedValue& value = table.columns.front().values.front();
    EXPECT_NEAR(value.degrees_of_freedom, std::max(1.0, 0.5 * std::pow(value.value / value.standard_uncertainty, 2)),
                1e-6)
        << table.key;
    ++coefficients;
  }
  EXPECT_GT(coefficients, 0);
}

TEST_F(CalibrationOfAUnit, RefusesRecordsOfTwoGyros) {
  run("run tests/profiles/short-random.toml --rig profiles/rigs/virtual.toml --seed 4 --out " + in("other.db"));
  const auto refused = gyrotherm_with("report " + in("ramp.db") + " " + in("other.db") + " --out " + in("mixed"));
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_NE(refused.err.find("belongs to a different gyro (seed 4)"), std::string::npos) << refused.err;
  EXPECT_EQ(gyrotherm_with("train " + in("ramp.db") + " " + in("other.db") + " --out " + in("none.json")).exit_code, 2);
  run("report " + in("other.db") + " --model " + in("model.json") + files("order.toml") + " --out " + in("of_other"));
  const auto missing = read_report("of_other").missing;
  EXPECT_NE(std::ranges::find(missing, "models: one trained on this unit"), missing.end());
}

TEST_F(CalibrationOfAUnit, RefusesTwoModelsOfOneAxis) {
  std::filesystem::copy_file(in("model.json"), in("second.json"));
  const auto ran = gyrotherm_with("report " + in("ramp.db") + " --model " + in("model.json") + " --model " +
                                  in("second.json") + " --out " + in("two_models"));
  EXPECT_EQ(ran.exit_code, 2) << ran.err;
  EXPECT_NE(ran.err.find("model.json and second.json apply to one axis"), std::string::npos) << ran.err;
  EXPECT_FALSE(std::filesystem::exists(in("two_models")));
}

TEST_F(CalibrationOfAUnit, StatesBiasReferenceOfEachRecord) {
  for (const auto& [name, earth_rate] : {std::pair{"known", "earth_rate = 10.6"}, std::pair{"unknown", ""}}) {
    std::ofstream table(in("table.csv"));
    table << "s,T,g\n";
    const int period = *earth_rate != '\0' ? 7 : 5;
    for (int second = 0; second < 300; ++second)
      table << second << ',' << 20 + second % period << ",10." << second % period << '\n';
    table.close();
    std::ofstream(in(name) + ".toml") << "schema = \"gyrotherm-import/1\"\nname = \"" << name << "\"\n"
                                      << "[time]\ncolumn = \"s\"\nunit = \"s\"\n"
                                      << "[[thermometer]]\nname = \"T\"\ncolumn = \"T\"\n"
                                      << "[gyro]\ncolumn = \"g\"\nkind = \"rate\"\nscale = 1\n"
                                      << earth_rate << "\n";
    run("import " + in("table.csv") + " --map " + in(name) + ".toml --out " + in(name) + ".db");
  }
  run("report " + in("known.db") + " " + in("unknown.db") + " --out " + in("zeros"));
  const auto report = read_report("zeros");
  EXPECT_EQ(report.bias_zero, "");
  ASSERT_EQ(report.bias_zeros.size(), 2u);
  EXPECT_EQ(report.bias_zeros[0].zero, "earth rate removed");
  EXPECT_EQ(report.bias_zeros[1].zero, "nothing removed");
  run("report " + in("known.db") + " --out " + in("zero"));
  EXPECT_EQ(read_report("zero").bias_zero, "earth rate removed");
  EXPECT_TRUE(read_report("zero").bias_zeros.empty());
}

TEST_F(CalibrationOfAUnit, ListsEachCalibrationOfThermometer) {
  std::filesystem::copy_file(in("random.db"), in("anew.db"));
  {
    auto record = record::Database::open(in("anew.db"), record::Access::read_write, 0).value();
    ASSERT_TRUE(record.execute("UPDATE channel SET calibrated = '2025-12-30', calibration_uncertainty_k = 0.1"));
  }
  run("report " + in("ramp.db") + " " + in("anew.db") + " --unverified --out " + in("anew"));
  std::vector<double> of_a;
  for (const report::Equipment& one : read_report("anew").equipment)
    if (one.channel == "A") of_a.push_back(one.standard_uncertainty_k);
  EXPECT_EQ(of_a, (std::vector<double>{0.02, 0.1})) << "as in the budgets of the two records";
}

/// Returns kind and duration of each deviation, such as "paused 100 s".
std::vector<std::string> summarise(const std::vector<report::Deviation>& deviations) {
  std::vector<std::string> all;
  for (const report::Deviation& one : deviations)
    all.push_back(std::isfinite(one.seconds) ? fmt::format("{} {:g} s", one.kind, one.seconds) : one.kind);
  return all;
}

TEST_F(CalibrationOfAUnit, StatesEndAndDurationOfHoldAndSuspension) {
  std::ofstream(in("approach.toml")) << "schema = \"gyrotherm-profile/1\"\nname = \"approach\"\n"
                                     << "[[segment]]\nkind = \"hold\"\nat = \"10 °C\"\ntime = \"10 min\"\n";
  run("run " + in("approach.toml") + " --rig profiles/rigs/virtual.toml --out " + in("approach.db"));
  const auto report_of = [&](const std::string& change) {
    const auto record = in("approach.db");
    if (!change.empty())
      EXPECT_TRUE(record::Database::open(record, record::Access::read_write, 0).value().execute(change));
    run("report " + record + (change.empty() ? "" : " --unverified") + " --out " + in("approach"));
    return summarise(read_report("approach").deviations);
  };
  const auto begins_suspended = report_of("");
  ASSERT_EQ(begins_suspended.size(), 2u) << "the air was not at the first set point";
  EXPECT_EQ(begins_suspended[0], "paused 101 s");
  EXPECT_EQ(begins_suspended[1], "resumed");
  const auto duration = begins_suspended[0].substr(begins_suspended[0].find(' '));
  EXPECT_EQ(report_of("UPDATE event SET text = 'held: paused by ada' WHERE text LIKE 'suspended: %'"),
            (std::vector<std::string>{"held" + duration, "resumed"}));
  EXPECT_EQ(report_of("UPDATE event SET text = 'execute: the profile goes on, after: paused by ada' "
                      "WHERE text LIKE 'execute: %'"),
            (std::vector<std::string>{"held" + duration, "resumed"}))
      << "text of gyrotherm 0.1.0";
  EXPECT_EQ(report_of("UPDATE event SET text = 'held: the profile asks' WHERE text LIKE 'execute: %'"),
            (std::vector<std::string>{"held" + duration, "held 599 s"}))
      << "the second hold ends with the run";
}

/// Adds an event to a record, with a time after the start of the run. `interlock` is SQL.
void insert_event(const std::string& path, int second, const char* kind, const char* interlock, const char* text) {
  auto database = record::Database::open(path, record::Access::read_write, 0).value();
  EXPECT_TRUE(database.execute(
      fmt::format("INSERT INTO event (slot, monotonic_ns, utc_ns, kind, interlock, text, chain) SELECT {0}, 0, "
                  "(SELECT min(utc_ns) FROM event) + {0} * 1000000000, '{1}', {2}, '{3}', 0",
                  second, kind, interlock, text)));
}

TEST_F(CalibrationOfAUnit, ReportsStopAsOneRow) {
  const std::string record = in("stopped.db");
  std::filesystem::copy_file(in("random.db"), record);
  const auto insert = [&](int second, const char* kind, const char* interlock, const char* text) {
    insert_event(record, second, kind, interlock, text);
  };
  insert(10, "state", "NULL", "aborting: aborted by ada: smoke");
  insert(12, "interlock", "'door'", "door (abort): the door is open");
  insert(310, "state", "NULL", "aborted by ada: smoke");
  insert(310, "interlock", "NULL", "aborted by ada: smoke; the chamber was sent to 20 °C (set point read back)");
  insert(400, "resumed", "NULL", "resumed after 90 s; cause of the interruption: aborted by ada: smoke");
  insert(500, "state", "NULL", "aborting: aborted by ada: smoke");
  insert(600, "interlock", "NULL", "chamber off");
  run("report " + record + " --unverified --out " + in("stopped"));
  auto deviations = read_report("stopped").deviations;
  std::erase_if(deviations, [](const report::Deviation& one) { return one.kind == "note"; });
  EXPECT_EQ(summarise(deviations),
            (std::vector<std::string>{"stopped 300 s", "interlock", "resumed", "stopped", "interlock"}))
      << "an event of another cause has its own row";
  EXPECT_EQ(deviations.at(0).text, "aborted by ada: smoke; the chamber was sent to 20 °C (set point read back)");
  EXPECT_EQ(deviations.at(3).text, "aborted by ada: smoke");
}

/// The chamber goes to its safe state after an abort, and a resumed run returns from there.
TEST_F(CalibrationOfAUnit, StatesAirOfProfileOnly) {
  const auto air = [&](const std::string& change) {
    const std::string record = in("air.db");
    std::filesystem::copy_file(in("random.db"), record, std::filesystem::copy_options::overwrite_existing);
    EXPECT_TRUE(record::Database::open(record, record::Access::read_write, 0).value().execute(change));
    run("report " + record + " --unverified --out " + in("air"));
    const auto influences = read_report("air").influences;
    return std::pair{influences.at(0).low, influences.at(0).high};
  };
  const auto usual = air("UPDATE sample SET chamber_air_c = chamber_air_c");
  const auto changed = [](const char* slots, const char* state) {
    return fmt::format("UPDATE sample SET chamber_air_c = 95, state = '{}' WHERE slot BETWEEN {}; ", state, slots);
  };
  EXPECT_EQ(
      air(changed("300 AND 309", "aborting") + changed("310 AND 319", "aborted") + changed("320 AND 399", "suspended")),
      usual);
  EXPECT_EQ(air(changed("300 AND 400", "stopped")), usual);
  EXPECT_EQ(air(changed("300 AND 399", "suspended")).second, 95) << "the profile waits";
}

TEST_F(CalibrationOfAUnit, SortsDeviationsOfAllRecordsByTime) {
  for (const char* name : {"ramp", "random"}) std::filesystem::copy_file(in(name) + ".db", in(name) + "-noted.db");
  insert_event(in("ramp-noted.db"), 300, "note", "NULL", "third");
  insert_event(in("ramp-noted.db"), 100, "note", "NULL", "first");
  insert_event(in("random-noted.db"), 200, "note", "NULL", "second");
  run("report " + in("random-noted.db") + " " + in("ramp-noted.db") + " --unverified --out " + in("sorted"));
  std::vector<std::string> texts;
  for (const report::Deviation& one : read_report("sorted").deviations) texts.push_back(one.text);
  EXPECT_EQ(texts, (std::vector<std::string>{"first", "second", "third"}));
}

TEST_F(CalibrationOfAUnit, NamesReasonForRefusingEqualRuns) {
  const auto refusal = [&](const std::string& other) {
    const auto refused =
        gyrotherm_with("report " + in("random.db") + " " + in(other) + " --unverified --out " + in("none"));
    EXPECT_EQ(refused.exit_code, 2);
    return refused.err;
  };
  EXPECT_NE(refusal("random.db").find("the same run is given twice"), std::string::npos);
  std::filesystem::copy_file(in("random.db"), in("variant.db"));
  {
    auto record = record::Database::open(in("variant.db"), record::Access::read_write, 0).value();
    ASSERT_TRUE(record.execute("UPDATE event SET text = 'another text' WHERE kind = 'started'"));
  }
  EXPECT_NE(refusal("variant.db").find("is a virtual run of the same profile, seed and day as "), std::string::npos);
}

TEST_F(CalibrationOfAUnit, IsAuthorisedOnceAndNeverOverwritten) {
  run("report " + in("random.db") + " --model " + in("model.json") + files("order.toml") + " --out " + in("once"));
  run("report authorise " + in("once") + " --by 'B. Berg'");
  EXPECT_EQ(read_report("once").authorised->name, "B. Berg");
  EXPECT_EQ(gyrotherm_with("report authorise " + in("once") + " --by 'B. Berg'").exit_code, 2);
  const auto again = gyrotherm_with("report " + in("random.db") + files("order.toml") + " --out " + in("once"));
  EXPECT_EQ(again.exit_code, 2);
  EXPECT_NE(again.err.find("has a report that is authorised"), std::string::npos) << again.err;
}

/// HTML and DCC contain these characters; the PDF cannot.
TEST_F(CalibrationOfAUnit, IsNotAuthorisedWithCharactersMissingFromPdf) {
  const std::array<std::tuple<const char*, const char*, const char*>, 3> all{
      {{"K. Kurz", "K. \uE777", "U+E777"}, {"Hamburg", "\U0010FFF0", "U+10FFF0"}, {"C-1", "C-1\u0378", "U+0378"}}};
  for (const auto& [text, other, name] : all) {
    std::string order = kOrder;
    std::ofstream(in("no-font.toml")) << order.replace(order.find(text), std::string(text).size(), other);
    const auto made = gyrotherm_with("report " + in("random.db") + " --model " + in("model.json") +
                                     files("no-font.toml") + " --language de --out " + in("no-font"));
    ASSERT_EQ(made.exit_code, 0) << made.err;
    const std::string remark = fmt::format("calibration.de.pdf: no installed font has {}; they are omitted", name);
    EXPECT_NE(made.err.find("warning: " + remark), std::string::npos) << made.err;
    const auto refused = gyrotherm_with("report authorise " + in("no-font") + " --by 'B. Berg'");
    EXPECT_EQ(refused.exit_code, 4);
    EXPECT_NE(refused.err.find(remark + "; install fonts-noto-cjk"), std::string::npos) << refused.err;
    EXPECT_EQ(read_report("no-font").state, report::ReportState::draft);
    EXPECT_FALSE(std::filesystem::exists(in("no-font/authorisation.json")));
  }
  const auto compared = gyrotherm_with("report compare " + in("report") + " " + in("no-font") + " --out " + in("gaps"));
  ASSERT_EQ(compared.exit_code, 0) << compared.err;
  EXPECT_NE(compared.err.find("warning: comparison.pdf: no installed font has U+0378"), std::string::npos)
      << compared.err;
}

TEST_F(CalibrationOfAUnit, IsAuthorisedOnlyByPersonWithRole) {
  run("report " + in("random.db") + " --model " + in("model.json") + files("order.toml") + " --out " + in("roles"));
  for (const char* name : {"Mickey Mouse", "K. Kurz", "b. berg", "B. Berg ", "authorising"}) {
    const auto refused = gyrotherm_with("report authorise " + in("roles") + " --by '" + name + "'");
    EXPECT_EQ(refused.exit_code, 2) << name;
    EXPECT_NE(refused.err.find("does not have the role authorising; laboratory.toml gives it to \"B. Berg\""),
              std::string::npos)
        << refused.err;
    EXPECT_EQ(read_report("roles").state, report::ReportState::draft);
  }
}

TEST_F(CalibrationOfAUnit, IsNotAuthorisedWithPlaceholderTexts) {
  run("report " + in("random.db") + " --model " + in("model.json") + files("order.toml") + " --out " + in("copied"));
  auto draft = read_report("copied");
  draft.traceability = {"Temperatures are traceable to the SI through …", ""};
  draft.customer.name = "Navigation Works";
  draft.people[1].name = "O. Perator";
  std::ofstream(in("copied/calibration.json")) << to_json(draft);  // draft of gyrotherm 0.1.0
  const auto refused = gyrotherm_with("report authorise " + in("copied") + " --by 'B. Berg'");
  EXPECT_EQ(refused.exit_code, 2);
  for (const char* key :
       {"laboratory.toml: traceability.en", "order.toml: customer.name", "order.toml: person[1].name"})
    EXPECT_NE(refused.err.find(key), std::string::npos) << refused.err;
  EXPECT_EQ(read_report("copied").state, report::ReportState::draft);
}

/// A draft that a person edits is refused, whichever value was changed, also with a new digest in sources.json.
TEST_F(CalibrationOfAUnit, IsAuthorisedOnlyAsItsSourcesYieldIt) {
  run("report " + in("random.db") + " --model " + in("model.json") + files("order.toml") + " --out " + in("edited"));
  const std::string path = in("edited/calibration.json"), sources = in("edited/sources.json");
  const std::string draft = read_text(path), original_sources = read_text(sources);
  const std::vector<std::function<void(report::CalibrationReport&)>> changes{
      [](auto& report) { report.simulated = false; },
      [](auto& report) {
        for (auto& one : report.conformity) one.verdict = report::Verdict::pass;
      },
      [](auto& report) { report.item.serial_number = "9999"; },
      [](auto& report) {
        report.people.push_back({"Eve Intruder", "authorising", ""});
      },
      [](auto& report) { report.results.front().columns.back().values.front().value *= 0.5; },
      [](auto& report) { report.customer.name = "Other Works"; },
      [](auto& report) { report.deviations.push_back({.kind = "note", .text = "added"}); },
      [](auto& report) { report.figures.clear(); },
      [](auto& report) { report.files.front().chain_verified = false; }};
  for (std::size_t i = 0; i < changes.size(); ++i) {
    auto report = report::calibration_from_json(draft, path).value();
    changes[i](report);
    std::ofstream(path) << to_json(report);
    for (const bool with_digest : {false, true}) {
      auto stated = nlohmann::ordered_json::parse(original_sources);
      if (with_digest) stated["calibration_sha256"] = sha256(to_json(report));
      std::ofstream(sources) << stated.dump(1) << "\n";
      for (const char* by : {"B. Berg", "Eve Intruder"}) {
        const auto refused = gyrotherm_with("report authorise " + in("edited") + " --by '" + by + "'");
        EXPECT_NE(refused.exit_code, 0) << i << by;
      }
      EXPECT_EQ(read_report("edited").state, report::ReportState::draft) << i;
    }
  }
  std::ofstream(path) << draft;
  std::ofstream(sources) << original_sources;
  run("report authorise " + in("edited") + " --by 'B. Berg'");
  EXPECT_TRUE(nlohmann::json::parse(read_text(in("edited/authorisation.json")))["sources_compared"]);
}

TEST_F(CalibrationOfAUnit, IsAuthorisedWithMovedSources) {
  run("report " + in("random.db") + " --model " + in("model.json") + files("order.toml") + " --out " + in("far/a/b/c"));
  const auto authorise = [](const std::string& options) {
    return gyrotherm_with("report authorise " + in("far/a/b/c") + " --by 'B. Berg'" + options);
  };
  std::filesystem::create_directory(in("archive"));
  std::filesystem::rename(in("model.json"), in("archive/model.json"));
  const auto missing = authorise("");
  EXPECT_EQ(missing.exit_code, 2);
  EXPECT_NE(missing.err.find("not found: model.json"), std::string::npos) << missing.err;
  EXPECT_EQ(authorise(" --records " + in("archive")).exit_code, 0);
  std::filesystem::rename(in("archive/model.json"), in("model.json"));
}

TEST_F(CalibrationOfAUnit, IsAuthorisedByPersonOfGivenLaboratoryFile) {
  run("report " + in("random.db") + " --model " + in("model.json") + files("order.toml") + " --out " + in("given"));
  std::string other = kLaboratory;
  other.replace(other.find("B. Berg"), 7, "C. Coal");
  std::ofstream(in("other-laboratory.toml")) << other;
  for (const char* by : {"B. Berg", "C. Coal"})
    EXPECT_NE(gyrotherm_with("report authorise " + in("given") + " --by '" + by + "' --laboratory " +
                             in("other-laboratory.toml"))
                  .exit_code,
              0)
        << by;
  std::filesystem::remove(in("given/sources.json"));
  EXPECT_EQ(gyrotherm_with("report authorise " + in("given") + " --by 'B. Berg'").exit_code, 2);
  EXPECT_EQ(gyrotherm_with("report authorise " + in("given") + " --by 'B. Berg' --without-sources").exit_code, 2);
  run("report authorise " + in("given") + " --by 'B. Berg' --without-sources --laboratory " + in("laboratory.toml"));
  EXPECT_FALSE(nlohmann::json::parse(read_text(in("given/authorisation.json"))).contains("sources_compared"));
}

/// Covers reports that gyrotherm 0.1.0 authorised and reports with a changed view.
TEST_F(CalibrationOfAUnit, IsAuthorisedAgainWhenFilesHaveChanged) {
  run("report " + in("random.db") + " --model " + in("model.json") + files("order.toml") + " --out " + in("again"));
  const auto authorise = [] { return gyrotherm_with("report authorise " + in("again") + " --by 'B. Berg'"); };
  ASSERT_EQ(authorise().exit_code, 0);
  EXPECT_EQ(authorise().exit_code, 2) << "all files are unchanged since the authorisation";
  const auto changes = std::to_array<std::function<void()>>(
      {[] { std::filesystem::remove(in("again/authorisation.json")); },
       [] { std::ofstream(in("again/calibration.csv"), std::ios::app) << "more\n"; },
       [] { std::filesystem::remove(in("again/calibration.pdf")); }});
  for (const auto& change : changes) {
    change();
    const auto done = authorise();
    EXPECT_EQ(done.exit_code, 0) << done.err;
    EXPECT_NE(done.err.find("was authorised by B. Berg; since then: "), std::string::npos) << done.err;
    EXPECT_EQ(authorise().exit_code, 2);
  }
}

/// The disk becomes full before the last view is written. Without this rule a PDF marked as draft could be signed.
TEST_F(CalibrationOfAUnit, RemainsDraftWhenViewCannotBeWritten) {
  run("report " + in("random.db") + " --model " + in("model.json") + files("order.toml") + " --out " + in("half"));
  const std::string pdf = in("half/calibration.pdf");
  std::filesystem::remove(pdf);
  std::filesystem::create_directories(pdf + "/in-the-way");
  EXPECT_EQ(gyrotherm_with("report authorise " + in("half") + " --by 'B. Berg'").exit_code, 4);
  EXPECT_EQ(read_report("half").state, report::ReportState::draft);
  std::filesystem::remove_all(pdf);
  run("report authorise " + in("half") + " --by 'B. Berg'");
  EXPECT_EQ(read_report("half").state, report::ReportState::authorised);
  EXPECT_TRUE(std::filesystem::is_regular_file(pdf));
}

TEST_F(CalibrationOfAUnit, IsDraftThatListsMissingTextsWithoutOrder) {
  run("report " + in("ramp.db") + " --model " + in("model.json") + " --out " + in("draft"));
  const auto report = read_report("draft");
  EXPECT_NE(std::ranges::find(report.missing, "order.toml: customer.name"), report.missing.end());
  EXPECT_NE(std::ranges::find(report.missing, "records: a record that the model was not trained on"),
            report.missing.end());
  const auto refused = gyrotherm_with("report authorise " + in("draft") + " --by B");
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_NE(refused.err.find("is incomplete; missing"), std::string::npos) << refused.err;
}

TEST_F(CalibrationOfAUnit, TakesInputsOnlyForModelsInFolder) {
  const auto report = [](const std::string& models) {
    return gyrotherm_with("report " + in("random.db") + models + " --inputs gradients,A --out " + in("inputs"));
  };
  for (const std::string& models : {std::string(), " --model " + in("model.json")}) {
    const auto refused = report(models);
    EXPECT_EQ(refused.exit_code, 2) << models;
    EXPECT_NE(refused.err.find("--inputs: selects models in a folder"), std::string::npos) << refused.err;
  }
  const auto looked = report(" --models " + in("nowhere"));
  EXPECT_NE(looked.err.find("model-gradients,A.json"), std::string::npos) << looked.err;
  EXPECT_FALSE(std::filesystem::exists(in("inputs")));
}

TEST_F(CalibrationOfAUnit, IsComparedWithReportOfYearBefore) {
  std::string order = kOrder;
  order.replace(order.find("\"C-1\""), 5, "\"C-2\"");
  std::ofstream(in("order2.toml")) << order;
  run("run tests/profiles/short-random.toml --rig profiles/rigs/virtual.toml --seed 3 --days-later 365 --out " +
      in("later.db"));
  run("report " + in("later.db") + " --found " + in("model.json") + files("order2.toml") + " --out " + in("later"));
  const auto compared = gyrotherm_with("report compare " + in("report") + " " + in("later") + " --json");
  ASSERT_EQ(compared.exit_code, 0) << compared.err;
  const auto json = nlohmann::json::parse(compared.out);
  EXPECT_TRUE(json["same_model"]);
  EXPECT_NEAR(json["days_between"].get<double>(), 365, 1);
  bool found = false;
  for (const auto& one : json["results"]) {
    EXPECT_NEAR(one["E_n"].get<double>() * one["U"].get<double>(), one["change"].get<double>(), 1e-12);
    EXPECT_NEAR(std::hypot(one["before_U"].get<double>(), one["now_U"].get<double>()), one["U"].get<double>(), 1e-12);
    found = found || (one["key"] == "whole_run" && one["before_at"] == "as_left" && one["now_at"] == "as_found");
  }
  EXPECT_TRUE(found);

  run("report compare " + in("report") + " " + in("later") + " --language en,de --out " + in("compared"));
  for (const auto& [view, title, mark] :
       {std::tuple{"comparison", "Comparison of two calibrations", "SIMULATED"},
        std::tuple{"comparison.de", "Vergleich zweier Kalibrierungen", "SIMULIERT"}}) {
    const auto pdf = shell("pdftotext -layout " + in("compared/") + view + ".pdf -");
    ASSERT_EQ(pdf.exit_code, 0) << pdf.err;
    const std::string paper = plain_blanks(pdf.out);
    EXPECT_NE(paper.find(title), std::string::npos) << paper;
    EXPECT_NE(paper.find(mark), std::string::npos) << view;
    EXPECT_NE(paper.find("C-1"), std::string::npos);
    EXPECT_NE(paper.find("C-2"), std::string::npos);
  }
}

TEST_F(CalibrationOfAUnit, IsNotComparedWhenChangedAfterAuthorisation) {
  run("report " + in("random.db") + " --model " + in("model.json") + files("order.toml") + " --out " +
      in("compared-later"));
  run("report authorise " + in("compared-later") + " --by 'B. Berg'");
  const std::string compare = "report compare " + in("report") + " " + in("compared-later");
  EXPECT_EQ(gyrotherm_with(compare).exit_code, 0);
  std::ofstream(in("compared-later/calibration.json"), std::ios::app) << "\n";
  EXPECT_EQ(gyrotherm_with(compare).exit_code, 4);
}

TEST_F(CalibrationOfAUnit, IsSupersededByAuthorisedReportOfSameUnit) {
  const auto reported = [](const std::string& name, std::initializer_list<std::pair<std::string, std::string>> other,
                           const std::string& replaces = "[replaces]\nnumber = \"C-1\"\n") {
    std::string order = kOrder;
    for (const auto& [from, to] : other) order.replace(order.find(from), from.size(), to);
    std::ofstream(in(name + ".toml")) << order << replaces;
    run("report " + in("random.db") + " --model " + in("model.json") + files(name + ".toml") + " --out " + in(name));
  };
  const auto refused = [](const std::string& by) {
    const auto ran = gyrotherm_with("report supersede " + in("first") + " --by " + in(by));
    EXPECT_EQ(ran.exit_code, 2);
    return ran.err;
  };
  reported("first", {}, "");
  reported("second", {{"\"C-1\"", "\"C-2\""}});
  reported("stranger", {{"\"C-1\"", "\"C-3\""}, {"\"0042\"", "\"0043\""}});
  EXPECT_NE(refused("second").find("is draft"), std::string::npos);
  for (const char* name : {"second", "stranger"}) run("report authorise " + in(name) + " --by 'B. Berg'");
  EXPECT_NE(refused("second").find("is a draft, which was never valid"), std::string::npos);
  run("report authorise " + in("first") + " --by 'B. Berg'");
  EXPECT_NE(refused("stranger").find("covers another unit: RLG-1 0043, expected RLG-1 0042"), std::string::npos);
  const std::string wrong_digest = "[replaces]\nnumber = \"C-1\"\nsha256 = \"" + std::string(64, '0') + "\"\n";
  for (const auto& [name, replaces, why] :
       {std::tuple{"none", std::string(), "does not replace a report"},
        {"number", std::string("[replaces]\nnumber = \"C-9\"\n"), "replaces C-9, not C-1"},
        {"digest", wrong_digest, "replaces a report with SHA-256 0000"}}) {
    reported(name, {{"\"C-1\"", "\"C-4\""}}, replaces);
    run("report authorise " + in(name) + " --by 'B. Berg'");
    EXPECT_NE(refused(name).find(why), std::string::npos) << name;
  }
  reported("real", {{"\"C-1\"", "\"C-6\""}});
  reported("dry", {{"\"C-1\"", "\"C-7\""}}, "[replaces]\nnumber = \"C-6\"\n");
  for (const char* name : {"real", "dry"}) run("report authorise " + in(name) + " --by 'B. Berg'");
  auto real = read_report("real");
  const std::string before = read_text(in("real/calibration.json"));
  real.simulated = false;
  auto authorisation = read_text(in("real/authorisation.json"));
  const auto digest_at = authorisation.find(sha256(before));
  ASSERT_NE(digest_at, std::string::npos);
  std::ofstream(in("real/calibration.json")) << to_json(real);
  std::ofstream(in("real/authorisation.json")) << authorisation.replace(digest_at, 64, sha256(to_json(real)));
  EXPECT_NE(refused("real").find("is a report of real measurements, but C-1 is SIMULATED"), std::string::npos)
      << refused("real");
  const auto by_dry = gyrotherm_with("report supersede " + in("real") + " --by " + in("dry"));
  EXPECT_EQ(by_dry.exit_code, 2);
  EXPECT_NE(by_dry.err.find("is SIMULATED, but C-6 is a report of real measurements"), std::string::npos) << by_dry.err;
  reported("heir", {{"\"C-1\"", "\"C-5\""}, {"\"0042\"", "\"0043\""}},
           "[replaces]\nnumber = \"C-3\"\nreason = { en = \"typing error\", de = \"Tippfehler\" }\n");
  run("report authorise " + in("heir") + " --by 'B. Berg'");
  run("report supersede " + in("stranger") + " --by " + in("heir"));
  EXPECT_EQ(read_report("stranger").replaced_by->reason, (report::Texts{"typing error", "Tippfehler"}))
      << "the reason of the order";
  const std::string dcc = read_text_file(in("stranger/dcc.xml"), kLargestTable).value();
  EXPECT_NE(dcc.find("replaced by the report C-5 and is no longer valid. typing error"), std::string::npos);
  EXPECT_NE(dcc.find("nicht mehr gültig. Tippfehler"), std::string::npos);
  const auto reversed = gyrotherm_with("report supersede " + in("second") + " --by " + in("first"));
  EXPECT_EQ(reversed.exit_code, 2);
  EXPECT_NE(reversed.err.find("is the replaced report"), std::string::npos) << reversed.err;
  run("report supersede " + in("first") + " --by " + in("second") + " --reason 'a year'");
  EXPECT_EQ(read_report("first").replaced_by->number, "C-2");
  EXPECT_FALSE(std::filesystem::exists(in("first/as-signed"))) << "was not signed";
}

/// The repeatability of three starts is known only from all three together, and the model has seen each of them.
TEST_F(CalibrationOfAUnit, IsDraftWhenModelHasSeenAllStarts) {
  std::string records;
  for (const char* name : {"one", "two", "three"}) {
    std::ofstream(in(name) + ".toml") << fmt::format(R"(schema = "gyrotherm-profile/1"
name = "{}"
[defaults]
guaranteed_soak = false
[[segment]]
kind = "hold"
at = "20 °C"
time = "2 h"
[[segment]]
kind = "repeat"
count = 2
cycle = true
  [[segment.segment]]
  kind = "ramp"
  to = "0 °C"
  rate = "4 °C/min"
  [[segment.segment]]
  kind = "ramp"
  to = "40 °C"
  rate = "4 °C/min"
)",
                                                     name);
    run("run " + in(name) + ".toml --rig profiles/rigs/virtual.toml --seed 3 --out " + in(name) + ".db");
    records += " " + in(name) + ".db";
  }
  run("train" + records + " --inputs seven-point,A --method ridge-u --out " + in("starts.json"));
  std::ofstream(in("starts.toml")) << kOrder << "[[limit]]\nquantity = \"turn_on_repeatability.std_of_bias\"\n"
                                   << "stage = \"as_left\"\nat_most = 0.1\n";
  run("report" + records + " --model " + in("starts.json") + files("starts.toml") + " --out " + in("starts"));
  const auto report = read_report("starts");
  EXPECT_NE(std::ranges::find(report.missing, "records: a record that the model was not trained on"),
            report.missing.end());
  EXPECT_EQ(report.conformity.back().verdict, report::Verdict::not_known);
  int tables = 0;
  for (const report::ResultTable& table : report.results) {
    if (table.key != "turn_on_repeatability") continue;
    EXPECT_EQ(table.in_sample, table.stage == report::Stage::as_left);
    ++tables;
  }
  EXPECT_EQ(tables, 2);
}

TEST_F(CalibrationOfAUnit, RefusesOrderOfAnotherUnit) {
  const auto made = shell("sed 's#\\.\\./#" GYROTHERM_SOURCE_DIR
                          "/profiles/#; s/^\\[gyro]$/&\\nserial_number = \"0043\"/' profiles/rigs/virtual.toml > " +
                          in("rig.toml"));
  ASSERT_EQ(made.exit_code, 0) << made.err;
  const auto planned = gyrotherm_with("qualify --rig " + in("rig.toml") + files("order.toml") + " --out " + in("q"));
  EXPECT_EQ(planned.exit_code, 4);
  EXPECT_NE(planned.err.find("the unit's serial_number is \"0042\", but"), std::string::npos) << planned.err;
  EXPECT_FALSE(std::filesystem::exists(in("q"))) << "before any work";
  run("run tests/profiles/short-random.toml --rig " + in("rig.toml") + " --seed 3 --out " + in("0043.db"));
  const auto refused = gyrotherm_with("report " + in("0043.db") + files("order.toml") + " --out " + in("other_unit"));
  EXPECT_EQ(refused.exit_code, 4);
  EXPECT_NE(refused.err.find("but " + in("0043.db") + " contains \"0043\""), std::string::npos) << refused.err;
  EXPECT_FALSE(std::filesystem::exists(in("other_unit")));
}

TEST_F(CalibrationOfAUnit, RefusesLimitOnUnknownQuantity) {
  std::string order = kOrder;
  order.replace(order.find("whole_run.rmse"), 14, "whole_run.rsme");
  std::ofstream(in("mistyped.toml")) << order;
  for (const std::string& command : {"report " + in("random.db"), std::string("qualify")}) {
    const auto refused = gyrotherm_with(command + files("mistyped.toml") + " --out " + in("mistyped"));
    EXPECT_EQ(refused.exit_code, 4) << refused.err;
    EXPECT_NE(refused.err.find("did you mean \"whole_run.rmse\"?"), std::string::npos) << refused.err;
    EXPECT_FALSE(std::filesystem::exists(in("mistyped")));
  }
  // A limit may apply to every reported result except set points, counts and shares.
  for (const report::ResultTable& table : read_report("report").results) {
    for (const report::Column& column : table.columns) {
      const auto given = {"set_point",     "temperature", "starts",    "within",
                          "nominal_share", "seen_share",  "share_low", "share_high"};
      if (std::ranges::find(given, column.quantity) != given.end()) continue;
      const std::string limit =
          fmt::format("[[limit]]\nquantity = \"{}.{}\"\nat_most = 1\n", table.key, column.quantity);
      EXPECT_TRUE(report::parse_order(kOrder + limit, "order.toml")) << limit;
    }
  }
}

TEST_F(CalibrationOfAUnit, DistinguishesRecordsOfOneFileNameByFolder) {
  for (const char* name : {"ramp", "random"}) {
    std::filesystem::create_directories(in("runs/") + name + "/a");
    for (const char* suffix : {"", ".sha256"})
      std::filesystem::copy_file(in(name) + ".db" + suffix, in("runs/") + name + "/a/gyro.db" + suffix);
  }
  run("report " + in("runs/ramp/a/gyro.db") + " " + in("runs/random/a/../a/gyro.db") + " --out " + in("of_one_name"));
  std::vector<std::string> names;
  for (const report::UsedFile& file : read_report("of_one_name").files)
    if (file.role == "record") names.push_back(file.name);
  EXPECT_EQ(names, (std::vector<std::string>{"ramp/a/gyro.db", "random/a/gyro.db"}));
}

}  // namespace
}  // namespace gyrotherm::app
