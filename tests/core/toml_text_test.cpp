#include "core/toml_text.hpp"

#include <gtest/gtest.h>

#include <filesystem>

#include "core/text_file.hpp"

namespace gyrotherm {
namespace {

/// "line:column", or "" if there is no flaw.
std::string place(std::string_view text) {
  const auto flaw = flaw_of(text);
  return flaw ? std::to_string(flaw->line) + ":" + std::to_string(flaw->column) : "";
}

TEST(TomlText, TextsAndCommentsTakeAnyCharacter) {
  for (const char* text :
       {"a = \"20 °C\" # °C\nb = '°'\n", "a = \"\"\"°\n°\"\"\"\n", "a = '''°\n'°'''\n# °", "a = \"\" # °\nb = ''\n",
        "a = \"\\\"°\\\\\" # °\n", "a = \"\"\"\"°\"\"\"\"\" # °\n", "a = \"\"\"\"\"\" # °", "\xEF\xBB\xBF# °\na = 1",
        "a = \"\"\"x \\\n   y°\"\"\"", "a = '\\' # °"})
    EXPECT_EQ(place(text), "") << text;
}

TEST(TomlText, OutsideThemAnyCharacterBeyondAsciiHasItsPlace) {
  EXPECT_EQ(place("\xCA\xBF\n8"), "1:1");
  EXPECT_EQ(place("a = \"°°\" °"), "1:10");
  EXPECT_EQ(place("a = 1\n  ° = 2"), "2:3");
  EXPECT_EQ(place("a = '''\n''' °"), "2:5");
  EXPECT_EQ(place("a = \"\"\"\n\"\"\"\"\" °"), "2:7");
  EXPECT_EQ(place("# °\n\u3000"), "2:1");
}

// toml++ looks for blanks there as it does outside.
TEST(TomlText, AContinuedLineDoesNotBeginWithOne) {
  EXPECT_EQ(place("a = \"\"\"x \\\n  °\"\"\""), "2:3");
  EXPECT_EQ(place("a = \"\"\"x \\\n  y°\"\"\""), "");
  EXPECT_EQ(place("a = \"\\°\""), "1:7");
}

TEST(TomlText, BytesThatAreNotUtf8HaveTheirPlace) {
  for (const char* bytes : {"\x80", "\xC0\x80", "\xC1\xBF", "\xE0\x9F\xBF", "\xED\xA0\x80", "\xF0\x8F\xBF\xBF",
                            "\xF4\x90\x80\x80", "\xF5\x80\x80\x80", "\xFF", "\xE2\x82", "\xC2"})
    EXPECT_EQ(place("# é\n# " + std::string(bytes)), "2:3") << bytes;
  for (const char* text :
       {"\xC2\x80", "\xE0\xA0\x80", "\xED\x9F\xBF", "\xEE\x80\x80", "\xF0\x90\x80\x80", "\xF4\x8F\xBF\xBF"})
    EXPECT_EQ(place("# " + std::string(text)), "") << text;
}

TEST(TomlText, ATextThatIsNotEndedOnItsLineIsTheGrammarsToTell) {
  EXPECT_EQ(place("a = \"x\n° = 1"), "");
  EXPECT_EQ(place("a = 'x\n° = 1"), "");
}

TEST(TomlText, EveryShippedFileIsWithoutFlaw) {
  int files = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(GYROTHERM_SOURCE_DIR "/profiles")) {
    if (entry.path().extension() != ".toml") continue;
    EXPECT_EQ(place(read_text_file(entry.path()).value()), "") << entry.path();
    ++files;
  }
  EXPECT_GT(files, 20);
}

}  // namespace
}  // namespace gyrotherm
