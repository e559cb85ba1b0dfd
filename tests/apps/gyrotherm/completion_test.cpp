// SPDX-License-Identifier: Apache-2.0
/// Completion of commands, options, choices, shipped names and files by their ending, in each shell.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>

#include "tests/apps/gyrotherm/program.hpp"

namespace gyrotherm::app {
namespace {

std::set<std::string> words_in(const std::string& text) {
  std::set<std::string> words;
  std::istringstream stream(text);
  for (std::string word; stream >> word;) words.insert(word);
  return words;
}

const std::string kBuild = std::filesystem::path(GYROTHERM_PROGRAM).parent_path().string();

/// Folder with a record, a table, a folder and the shell's script.
class Completion : public ::testing::TestWithParam<std::string> {
 protected:
  void SetUp() override {
    if (!installed(GetParam())) GTEST_SKIP() << GetParam() << " is not installed";
    std::ofstream(folder_ / "mine.db") << "";
    std::ofstream(folder_ / "mine.csv") << "";
    std::ofstream(folder_ / "mine.toml") << "";
    std::filesystem::create_directory(folder_ / "minute");
    const auto name = GetParam() == "zsh" ? "_gyrotherm" : "script";
    const auto ran = shell("gyrotherm completion " + GetParam() + " > '" + (folder_ / name) + "'");
    ASSERT_EQ(ran.exit_code, 0) << ran.err;
  }

  /// Returns the completions of the last token of a line.
  std::set<std::string> offered(const std::string& line) {
    const auto ran = GetParam() == "bash" ? in_bash(line) : GetParam() == "zsh" ? in_zsh(line) : in_fish(line);
    EXPECT_EQ(ran.err, "");
    return words_in(ran.out);
  }

 private:
  Ran in(const std::string& command) {
    return shell("cd '" + (folder_ / "") + "' && PATH='" + kBuild + "':$PATH " + command);
  }
  Ran in_bash(const std::string& line) {
    std::ofstream(folder_ / "ask") << ". ./script\nread -r -a COMP_WORDS <<< '" << line << "'\n[[ '" << line
                                   << "' == *' ' ]] && COMP_WORDS+=('')\nCOMP_CWORD=$((${#COMP_WORDS[@]} - 1))\n"
                                      "_gyrotherm\nprintf '%s\\n' \"${COMPREPLY[@]}\"\n";
    return in("bash --norc ask");
  }
  Ran in_fish(const std::string& line) {
    std::ofstream(folder_ / "ask") << "source script\ncomplete -C '" << line << "'\n";
    return in("HOME=$PWD fish --no-config ask | cut -f 1");
  }
  /// Runs zsh on a terminal of its own and writes down all added matches.
  Ran in_zsh(const std::string& line) {
    std::ofstream(folder_ / "hooks") << R"(compadd() {
  if [[ ${@[1,(i)(-|--)]} == *-(O|A|D)\ * ]]; then builtin compadd "$@"; return; fi
  local -a __added
  builtin compadd -A __added "$@"
  print -l -- $__added >> matches
  builtin compadd "$@"
}
report() { compstate[insert]=; compstate[list]=; : > finished }
comppostfuncs=(report)
)";
    std::ofstream(folder_ / "ask") << R"(zmodload zsh/zpty
rm -f matches finished
zpty shell zsh -f -i
zpty -w shell 'PS1=; fpath=($PWD $fpath); autoload -U compinit; compinit -u -D; . ./hooks'
zpty -w -n shell $')" << line << R"(\t'
for ((i = 0; i < 100; ++i)); do [[ -e finished ]] && break; sleep 0.1; done
zpty -d shell
[[ -e matches ]] && cat matches
true
)";
    return in("HOME=$PWD TERM=dumb zsh -f ask");
  }

  Folder folder_;
};

TEST_P(Completion, CompletesCommand) {
  EXPECT_TRUE(offered("gyrotherm qua").contains("qualify"));
  const auto all = offered("gyrotherm ");
  for (const auto* command : {"run", "report", "doctor", "export-model"}) EXPECT_TRUE(all.contains(command)) << command;
  EXPECT_FALSE(all.contains("manual"));
  EXPECT_TRUE(offered("gyrotherm report si").contains("sign"));
}

TEST_P(Completion, CompletesOption) {
  const auto offers = offered("gyrotherm run --");
  for (const auto* option : {"--rig", "--out", "--seed"}) EXPECT_TRUE(offers.contains(option)) << option;
  EXPECT_FALSE(offers.contains("--mesh"));
  EXPECT_TRUE(offered("gyrotherm report sign --ce").contains("--certificate"));
}

TEST_P(Completion, CompletesShippedNameAndFile) {
  const auto profiles = offered("gyrotherm run ");
  for (const auto* name : {"qualification", "random", "mine.toml"}) EXPECT_TRUE(profiles.contains(name)) << name;
  EXPECT_FALSE(profiles.contains("mine.csv"));
  EXPECT_TRUE(offered("gyrotherm run random --rig virtual-").contains("virtual-lot"));
}

TEST_P(Completion, CompletesFileByEnding) {
  const auto records = offered("gyrotherm status mi");
  EXPECT_TRUE(records.contains("mine.db"));
  EXPECT_FALSE(records.contains("mine.csv"));
}

TEST_P(Completion, CompletesChoice) {
  EXPECT_TRUE(offered("gyrotherm verify m.json --outside co").contains("continue"));
  EXPECT_TRUE(offered("gyrotherm train r.db --method ri").contains("ridge-u"));
}

TEST_P(Completion, CompletesValueAfterEqualsSign) {
  const auto offered_for = [&](const std::string& command, const std::string& option, const std::string& begun) {
    // bash splits at the sign; fish completes the whole token
    return offered(command + option + (GetParam() == "bash" ? " = " : "=") + begun);
  };
  const auto has = [&](const std::set<std::string>& offers, const std::string& option, const std::string& value) {
    return offers.contains(GetParam() == "fish" ? option + "=" + value : value);
  };
  EXPECT_TRUE(has(offered_for("gyrotherm run random ", "--rig", "virtual-lo"), "--rig", "virtual-lot"));
  EXPECT_TRUE(has(offered_for("gyrotherm train r.db ", "--method", "ri"), "--method", "ridge-u"));
  EXPECT_TRUE(has(offered_for("gyrotherm run random ", "--out", "mi"), "--out", "mine.db"));
}

INSTANTIATE_TEST_SUITE_P(In, Completion, ::testing::Values("bash", "zsh", "fish"),
                         [](const auto& shell) { return shell.param; });

TEST(CompletionOfBash, TreatsEqualsSignAsToken) {
  const auto ran = shell(
      "gyrotherm completion bash > /tmp/gyrotherm-completion-$$ && bash --norc -c '. /tmp/gyrotherm-completion-$0; "
      "COMP_WORDS=(" GYROTHERM_PROGRAM
      " run --rig = virtual-lo) COMP_CWORD=4; _gyrotherm; echo ${COMPREPLY[@]}' $$; rm /tmp/gyrotherm-completion-$$");
  EXPECT_EQ(ran.out, "virtual-lot\n") << ran.err;
}

TEST(CompletionOfBash, OffersNoNameForFile) {
  const auto ran = shell(kBuild + "/gyrotherm-thermal completion bash | grep -F \"'reduce/1'\"");
  EXPECT_EQ(ran.out, "    'reduce/1') offer='files toml' ;;\n") << "the result is written next to the file";
}

TEST(CompletionCommand, RefusesUnknownShellsAndKinds) {
  EXPECT_EQ(gyrotherm_with("completion").exit_code, 2);
  EXPECT_EQ(gyrotherm_with("completion tcsh").exit_code, 2);
  EXPECT_EQ(gyrotherm_with("completion --names RECORD").exit_code, 2);
}

}  // namespace
}  // namespace gyrotherm::app
