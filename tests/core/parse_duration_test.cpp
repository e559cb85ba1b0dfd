#include <gtest/gtest.h>

#include <chrono>
#include <string>
#include <utility>
#include <vector>

#include "core/toml_reader.hpp"

namespace gyrotherm {
namespace {

using std::chrono::hours;
using std::chrono::milliseconds;
using std::chrono::minutes;
using std::chrono::seconds;

TEST(ParseDuration, KnownTexts) {
  const std::vector<std::pair<std::string, Duration>> golden{
      {"2 h", hours(2)},           {"2h", hours(2)},         {"90 s", seconds(90)},
      {"1 h 30 min", minutes(90)}, {"1h30min", minutes(90)}, {"250 ms", milliseconds(250)},
      {"1.5 h", minutes(90)},      {" 1 d ", hours(24)},     {"0 s", seconds(0)},
      {"+5 s", seconds(5)},        {"1e3 s", seconds(1000)}, {"100000000 s", seconds(100'000'000)}};
  for (const auto& [text, expected] : golden) {
    const auto d = parse_duration(text);
    ASSERT_TRUE(d.has_value()) << text;
    EXPECT_EQ(*d, expected) << text;
  }
}

TEST(ParseDuration, RefusesAndNamesWhatIsNone) {
  for (const std::string text : {"", " ", "5", "h", "5 hours", "-5 s", "+-5 s", "1 h -30 min", "nan s", "inf s",
                                 "1e9 s", "1e400 s", "5 s x", "5 m", "1 h . 5 min", "0x10 s"}) {
    const auto d = parse_duration(text);
    ASSERT_FALSE(d.has_value()) << text;
    EXPECT_EQ(d.error().kind, FaultKind::bad_file);
    EXPECT_NE(d.error().what.find("\"" + text + "\""), std::string::npos);
  }
}

}  // namespace
}  // namespace gyrotherm
