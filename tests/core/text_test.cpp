// SPDX-License-Identifier: Apache-2.0
#include "core/text.hpp"

#include <gtest/gtest.h>

#include <random>
#include <vector>

namespace gyrotherm {
namespace {

TEST(Substitute, ReplacesEachOccurrenceOnce) {
  struct Case {
    const char *text, *from, *to, *expected;
  };
  for (const auto& [text, from, to, expected] :
       {Case{"", "a", "b", ""}, Case{"abc", "x", "y", "abc"}, Case{"aaa", "a", "", ""},
        Case{"aaa", "a", "aa", "aaaaaa"}, Case{"aaa", "aa", "b", "ba"}, Case{"a-b-", "-", "--", "a--b--"},
        Case{"x", "x", "yxz", "yxz"}, Case{"it's", "'", "'\\''", "it'\\''s"}, Case{"−1 − 2", "−", "-", "-1 - 2"}})
    EXPECT_EQ(substitute(text, from, to), expected) << text;
}

TEST(PlainText, KeepsLettersOfAnyScript) {
  for (const std::string text :
       {"", "Watlow F4T 4.2", "−40 … 80 °C ± 0,3 K", "室温", "Ωμέγα \xF0\x9F\x8C\xA1", "a\\x1b"})
    EXPECT_EQ(plain(text), text);
}

TEST(PlainText, EscapesTerminalControls) {
  EXPECT_EQ(plain("\x1b]0;owned\x07"), "\\x1b]0;owned\\x07");
  EXPECT_EQ(plain("a\rb\x7f"), "a\\x0db\\x7f");
  EXPECT_EQ(plain(std::string_view("\0", 1)), "\\x00");
  EXPECT_EQ(plain("\xC2\x9B"
                  "31m"),
            "\\u009b31m");
}

TEST(PlainText, EscapesMarksOfWritingDirection) {
  EXPECT_EQ(plain("\u202Egnp.exe"), "\\u202egnp.exe");
  EXPECT_EQ(plain("\u2066\u2069"), "\\u2066\\u2069");
  EXPECT_EQ(plain("\u2029\u2065\u206A"), "\u2029\u2065\u206A");
}

TEST(PlainText, EscapesInvalidUtf8) {
  EXPECT_EQ(plain("\xff\xfe"), "\\xff\\xfe");
  EXPECT_EQ(plain("\xC0\x9B"), "\\xc0\\x9b");
  EXPECT_EQ(plain("\xE2\x80"), "\\xe2\\x80");
  EXPECT_EQ(plain("20 \xB0"
                  "C"),
            "20 \\xb0C");
}

TEST(PlainText, KeepsLineEndsAndTabsOnRequest) {
  EXPECT_EQ(plain("a\n\tb\r"), "a\\x0a\\x09b\\x0d");
  EXPECT_EQ(plain("a\n\tb\r", Blanks::kept), "a\n\tb\\x0d");
}

TEST(PlainText, IsValidUtf8WithoutControlsForAnyBytes) {
  std::mt19937 random(20260101);
  for (int i = 0; i < 20'000; ++i) {
    std::string bytes(random() % 40, '\0');
    for (char& byte : bytes) byte = static_cast<char>(random() % 3 == 0 ? 0xC2 + random() % 0x30 : random());
    const auto shown = plain(bytes);
    ASSERT_TRUE(is_utf8(shown)) << i;
    ASSERT_EQ(plain(shown), shown) << i;
    for (const unsigned char c : shown) ASSERT_TRUE(c >= ' ' && c != 0x7F) << i;
    if (is_utf8(bytes)) continue;
    ASSERT_NE(shown.find("\\x"), std::string::npos) << i;
  }
}

const std::vector<std::string> kKnownWords{"qualify", "run", "resume", "report"};

TEST(Nearest, FindsMisspeltWord) {
  EXPECT_EQ(find_nearest("qualfy", kKnownWords), "qualify");
  EXPECT_EQ(find_nearest("resmue", kKnownWords), "resume");
  EXPECT_EQ(find_nearest("rn", kKnownWords), "run");
}

TEST(Nearest, ReturnsKnownWordUnchanged) {
  for (const auto& word : kKnownWords) EXPECT_EQ(find_nearest(word, kKnownWords), word);
}

TEST(Nearest, IsEmptyWithoutSimilarWord) {
  EXPECT_EQ(find_nearest("thermometer", kKnownWords), "");
  EXPECT_EQ(find_nearest("qualify", {}), "");
}

TEST(Nearest, IsEmptyIfHalfOfTheWordDiffers) {
  const auto nearest = [](const char* word, const std::vector<std::string>& known) {
    return find_nearest(word, known);
  };
  EXPECT_EQ(nearest("4", {"1", "2"}), "");
  EXPECT_EQ(nearest("fr", {"en", "de"}), "");
  EXPECT_EQ(nearest("at", {"out"}), "");
  EXPECT_EQ(nearest(";", {".", ","}), "");
  EXPECT_EQ(nearest("", {"A"}), "");
  EXPECT_EQ(nearest("rum", {"run"}), "run");
  EXPECT_EQ(nearest("hodl", {"ramp", "hold"}), "hold") << "exchanged letters are one error";
}

TEST(Nearest, IgnoresCase) {
  EXPECT_EQ(find_nearest("QUALIFY", kKnownWords), "qualify");
  EXPECT_EQ(find_nearest("Rn", kKnownWords), "run");
}

}  // namespace
}  // namespace gyrotherm
