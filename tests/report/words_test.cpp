// SPDX-License-Identifier: Apache-2.0
#include "report/words.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <limits>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include "analysis/model/budget.hpp"
#include "core/file.hpp"

namespace gyrotherm::report {
namespace {

constexpr Language kEn = Language::english, kDe = Language::german;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

ReportedValue with_expanded(double value, double expanded) {
  return {.value = value, .standard_uncertainty = expanded / 2, .coverage_factor = 2};
}

/// Replaces non-breaking spaces by plain ones to keep the expected texts readable.
std::string plain(std::string text) {
  for (const std::string space : {"\u202f", "\u00a0"})
    for (auto at = text.find(space); at != std::string::npos; at = text.find(space))
      text.replace(at, space.size(), " ");
  return text;
}

std::string written(double value, double expanded, Language language = kEn) {
  return plain(format(language, with_expanded(value, expanded)));
}

TEST(Unit, OfSensitivityIsBiasPerUnit) {
  EXPECT_EQ(sensitivity_unit("°/h"), "1");
  EXPECT_EQ(sensitivity_unit("1"), "°/h");
  EXPECT_EQ(sensitivity_unit(""), "°/h");
  EXPECT_EQ(sensitivity_unit("K"), "°/h/K");
  EXPECT_EQ(sensitivity_unit("m/s"), "°/h/(m/s)");
  EXPECT_EQ(sensitivity_unit("V·s"), "°/h/(V·s)");
}

TEST(Words, ExistInBothLanguages) {
  std::set<std::string_view> seen;
  for (const std::string_view key : text_keys()) {
    EXPECT_FALSE(translate(kEn, key).empty()) << key;
    EXPECT_FALSE(translate(kDe, key).empty()) << key;
    EXPECT_TRUE(seen.insert(key).second) << key << " is duplicated";
  }
  EXPECT_GT(seen.size(), 200u);
}

TEST(Words, HaveSamePlaceholdersInBothLanguages) {
  const auto places = [](std::string_view text) { return std::ranges::count(text, '{'); };
  std::ptrdiff_t filled = 0;
  for (const std::string_view key : text_keys()) {
    EXPECT_EQ(places(translate(kEn, key)), places(translate(kDe, key))) << key;
    filled += places(translate(kEn, key));
  }
  EXPECT_GT(filled, 20);
}

TEST(Words, ExcludeTextsOfDocumentFromKeysOfReport) {
  EXPECT_TRUE(has_text("stabilised_bias"));
  EXPECT_FALSE(has_text("say.coverage"));
  EXPECT_FALSE(has_text("stabilized_bias"));
}

TEST(Words, CoverNamesOfEnumerators) {
  for (const Stage stage : {Stage::uncompensated, Stage::as_found, Stage::as_left}) EXPECT_TRUE(has_text(name(stage)));
  for (const Verdict verdict :
       {Verdict::pass, Verdict::conditional_pass, Verdict::conditional_fail, Verdict::fail, Verdict::not_known})
    EXPECT_TRUE(has_text(name(verdict)));
  for (const DecisionRule rule : {DecisionRule::simple, DecisionRule::guard_band}) EXPECT_TRUE(has_text(name(rule)));
  for (const ReportState state : {ReportState::draft, ReportState::authorised, ReportState::superseded})
    EXPECT_TRUE(has_text(name(state)));
}

TEST(Words, CoverKeysComposedOfEnumerators) {
  const std::vector<std::string_view> all = text_keys();
  const auto covers = [&](const std::string& key) { return std::ranges::find(all, key) != all.end(); };
  for (int k = 0; k <= static_cast<int>(Group::compensation); ++k)
    EXPECT_TRUE(covers(std::string("group.") + name(static_cast<Group>(k)))) << k;
  for (int k = 0; k <= static_cast<int>(Stage::as_left); ++k)
    EXPECT_TRUE(covers(std::string("key.") + name(static_cast<Stage>(k)))) << k;
  for (int k = 0; k <= static_cast<int>(DecisionRule::guard_band); ++k)
    EXPECT_TRUE(covers(std::string("say.rule_") + name(static_cast<DecisionRule>(k)))) << k;
  for (int k = 0; k <= static_cast<int>(model::Source::extrapolation); ++k)
    EXPECT_TRUE(covers(std::string("source.") + model::name(static_cast<model::Source>(k)))) << k;
  for (int k = 0; k <= static_cast<int>(model::ErrorDistribution::triangular); ++k)
    EXPECT_TRUE(covers(std::string("distribution.") + model::name(static_cast<model::ErrorDistribution>(k)))) << k;
}

// Matches the keys of the document, such as "heading.results". Lists all prefixes that sources use.
const std::regex kDocumentKey("(budget|caption|column|heading|label|mark|model|page|say|title)\\.[a-z_]*[a-z]");

/// Returns the keys of the document that occur as literals in the sources of reports.
std::set<std::string> keys_in_sources() {
  std::set<std::string> keys{std::string(models_text_key({})), std::string(models_text_key({{.recommended = true}}))};
  const std::regex literal("\"([a-z]+\\.[a-z_]+)\"");
  for (const char* folder : {"/report", "/apps/pdf"})
    for (const auto& file : std::filesystem::directory_iterator(std::string(GYROTHERM_SOURCE_DIR) + folder)) {
      if (file.path().extension() != ".cpp" || file.path().filename() == "words.cpp") continue;
      const auto text = read_text_file(file.path());
      if (!text) ADD_FAILURE() << file.path();
      for (std::sregex_iterator one(text->begin(), text->end(), literal), none; one != none; ++one)
        if (const std::string key = (*one)[1]; std::regex_match(key, kDocumentKey)) keys.insert(key);
    }
  return keys;
}

TEST(Words, AreExactlyThoseUsedInSources) {
  const std::set<std::string> named = keys_in_sources();
  std::set<std::string> covered;
  for (const std::string_view key : text_keys())
    if (std::regex_match(std::string(key), kDocumentKey)) covered.emplace(key);
  EXPECT_GT(named.size(), 150u);
  for (const std::string& key : named) EXPECT_TRUE(covered.contains(key)) << key << " is missing from the table";
  for (const std::string& key : covered) EXPECT_TRUE(named.contains(key)) << key << " is unused";
}

TEST(Words, FallBackToOtherLanguageForTextsOfUsers) {
  EXPECT_EQ(text_in(kDe, {"a", "b"}), "b");
  EXPECT_EQ(text_in(kEn, {"", "b"}), "b");
  EXPECT_EQ(text_in(kDe, {"a", ""}), "a");
}

TEST(NumberFormat, IsRoundedToTwoDigitsOfU) {
  EXPECT_EQ(written(0.0021449, 0.000123), "0.002 14 ± 0.000 12");
  EXPECT_EQ(written(0.002, 0.0000606), "0.002 000 ± 0.000 061");
  EXPECT_EQ(written(-3.14159, 0.25), "−3.14 ± 0.25");
  EXPECT_EQ(written(0.002, 0.0000606, kDe), "0,002 000 ± 0,000 061");
}

TEST(NumberFormat, CarriesWhenURoundsUpToNextPower) {
  EXPECT_EQ(written(1.234567, 0.0996), "1.23 ± 0.10");
  EXPECT_EQ(written(1.234567, 0.00999), "1.235 ± 0.010");
  EXPECT_EQ(written(1234.5, 99.6), "1230 ± 100");
  EXPECT_EQ(written(123.45, 9.96), "123 ± 10");
}

TEST(NumberFormat, RoundsToTensForLargeU) {
  EXPECT_EQ(written(12345, 1234), "12 300 ± 1200");
  EXPECT_EQ(written(12345, 123), "12 350 ± 120");
  EXPECT_EQ(written(54, 123), "50 ± 120");
}

TEST(NumberFormat, HasPowerOfTenFarFromOne) {
  EXPECT_EQ(written(2e-9, 6.06e-11), "(2.000 ± 0.061) × 10⁻⁹");
  EXPECT_EQ(written(1.5e9, 2e7), "(1.500 ± 0.020) × 10⁹");
  EXPECT_EQ(plain(format_parts(kEn, with_expanded(2e-9, 6.06e-11)).expanded), "0.061 × 10⁻⁹");
}

TEST(NumberFormat, HasNoSignForZero) {
  EXPECT_EQ(written(-0.00001, 0.01), "0.000 ± 0.010");
  EXPECT_EQ(written(0, 0.0000606), "0.000 000 ± 0.000 061");
}

TEST(NumberFormat, HasAtMostFourDigitsWithoutU) {
  EXPECT_EQ(plain(format(kEn, {.value = 20})), "20");
  EXPECT_EQ(plain(format(kEn, {.value = 12345})), "12 345");
  EXPECT_EQ(plain(format(kEn, {.value = 0.0005})), "0.0005");
  EXPECT_EQ(plain(format(kEn, {.value = 0.123456})), "0.1235");
  EXPECT_EQ(plain(format(kEn, {.value = 1.5e-7})), "1.5 × 10⁻⁷");
  EXPECT_EQ(plain(format(kDe, {.value = -0.31})), "−0,31");
  EXPECT_EQ(plain(format(kEn, {.value = 0})), "0");
  EXPECT_EQ(plain(format(kEn, {.value = 100.5})), "100.5");
}

TEST(NumberFormat, OmitsUThatIsZeroOrUnknown) {
  EXPECT_EQ(written(0.25, 0), "0.25");
  EXPECT_EQ(written(0.25, kNaN), "0.25");
  EXPECT_EQ(written(0.25, std::numeric_limits<double>::infinity()), "0.25");
  EXPECT_EQ(written(kNaN, 0.1), "–");
  EXPECT_EQ(format_parts(kEn, with_expanded(0.25, 0)).expanded, "");
}

TEST(NumberFormat, GroupsMoreThanFourDigits) {
  EXPECT_EQ(plain(format_number(kEn, 1234, 0)), "1234");
  EXPECT_EQ(plain(format_number(kEn, 1234567.25, 2)), "1 234 567.25");
  EXPECT_EQ(plain(format_number(kDe, 0.123456, 6)), "0,123 456");
  EXPECT_EQ(plain(format_number(kEn, 0.1234, 4)), "0.1234");
  EXPECT_EQ(format_number(kEn, kNaN, 3), "–");
}

TEST(NumberFormat, KeepsSignificantDigits) {
  EXPECT_EQ(plain(format_significant(kEn, 0.0005, 2)), "0.000 50");
  EXPECT_EQ(plain(format_significant(kEn, 0.0996, 2)), "0.10");
  EXPECT_EQ(plain(format_significant(kEn, 19.77, 2)), "20");
  EXPECT_EQ(plain(format_significant(kDe, 1.25e-6, 3)), "1,25 × 10⁻⁶");
}

TEST(NumberFormat, NeverShowsProbabilityAsCertain) {
  EXPECT_EQ(plain(format_probability(kEn, 0.9821)), "98.2 %");
  EXPECT_EQ(plain(format_probability(kDe, 1)), "> 99,9 %");
  EXPECT_EQ(plain(format_probability(kEn, 0)), "< 0.1 %");
  EXPECT_EQ(format_probability(kEn, kNaN), "–");
}

/// The printed value, U and limit give the verdict.
TEST(NumberFormat, HasDigitsThatGiveVerdict) {
  const auto printed = [](double value, double expanded, double limit, DecisionRule rule) {
    return plain(format_compared(kEn, compare_with_limits(with_expanded(value, expanded), limit, rule)));
  };
  constexpr auto kGuard = DecisionRule::guard_band, kSimple = DecisionRule::simple;
  EXPECT_EQ(printed(0.000991, 0.0071, 0.001, kGuard), "0.0010 ± 0.0071") << "0.0010 is not above 0.001";
  EXPECT_EQ(printed(-0.001012, 0.0071, 0.001, kGuard), "−0.001 01 ± 0.007 10") << "conditional fail";
  EXPECT_EQ(printed(-0.001012, 0.0071, 0.001, kSimple), "−0.001 01 ± 0.007 10");
  EXPECT_EQ(printed(0.10004, 0.021, 0.1, kSimple), "0.100 04 ± 0.021 00");
  EXPECT_EQ(printed(0.0790, 0.0208, 0.1, kGuard), "0.079 ± 0.021") << "both rounded numbers give the verdict";
  EXPECT_EQ(printed(0.2, 0.021, 0.1, kGuard), "0.200 ± 0.021");
  EXPECT_EQ(printed(0.100004, kNaN, 0.1, kSimple), "0.100 004");
  EXPECT_EQ(printed(0.123456, kNaN, 0.1, kSimple), "0.1235");
  EXPECT_EQ(printed(kNaN, kNaN, 0.1, kSimple), "–");
}

TEST(DayFormat, FollowsLanguage) {
  EXPECT_EQ(format_day(kEn, "2026-11-25"), "25 November 2026");
  EXPECT_EQ(format_day(kDe, "2026-03-05"), "5. März 2026");
  EXPECT_EQ(format_day(kEn, "2026-13-05"), "2026-13-05");
  EXPECT_EQ(format_day(kEn, "soon"), "soon");
  EXPECT_EQ(format_day(kEn, ""), "");
  EXPECT_EQ(format_instant(kDe, "2026-11-25T14:03:07Z"), "25. November 2026, 14:03:07 UTC");
  EXPECT_EQ(format_instant(kDe, "yesterday"), "yesterday");
}

TEST(UnitFormat, FollowsNumberWithBlankUnlessAngle) {
  for (const char* angle : {"°", "′", "″"}) EXPECT_EQ(append_unit("0.0100", angle), std::string("0.0100") + angle);
  for (const char* unit : {"K", "°C", "ppm"}) EXPECT_EQ(append_unit("2", unit), std::string("2\u00a0") + unit);
  EXPECT_EQ(append_unit("2", "°/h"), "2\u00a0°/\u2060h");
  EXPECT_EQ(append_unit("2", "1"), "2");
}

TEST(UnitFormat, HasSingleFraction) {
  EXPECT_EQ(format_unit("°/h/K"), "°/\u2060(h·K)");
  EXPECT_EQ(format_unit("°/√h"), "°/\u2060√h");
  EXPECT_EQ(format_unit("°C"), "°C");
  EXPECT_EQ(format_unit("1"), "");
  EXPECT_EQ(remove_word_joiners(format_unit("°/h/√h")), "°/(h·√h)");
  EXPECT_EQ(plain(remove_word_joiners(name_with_unit("Bias", "°/h"))), "Bias / (°/h)");
  EXPECT_EQ(plain(name_with_unit("Temperature", "°C")), "Temperature / °C");
  EXPECT_EQ(plain(name_with_unit("Starts", "1")), "Starts");
}

}  // namespace
}  // namespace gyrotherm::report
