// SPDX-License-Identifier: Apache-2.0
#include "apps/monitor/standard_answers.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <regex>
#include <string>

#include "apps/monitor/run_answers.hpp"
#include "core/file.hpp"
#include "report/standard/check_view.hpp"
#include "tests/apps/monitor/small_run.hpp"
#include "tests/support/check_study.hpp"
#include "tests/support/folder.hpp"

namespace gyrotherm::monitor {
namespace {

constexpr const char* kRigText = "schema = \"gyrotherm-rig/1\"\n[check_standard]\nserial_numbers = [\"G-0001\"]\n";

/// Returns a history of nine check runs in control and one with a changed thermometer.
assurance::History make_checked_history() {
  auto history = tests::make_history(
      {.golden = tests::GoldenGyro::turned, .injected = tests::Injected::thermometer, .runs = 10, .thermometer_k = 0.5},
      7, 9);
  history.head.rig = "a rig";
  history.head.serial_numbers = {"G-0001"};
  history.head.simulated = true;
  return history;
}

std::string write_text(const assurance::History& history) {
  auto text = start_history(history.head);
  for (const auto& check : history.checks) text = append(std::move(text), check);
  for (const auto& one : history.explanations) text = append(std::move(text), one);
  return text;
}

void write_file(const std::string& path, const std::string& text) { std::ofstream(path) << text; }

/// Writes a record whose rig file names a check standard.
void write_record(const std::string& path, const std::string& rig_file = "", const std::string& rig_text = kRigText) {
  auto info = small_run_info();
  info.rig_text = rig_text;
  info.rig_file = rig_file;
  auto store = record::Store::create(path, info);
  ASSERT_TRUE(store && (*store)->append(small_sample(0, false), {}) && (*store)->finish());
}

/// A monitor over one folder.
class Answers {
 public:
  explicit Answers(const std::string& folder)
      : catalogue_({folder}), answers_(catalogue_, feed_, [] { return false; }) {
    catalogue_.scan();
  }
  WebAnswer ask(const std::string& path, const std::string& width = "") {
    WebRequest request;
    if (!width.empty()) request.head.query["width"] = width;
    return answers_.answer(request, "/" + catalogue_.runs().front().key + path, [] { return true; });
  }

 private:
  RunCatalogue catalogue_;
  RunFeed feed_{catalogue_};
  RunAnswers answers_;
};

/// Returns the number of decimals of a printed number.
std::size_t decimals_of(const std::string& number) {
  const auto point = number.find('.');
  return point == std::string::npos ? 0 : number.size() - point - 1;
}

TEST(StandardText, RoundsValuesToTheirLimitsAndAmountsToTheirUncertainty) {
  const auto checked = standard::assess_standard(make_checked_history(), "history.jsonl");
  const auto text = std::regex_replace(describe(checked), std::regex("−"), "-");
  EXPECT_NE(text.find("    > 99.9 %  thermometer gyro.E: "), std::string::npos) << text;
  const std::regex value(R"( (-?[\d.]+) \S+, expected (-?[\d.]+) to (-?[\d.]+) \()");
  int values = 0;
  for (std::sregex_iterator line(text.begin(), text.end(), value), end; line != end; ++line, ++values) {
    const auto decimals = decimals_of((*line)[1]);
    EXPECT_EQ(decimals_of((*line)[2]), decimals) << line->str();
    EXPECT_EQ(decimals_of((*line)[3]), decimals) << line->str();
    const double width =
        std::round((std::stod((*line)[3]) - std::stod((*line)[2])) * std::pow(10, static_cast<double>(decimals)));
    EXPECT_GE(width, 99) << line->str();
    EXPECT_LE(width, 1001) << line->str();
  }
  EXPECT_GE(values, 1) << text;
  const std::regex amount(R"(: (-?[\d.]+) ± 0\.0*(\d+) K \(k = 1\);)");
  std::smatch found;
  ASSERT_TRUE(std::regex_search(text, found, amount)) << text;
  EXPECT_EQ(found[2].length(), 2) << found.str();
}

TEST(StandardText, NamesValueAndLimitOfEwma) {
  auto checked = standard::assess_standard(make_checked_history(), "history.jsonl");
  int changed = 0;
  for (std::size_t r = 0; r < checked.assessment.runs.size(); ++r)
    for (const auto c : checked.assessment.runs[r].charts) {
      auto& point = checked.assessment.charts[c].points[r];
      point.individual_is_out = false;
      point.ewma_is_out = true;
      point.ewma = -1.25;
      ++changed;
    }
  ASSERT_GE(changed, 1);
  const auto limit = checked.assessment.limits.thermometers.ewma;
  const auto text = describe(checked);
  EXPECT_NE(text.find(fmt::format(", EWMA −{:.2f}, limits ±{:.2f} (EWMA)", 1.25 * limit, limit)), std::string::npos)
      << text;
  EXPECT_EQ(text.find("expected"), std::string::npos) << text;
}

std::string error_of(const WebAnswer& answer) { return nlohmann::json::parse(answer.body).value("error", ""); }

TEST(StandardAnswers, ReturnsChartsCauseAndFigureOfHistoryBesideRecord) {
  const tests::TestFolder folder;
  write_record(folder / "run.db");
  write_file(folder / "check-standard.jsonl", write_text(make_checked_history()));
  Answers answers(folder / "");
  EXPECT_TRUE(nlohmann::json::parse(answers.ask("").body)["check_standard"].get<bool>());
  const auto answer = answers.ask("/standard");
  ASSERT_EQ(answer.status, 200) << answer.body;
  const auto json = nlohmann::json::parse(answer.body);
  EXPECT_TRUE(json["is_open"].get<bool>());
  EXPECT_TRUE(json["head"]["simulated"].get<bool>());
  EXPECT_EQ(json["diagnosis"]["named"], "thermometer");
  ASSERT_EQ(json["runs"].size(), 10u);
  EXPECT_EQ(json["runs"][0]["verdict"], "not judged");
  EXPECT_EQ(json["runs"][8]["verdict"], "in control");
  EXPECT_EQ(json["runs"][9]["verdict"], "out of control");
  EXPECT_EQ(json["charts"][0]["points"].size(), 10u);

  const auto figure = answers.ask("/standard.svg", "300");
  EXPECT_EQ(figure.type, "image/svg+xml");
  EXPECT_NE(figure.body.find("width=\"300\""), std::string::npos) << figure.body.substr(0, 300);
  EXPECT_NE(figure.body.find("<title>SIMULATED"), std::string::npos);
  EXPECT_NE(figure.body.find("<desc>Out of control and not explained: 1 of 10 runs"), std::string::npos);
  for (const auto* width : {"239", "1601", "-1", "x", "1e3"})
    EXPECT_EQ(answers.ask("/standard.svg", width).status, 400) << width;
}

TEST(StandardAnswers, ShowsNewCheckRunAndExplanationAtOnce) {
  const tests::TestFolder folder;
  write_record(folder / "run.db");
  auto history = make_checked_history();
  const auto last = history.checks.back();
  history.checks.pop_back();
  Answers answers(folder / "");
  const auto before = answers.ask("/standard");
  EXPECT_EQ(before.status, 404) << "no check run has been made yet";
  EXPECT_NE(error_of(before).find(folder / "check-standard.jsonl"), std::string::npos) << before.body;
  const auto path = folder / "check-standard.jsonl";
  ASSERT_TRUE(replace_text_file(path, write_text(history)));
  EXPECT_FALSE(nlohmann::json::parse(answers.ask("/standard").body)["is_open"].get<bool>());
  history.checks.push_back(last);
  ASSERT_TRUE(replace_text_file(path, write_text(history)));
  EXPECT_TRUE(nlohmann::json::parse(answers.ask("/standard").body)["is_open"].get<bool>());
  history.explanations.push_back({.run_ids = {last.run_id},
                                  .cause = "thermometer",
                                  .part = "D",
                                  .by = "<b>Ada</b>",
                                  .utc = "2027-01-01T00:00:00Z"});
  ASSERT_TRUE(replace_text_file(path, write_text(history)));
  const auto explained = nlohmann::json::parse(answers.ask("/standard").body);
  EXPECT_FALSE(explained["is_open"].get<bool>());
  EXPECT_EQ(explained["runs"][9]["verdict"], "explained");
  EXPECT_EQ(explained["explanations"][0]["by"], "<b>Ada</b>");
  EXPECT_TRUE(explained["diagnosis"].is_null());
}

TEST(StandardAnswers, PrefersHistoryBesideRigFile) {
  const tests::TestFolder records, rigs;
  write_record(records / "run.db", rigs / "rig.toml");
  auto history = make_checked_history();
  write_file(records / "check-standard.jsonl", write_text(history));
  Answers answers(records / "");
  EXPECT_EQ(nlohmann::json::parse(answers.ask("/standard").body)["file"], records / "check-standard.jsonl");
  history.checks.resize(3);
  write_file(rigs / "check-standard.jsonl", write_text(history));
  const auto json = nlohmann::json::parse(answers.ask("/standard").body);
  EXPECT_EQ(json["file"], rigs / "check-standard.jsonl");
  EXPECT_EQ(json["runs"].size(), 3u);
}

TEST(StandardAnswers, RefusesRigWithoutCheckStandardAndOtherRigsHistory) {
  const tests::TestFolder without, other;
  write_record(without / "run.db", "", "schema = \"gyrotherm-rig/1\"\n");
  write_file(without / "check-standard.jsonl", write_text(make_checked_history()));
  Answers plain(without / "");
  EXPECT_FALSE(nlohmann::json::parse(plain.ask("").body)["check_standard"].get<bool>());
  EXPECT_EQ(plain.ask("/standard").status, 404);
  EXPECT_EQ(plain.ask("/standard.svg").status, 404);

  write_record(other / "run.db");
  for (const bool simulated : {false, true}) {
    auto history = make_checked_history();
    history.head.simulated = simulated;
    if (simulated) history.head.rig = "another rig";
    write_file(other / "check-standard.jsonl", write_text(history));
    Answers answers(other / "");
    const auto refused = answers.ask("/standard");
    EXPECT_EQ(refused.status, 404);
    EXPECT_NE(error_of(refused).find("another rig"), std::string::npos) << refused.body;
  }
}

TEST(StandardAnswers, RefusesHostileFilesWithoutTheirText) {
  const tests::TestFolder folder;
  const auto path = folder / "check-standard.jsonl";
  const auto good = write_text(make_checked_history());
  auto changed = good;
  changed.replace(changed.find("G-0001"), 6, "secret");
  write_record(folder / "run.db");
  Answers answers(folder / "");
  for (const auto& text : {std::string("root:secret:0:0\n"), std::string(), good.substr(0, good.size() - 9), changed,
                           std::string(kMaxHistoryBytes + 1, 's'), start_history(make_checked_history().head)}) {
    ASSERT_TRUE(replace_text_file(path, text));
    const auto refused = answers.ask("/standard");
    EXPECT_EQ(refused.status, 404);
    EXPECT_EQ(refused.body.find("secret"), std::string::npos) << refused.body;
    EXPECT_EQ(answers.ask("/standard.svg").status, 404);
  }
  std::filesystem::remove(path);
  ASSERT_EQ(::mkfifo(path.c_str(), 0600), 0);
  EXPECT_EQ(answers.ask("/standard").status, 404) << "a pipe without a writer is not opened";
  std::filesystem::remove(path);
  std::filesystem::create_directory(path);
  EXPECT_EQ(answers.ask("/standard").status, 404);
}

}  // namespace
}  // namespace gyrotherm::monitor
