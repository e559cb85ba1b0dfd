// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "tests/sequencer/profile/profiles.hpp"
#include "tests/support/growth.hpp"

namespace gyrotherm::profile {
namespace {

struct Wrong {
  std::string segments;  ///< first line: 4
  std::string said;
};

void PrintTo(const Wrong& wrong, std::ostream* os) { *os << wrong.segments; }

class Mistake : public testing::TestWithParam<Wrong> {};

TEST_P(Mistake, IsReportedWithPosition) { EXPECT_EQ(profile_errors(GetParam().segments), GetParam().said); }

const std::string kRamp = kHold20 + "[[segment]]\nkind = \"ramp\"\n";      // continues at line 10
const std::string kRepeat = kHold20 + "[[segment]]\nkind = \"repeat\"\n";  // continues at line 10
const std::string kRandom = kHold20 +
                            "[[segment]]\nkind = \"random\"\nseed = 1\nduration = \"1 h\"\nrates = [1, 5]\n"
                            "hold = [\"1 s\", \"1 min\"]\n";  // continues at line 14

INSTANTIATE_TEST_SUITE_P(
    Holds, Mistake,
    testing::Values(
        Wrong{"", "p.toml:1:1: no segment, expected at least one"},
        Wrong{"[[segment]]\nkind = \"hold\"\ntime = \"1 h\"\n",
              "p.toml:4:1: missing key \"at\", expected a temperature in the first hold"},
        Wrong{"[[segment]]\nkind = \"hold\"\nat = 20\n",
              "p.toml:4:1: missing key \"time\", expected a duration like \"2 h\" or \"90 s\""},
        Wrong{"[[segment]]\nkind = \"hold\"\nat = 20\ntime = \"0 s\"\n",
              "p.toml:7:8: \"time\" is zero, expected a time longer than zero"},
        Wrong{"[[segment]]\nkind = \"hold\"\nat = 20\ntime = \"-1 h\"\n",
              "p.toml:7:8: \"time\" is \"-1 h\", expected a duration like \"2 h\" or \"90 s\""},
        Wrong{"[[segment]]\nkind = \"hold\"\nat = -300\ntime = \"1 h\"\n",
              "p.toml:6:6: \"at\" is -300 °C, expected -273.15 to 1000 °C"},
        Wrong{kHold20 + "soak_band = \"0 K\"\n", "p.toml:8:13: \"soak_band\" is 0 K, expected more than 0 K"},
        Wrong{kHold20 + "naem = 5\n", "p.toml:8:1: unknown key \"naem\", did you mean \"name\"?"},
        Wrong{"[[segment]]\nkind = \"hodl\"\nat = 20\n",
              "p.toml:5:8: \"hodl\" is not one of hold, ramp, repeat, random; did you mean \"hold\"?"},
        Wrong{"[[segment]]\nat = 20\n", "p.toml:4:1: missing key \"kind\", expected text"},
        Wrong{"[defaults]\nsoak_time = \"0 s\"\n" + kHold20,
              "p.toml:5:13: \"soak_time\" is zero, expected a time longer than zero"},
        Wrong{"[accept]\nrandom.raw = \"much\"\n" + kHold20, "p.toml:5:14: \"raw\" is \"much\", expected a number"},
        Wrong{"segment = 5\n", "p.toml:4:11: \"segment\" is not an array of tables, expected [[segment]]"}));

INSTANTIATE_TEST_SUITE_P(
    Ramps, Mistake,
    testing::Values(
        Wrong{"[[segment]]\nkind = \"ramp\"\nto = 30\nrate = 1\n",
              "p.toml:4:1: the start of this ramp is unknown, expected a hold with \"at\" before it"},
        Wrong{kRamp + "rate = 1\n", "p.toml:8:1: missing key \"to\", expected a temperature like 20 or \"20 °C\""},
        Wrong{kRamp + "to = 30\n", "p.toml:8:1: neither \"rate\" nor \"time\" is given, expected one of them"},
        Wrong{kRamp + "to = 30\nrate = 1\ntime = \"1 h\"\n",
              "p.toml:12:8: \"rate\" and \"time\" are both given, expected one of them"},
        Wrong{kRamp + "to = 30\nrate = 0\n",
              "p.toml:11:8: \"rate\" is 0 °C/min, expected more than 0, at most 1000 °C/min"},
        Wrong{kRamp + "to = 30\nrate = \"-5 °C/min\"\n",
              "p.toml:11:8: \"rate\" is -5 °C/min, expected more than 0, at most 1000 °C/min"},
        Wrong{kRamp + "to = 20\nrate = 1\n", "p.toml:10:6: the ramp changes nothing: the set point is 20 °C already"},
        Wrong{kRamp + "to = 30\nrate = 1e-9\n",
              "p.toml:8:1: a ramp over 10 K at 1e-09 °C/min takes more than 100000000 s, the limit"},
        Wrong{kRamp + "to = 30\nrate = 1\nguaranteed_soak = true\n", "p.toml:12:1: unknown key \"guaranteed_soak\""}));

INSTANTIATE_TEST_SUITE_P(
    Repeats, Mistake,
    testing::Values(
        Wrong{kRepeat + "count = 3\n", "p.toml:8:1: no segment, expected at least one"},
        Wrong{kRepeat + "count = 0\n[[segment.segment]]\nkind = \"hold\"\ntime = \"1 s\"\n",
              "p.toml:10:9: \"count\" is 0, expected 1 or more"},
        Wrong{kRepeat + "count = -1\n[[segment.segment]]\nkind = \"hold\"\ntime = \"1 s\"\n",
              "p.toml:10:9: \"count\" is -1, expected 1 or more"},
        Wrong{kRepeat + "[[segment.segment]]\nkind = \"hold\"\ntime = \"1 s\"\n",
              "p.toml:8:1: a repeat has either \"count\" or \"rates\", expected one of them"},
        Wrong{kRepeat + "count = 1\nrates = [1]\n[[segment.segment]]\nkind = \"hold\"\ntime = \"1 s\"\n",
              "p.toml:8:1: a repeat has either \"count\" or \"rates\", expected one of them"},
        Wrong{kRepeat + "rates = []\n[[segment.segment]]\nkind = \"hold\"\ntime = \"1 s\"\n",
              "p.toml:10:9: \"rates\" is empty, expected one for each pass"},
        Wrong{kRepeat + "count = 2\n[[segment.segment]]\nkind = \"ramp\"\nto = 30\n",
              "p.toml:11:1: neither \"rate\" nor \"time\" is given, expected one of them"},
        Wrong{kRepeat + "count = 5\n[[segment.segment]]\nkind = \"ramp\"\nto = 20\nrate = 1\n",
              "p.toml:13:6: the ramp changes nothing: the set point is 20 °C already"},
        Wrong{kRepeat + "count = 2\ncycle = true\n[[segment.segment]]\nkind = \"repeat\"\ncount = 2\ncycle = true\n"
                        "[[segment.segment.segment]]\nkind = \"hold\"\ntime = \"1 s\"\n",
              "p.toml:15:9: a cycle inside a cycle, expected one level of cycles"}));

INSTANTIATE_TEST_SUITE_P(
    RandomPrograms, Mistake,
    testing::Values(
        Wrong{kRandom, "p.toml:8:1: \"targets\" is empty, expected rows of [low, high]"},
        Wrong{kRandom + "targets = [[10, -10]]\n", "p.toml:14:11: \"targets\" is not a range, expected [low, high]"},
        Wrong{kRandom + "targets = [[1, 2, 3]]\n", "p.toml:14:11: \"targets\" is not a range, expected [low, high]"},
        Wrong{kRandom + "targets = [[0, 5000]]\n", "p.toml:14:11: \"targets\" is 5000 °C, expected -273.15 to 1000 °C"},
        Wrong{kRandom + "targets = [[0, 10]]\nleast_step = 30\n",
              "p.toml:15:14: no target is 30 K away from 20 °C, expected a smaller step"},
        Wrong{
            "[[segment]]\nkind = \"random\"\nseed = -1\nduration = \"1 h\"\nrates = [0, 5]\nhold = [\"0 s\", \"1 h\"]\n"
            "targets = [[0, 50]]\n",
            "p.toml:6:8: \"seed\" is -1, expected 0 or more\n"
            "p.toml:8:9: \"rates\" is 0 °C/min, expected more than 0, at most 1000 °C/min\n"
            "p.toml:9:8: \"hold\" is zero, expected a time longer than zero\n"
            "p.toml:4:1: the start of this random program is unknown, expected a hold with \"at\" before it"}));

TEST(Mistakes, AreAllReportedInOrderOfFile) {
  EXPECT_EQ(profile_errors("[[segment]]\nkind = \"hold\"\nat = \"warm\"\ntime = 5\nsoka_band = 1\n"
                           "[[segment]]\nkind = \"ramp\"\nto = 30\n"),
            "p.toml:6:6: \"at\" is \"warm\", expected a temperature like 20 or \"20 °C\"\n"
            "p.toml:7:8: \"time\" is 5, expected a duration like \"2 h\" or \"90 s\"\n"
            "p.toml:8:1: unknown key \"soka_band\", did you mean \"soak_band\"?\n"
            "p.toml:9:1: neither \"rate\" nor \"time\" is given, expected one of them");
}

TEST(Mistakes, IncludeUnknownSchema) {
  const auto p = parse_profile("schema = \"gyrotherm-profile/2\"\nname = \"p\"\n" + kHold20, "p.toml");
  ASSERT_FALSE(p);
  EXPECT_EQ(p.error().kind, FaultKind::bad_file);
  EXPECT_EQ(text(p.error()),
            "p.toml:1:10: \"gyrotherm-profile/2\" is not understood, expected \"gyrotherm-profile/1\"");
}

TEST(Mistakes, OmitOtherErrorsWhenFileIsOfAnotherKind) {
  const auto p = parse_profile("schema = \"gyrotherm-rig/1\"\nname = \"p\"\nsegment = 5\n", "p.toml");
  ASSERT_FALSE(p);
  EXPECT_EQ(text(p.error()), "p.toml:1:10: the schema of this file is gyrotherm-rig/1, expected gyrotherm-profile/1");
}

/// Returns `depth` nested_repeats repeats around one hold, each with `count` passes.
std::string nested_repeats(int depth, const std::string& count) {
  std::string segments, path = "segment";
  for (int i = 0; i < depth; ++i, path += ".segment")
    segments += "[[" + path + "]]\nkind = \"repeat\"\ncount = " + count + "\n";
  return segments + "[[" + path + "]]\nkind = \"hold\"\nat = 20\ntime = \"1 s\"\n";
}

/// An expansion would never end.
TEST(RepeatBomb, IsRefusedWithoutExpansion) {
  EXPECT_EQ(profile_errors(nested_repeats(7, "9223372036854775807")),
            "p.toml:25:1: the profile exceeds 20000 segments or 100000000 s here");
}

TEST(RepeatBomb, AllowsTwentyThousandSegments) {
  EXPECT_EQ(parsed(nested_repeats(1, "20000")).segments.size(), 20'000u);
  EXPECT_NE(profile_errors(nested_repeats(1, "20001")), "nothing");
}

/// Returns this number of holds in a row.
std::string written_holds(int count) {
  std::string segments;
  for (int i = 0; i < count; ++i) segments += "[[segment]]\nkind = \"hold\"\nat = 20\ntime = \"1 s\"\n";
  return segments;
}

TEST(ProfileMistakes, EmptyNameAndNegativeLimitAreRefused) {
  const std::string hold = "[[segment]]\nkind = \"hold\"\nat = 20\ntime = \"1 s\"\n";
  const auto error_of = [&](const std::string& name, const std::string& limit) {
    const auto parsed = parse_profile(
        "schema = \"gyrotherm-profile/1\"\nname = \"" + name + "\"\naccept.random.std = " + limit + "\n" + hold,
        "p.toml");
    return parsed ? "" : text(parsed.error());
  };
  EXPECT_EQ(error_of("x", "0"), "");
  EXPECT_EQ(error_of("", "0.5"), "p.toml:2:8: \"name\" is empty, expected a name");
  EXPECT_EQ(error_of("x", "-0.5"), "p.toml:3:21: \"std\" is -0.5, expected 0 or more");
}

TEST(SegmentBomb, IsParsedInLinearTime) {
  const auto read = [](int count) { EXPECT_EQ(std::ssize(parsed(written_holds(count)).segments), count); };
  EXPECT_LT(tests::growth_over_ten(read, 2'000), tests::kLargestLinearGrowth);
  EXPECT_EQ(profile_errors(written_holds(20'001)),
            "p.toml:80004:1: the profile exceeds 20000 segments or 100000000 s here");
}

TEST(SegmentBomb, ReportsFirstHundredErrors) {
  std::string told;
  const auto refuse = [&](int count) {
    std::string segments;
    for (int i = 0; i < count; ++i) segments += "[[segment]]\nkind = \"hold\"\nat = 20\ntime = \"1 s\"\nx = 1\n";
    told = profile_errors(segments);
  };
  EXPECT_LT(tests::growth_over_ten(refuse, 2'000), tests::kLargestLinearGrowth);
  EXPECT_TRUE(told.starts_with("p.toml:8:1: unknown key \"x\"\np.toml:13:1: unknown key")) << told.substr(0, 200);
  EXPECT_EQ(std::count(told.begin(), told.end(), '\n'), 100);
  EXPECT_TRUE(told.ends_with("p.toml: more errors than the 100 reported here"));
}

TEST(RepeatBomb, RefusesProfileLongerThanMaximum) {
  EXPECT_EQ(
      profile_errors("[[segment]]\nkind = \"repeat\"\ncount = 1000\n[[segment.segment]]\nkind = \"hold\"\nat = 20\n"
                     "time = \"1000 d\"\n"),
      "p.toml:7:1: the profile exceeds 20000 segments or 100000000 s here");
}

TEST(RepeatBomb, LimitsNesting) {
  EXPECT_EQ(parsed(nested_repeats(7, "1")).segments.size(), 1u);
  EXPECT_EQ(profile_errors(nested_repeats(8, "1")), "p.toml:25:1: repeats are nested deeper than 8 levels");
}

}  // namespace
}  // namespace gyrotherm::profile
