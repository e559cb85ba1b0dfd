// SPDX-License-Identifier: Apache-2.0
/// `gyrotherm new rig` with options, at a terminal, and against simulated instruments.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/file.hpp"
#include "tests/apps/gyrotherm/listener.hpp"
#include "tests/apps/gyrotherm/program.hpp"
#include "tests/apps/gyrotherm/real_rig.hpp"

namespace gyrotherm::app {
namespace {

namespace fs = std::filesystem;

std::string tcp(const std::string& port) { return "tcp://127.0.0.1:" + port; }

/// Returns the words of `new rig FILE` for instruments that do not exist, except `extra`.
std::string command(const std::string& file, const std::string& extra, const std::string& chamber = "watlow_f4t") {
  return "new rig '" + file + "' --chamber " + chamber + " --lowest -40 --highest 60 --fastest 5 --latitude 45 --yes " +
         extra;
}

const std::string kNowhere =
    "--chamber-line tcp://127.0.0.1:9 --thermometer 'lakeshore_218 tcp://127.0.0.1:9 8' --gyro pulse-count "
    "--arcsec-per-pulse 0.1 --gyro-line tcp://127.0.0.1:9 ";

TEST(NewRig, NeverOverwrites) {
  const Folder folder;
  std::ofstream(folder / "rig.toml") << "mine";
  const auto ran = gyrotherm_with(command(folder / "rig.toml", kNowhere));
  EXPECT_EQ(ran.exit_code, 2);
  EXPECT_NE(ran.err.find("never overwritten"), std::string::npos) << ran.err;
  EXPECT_EQ(read_text_file(folder / "rig.toml").value(), "mine");
  std::ofstream(folder / "own-chamber.toml") << "mine";
  const auto other = gyrotherm_with(command(folder / "own.toml", kNowhere, "other-text"));
  EXPECT_EQ(other.exit_code, 2) << other.err;
  EXPECT_FALSE(fs::exists(folder / "own.toml"));
  EXPECT_EQ(read_text_file(folder / "own-chamber.toml").value(), "mine");
  EXPECT_EQ(gyrotherm_with(command(folder / "no/rig.toml", kNowhere)).exit_code, 2);
}

TEST(NewRig, CopiesEveryShippedRig) {
  const Folder folder;
  for (const auto& entry : fs::directory_iterator(GYROTHERM_SOURCE_DIR "/profiles/rigs")) {
    if (entry.path().extension() != ".toml") continue;
    const std::string rig = entry.path().stem().string(), file = folder / (rig + "-copy.toml");
    const auto made = gyrotherm_with("new rig '" + file + "' --like " + rig);
    ASSERT_EQ(made.exit_code, 0) << rig << made.err;
    const std::string text = read_text_file(file).value();
    EXPECT_NE(text.find("\nname = \"" + rig + "-copy\"\n"), std::string::npos) << rig;
    EXPECT_EQ(text.find("\"../"), std::string::npos) << rig;
    EXPECT_EQ(gyrotherm_with("check --rig '" + file + "'").exit_code, gyrotherm_with("check --rig " + rig).exit_code)
        << rig;
  }
}

TEST(NewRig, CopiesRigOfUserWithPathsThatStillLead) {
  const Folder folder;
  fs::create_directory(folder / "a");
  fs::create_directory(folder / "b");
  ASSERT_EQ(gyrotherm_with("new rig '" + (folder / "a/one.toml") + "' --like virtual").exit_code, 0);
  fs::copy_file(GYROTHERM_SOURCE_DIR "/profiles/chambers/virtual.toml", folder / "a/oven.toml");
  std::string text = read_text_file(folder / "a/one.toml").value();
  text.replace(text.find("map = \"virtual\""), 15, "map = \"oven.toml\" # own");
  std::ofstream(folder / "a/one.toml") << text
                                       << "\n[check_standard]\nserial_numbers = [\"1\"]\nhistory = \"h.jsonl\"\n";
  const auto made =
      gyrotherm_with("new rig '" + (folder / "b/two.toml") + "' --like '" + (folder / "a/one.toml") + "'");
  ASSERT_EQ(made.exit_code, 0) << made.err;
  const std::string copy = read_text_file(folder / "b/two.toml").value();
  EXPECT_NE(copy.find("/a/oven.toml\"\n"), std::string::npos) << copy;
  EXPECT_NE(copy.find("history = \"h.jsonl\""), std::string::npos) << "a history of its own";
  EXPECT_EQ(gyrotherm_with("check --rig '" + (folder / "b/two.toml") + "'").exit_code, 0);
}

TEST(NewRig, RefusesToCopyUnknownOrInvalidRigOrWithAnswers) {
  const Folder folder;
  std::ofstream(folder / "bad.toml") << "schema = 1\n";
  for (const std::string& like :
       {std::string("virtuel"), "'" + (folder / "bad.toml") + "'", std::string("virtual --lowest -40")}) {
    EXPECT_NE(gyrotherm_with("new rig '" + (folder / "x.toml") + "' --like " + like).exit_code, 0) << like;
    EXPECT_FALSE(fs::exists(folder / "x.toml")) << like;
  }
}

TEST(NewRig, NamesMissingOptionsWithoutTerminal) {
  const Folder folder;
  const auto ran = gyrotherm_with("new rig '" + (folder / "rig.toml") + "' --chamber watlow_f4t", "watlow_f4t\n");
  EXPECT_EQ(ran.exit_code, 2);
  EXPECT_EQ(ran.err.find("gyrotherm: --chamber-line, --lowest, --highest, --fastest, --thermometer, --gyro, "
                         "--gyro-line, --latitude: missing"),
            0u)
      << ran.err;
  EXPECT_FALSE(fs::exists(folder / "rig.toml"));
}

TEST(NewRig, WritesFileThoughInstrumentsAreSilent) {
  const Folder folder;
  const auto ran = gyrotherm_with(command(folder / "rig.toml", kNowhere + "--json"));
  ASSERT_EQ(ran.exit_code, 0) << ran.err;
  const auto instruments = nlohmann::json::parse(ran.out).at("instruments");
  ASSERT_EQ(instruments.size(), 3u);
  for (const auto& one : instruments) {
    EXPECT_FALSE(one.at("answers"));
    EXPECT_TRUE(one.at("text").get<std::string>().starts_with("NO ANSWER")) << one;
  }
  EXPECT_NE(read_text_file(folder / "rig.toml").value().find("# Probe: NO ANSWER"), std::string::npos);
  EXPECT_EQ(gyrotherm_with("check --rig '" + (folder / "rig.toml") + "'").exit_code, 0);
  const auto quiet = gyrotherm_with(command(folder / "quiet.toml", kNowhere + "--no-probe"));
  EXPECT_EQ(quiet.exit_code, 0);
  EXPECT_EQ(read_text_file(folder / "quiet.toml").value().find("Probe"), std::string::npos);
}

TEST(NewRig, ListsWhatIsToBeFilledInOfOtherChamber) {
  const Folder folder;
  for (const std::string kind : {"other-modbus", "other-text"}) {
    const auto file = folder / (kind + ".toml");
    const auto ran = gyrotherm_with(command(file, kNowhere, kind));
    ASSERT_EQ(ran.exit_code, 0) << ran.err;
    EXPECT_NE(ran.out.find("still to be filled in: the model of the controller"), std::string::npos) << ran.out;
    EXPECT_NE(ran.out.find("docs/adding-an-instrument.md"), std::string::npos);
    const auto check = gyrotherm_with("check --rig '" + file + "'");
    EXPECT_EQ(check.exit_code, 4);
    EXPECT_NE(check.err.find("-chamber.toml:"), std::string::npos) << check.err;
    EXPECT_NE(check.err.find("air temperature"), std::string::npos) << check.err;
  }
}

TEST(NewRig, AsksAtTerminalAndLeavesNothingWhenItEnds) {
  const Folder folder;
  const auto file = folder / "rig.toml";
  const auto ended = run_on_terminal({"new", "rig", file}, "watlow_f4t\nf4t\n\x04");
  EXPECT_EQ(ended.exit_code, 2) << ended.out;
  EXPECT_NE(ended.out.find("host names are not resolved"), std::string::npos) << ended.out;
  EXPECT_NE(ended.out.find("--chamber-line: the input ended"), std::string::npos) << ended.out;
  const auto interrupted = run_on_terminal({"new", "rig", file}, "watlow_f4t\n", "Line of the chamber: ");
  EXPECT_NE(interrupted.exit_code, 0);
  EXPECT_TRUE(fs::is_empty(fs::path(file).parent_path()));
  const auto written = run_on_terminal({"new", "rig", file, "--no-probe"},
                                       "watlow_f4t\ntcp://10.0.0.5\n\n-40\n60\n5\n\n\n\nlakeshore_218\ntcp://"
                                       "10.0.0.6\n\nnone\nstim300\ntcp://10.0.0.7\n\n"
                                       "47,4\n47.4\n\n\n\n\n");
  EXPECT_EQ(written.exit_code, 0) << written.out;
  EXPECT_NE(written.out.find("decimal comma"), std::string::npos) << written.out;
  EXPECT_EQ(gyrotherm_with("check --rig '" + file + "'").exit_code, 0);
}

/// Virtual instruments of a rig in a process of their own.
class Instruments {
 public:
  Instruments(const Folder& folder, const std::string& rig)
      : simulate_({"simulate", "--pace", "real", "--rig", rig}, folder / "log") {
    serves_ = simulate_.wait_for("gyro  ", 60);
    output_ = simulate_.output();
  }
  [[nodiscard]] bool serve() const { return serves_; }
  [[nodiscard]] std::string line(const std::string& instrument) const { return tcp(find_port(instrument, output_)); }
  [[nodiscard]] const std::string& output() const { return output_; }

 private:
  Background simulate_;
  bool serves_ = false;
  std::string output_;
};

void expect_accepted(const Folder& folder, const std::string& extra, const std::string& chamber) {
  const auto ran = gyrotherm_with(command(folder / "rig.toml", extra, chamber));
  ASSERT_EQ(ran.exit_code, 0) << ran.err;
  EXPECT_EQ(ran.out.find("NO ANSWER"), std::string::npos) << ran.out;
  const auto check = gyrotherm_with("check --connect --rig '" + (folder / "rig.toml") + "'");
  EXPECT_EQ(check.exit_code, 0) << check.err << check.out;
  EXPECT_EQ(check.out.find("FAULT"), std::string::npos) << check.out;
}

TEST(NewRigProbe, WritesRigThatCheckAcceptsForVirtualRig) {
  const Folder folder;
  const Instruments virtual_rig(folder, "virtual");
  ASSERT_TRUE(virtual_rig.serve()) << virtual_rig.output();
  expect_accepted(folder,
                  "--chamber-line " + virtual_rig.line("chamber") + " --thermometer 'lakeshore_218 " +
                      virtual_rig.line("thermometer 1") + " 8' --thermometer 'lakeshore_218 " +
                      virtual_rig.line("thermometer 2") +
                      " shell' --gyro pulse-count --arcsec-per-pulse 0.1 --gyro-line " + virtual_rig.line("gyro"),
                  "virtual");
  const auto text = read_text_file(folder / "rig.toml").value();
  EXPECT_NE(text.find("# Probe: gyrotherm virtual chamber"), std::string::npos);
  EXPECT_EQ(text.find("word_order ="), std::string::npos);
}

TEST(NewRigProbe, WritesRigThatCheckAcceptsForInstrumentsOfExample) {
  const Folder folder;
  // The virtual gyro sends one frame a second, which its own stream permits.
  const auto made = shell(
      "sed 's/^stream = .*/stream = \"pulse-count\"\\narcsec_per_pulse = 0.1/' "
      "profiles/rigs/example-f4t-lakeshore-kvh.toml > " +
      (folder / "example.toml"));
  ASSERT_EQ(made.exit_code, 0) << made.err;
  const Instruments example(folder, folder / "example.toml");
  ASSERT_TRUE(example.serve()) << example.output();
  expect_accepted(folder,
                  "--chamber-line " + example.line("chamber") + " --thermometer 'lakeshore_218 " +
                      example.line("thermometer 1") + " 8' --thermometer 'pt12 " + example.line("thermometer 2") +
                      " shell' --gyro pulse-count --arcsec-per-pulse 0.1 --gyro-line " + example.line("gyro"),
                  "watlow_f4t");
}

TEST(NewRigProbe, FindsWordOrder) {
  const Folder folder;
  const auto made = shell(
      "sed 's#\\.\\./#'$PWD'/profiles/#; s/^line = \"virtual\" .*/&\\nword_order = \"dcba\"/' "
      "profiles/rigs/virtual.toml | sed '0,/word_order/!{/^word_order/d}' > " +
      (folder / "swapped.toml"));
  ASSERT_EQ(made.exit_code, 0) << made.err;
  const Instruments swapped(folder, folder / "swapped.toml");
  ASSERT_TRUE(swapped.serve()) << swapped.output();
  expect_accepted(folder,
                  "--chamber-line " + swapped.line("chamber") + " --thermometer 'lakeshore_218 " +
                      swapped.line("thermometer 1") + " 8' --gyro pulse-count --arcsec-per-pulse 0.1 --gyro-line " +
                      swapped.line("gyro"),
                  "virtual");
  EXPECT_NE(read_text_file(folder / "rig.toml").value().find("\nword_order = \"dcba\""), std::string::npos);
}

TEST(NewRigProbe, SendsNoCommand) {
  const Folder folder;
  const Listener gyro;  // line of a stream with a start command
  const auto log = folder / "scanner.log";
  const auto ran =
      shell("python3 tests/apps/gyrotherm/line_peer.py '" + log + "' 'HEWLETT-PACKARD,34970A,0,13-2-2' > '" +
            (folder / "port") + "' 2>&1 & peer=$!\n" + "for i in $(seq 100); do [ -s '" + (folder / "port") +
            "' ] && break; sleep 0.1; done\n" + "gyrotherm " +
            command(folder / "rig.toml", "--chamber-line tcp://127.0.0.1:9 --gyro kvh-dsp-3000-ascii --gyro-line " +
                                             tcp(std::to_string(gyro.port())) +
                                             " --thermometer \"keysight_34970a tcp://127.0.0.1:$(cat '" +
                                             (folder / "port") + "') 8\"") +
            "\nrc=$?; kill $peer; exit $rc");
  EXPECT_EQ(ran.exit_code, 0) << ran.err;
  EXPECT_NE(ran.out.find("34970A"), std::string::npos) << ran.out;
  EXPECT_NE(ran.out.find("start command, which the probe does not send"), std::string::npos) << ran.out;
  EXPECT_EQ(gyro.bytes_of_first_client(), 0);
  const auto sent = read_text_file(log).value();
  EXPECT_EQ(sent, "*IDN?\n");
}

}  // namespace
}  // namespace gyrotherm::app
