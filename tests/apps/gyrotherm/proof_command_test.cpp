// SPDX-License-Identifier: Apache-2.0
/// `gyrotherm prove` on a virtual chamber behind Modbus TCP: with and without a person, killed and interrupted.
#include <gtest/gtest.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "core/file.hpp"
#include "tests/apps/gyrotherm/real_rig.hpp"

namespace gyrotherm::app {
namespace {

constexpr const char* kAlso =
    "[safe.also]\nline = \"tcp://127.0.0.1:1\"\ncoil = 3\nafter = \"2 s\"\n\n[prove]\nevery = \"180 days\"\n"
    "limiter_hold = \"10 s\"\n\n[policy]\nproof = \"refuse\"\n\n";

class ProofCommand : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!installed("mbpoll")) GTEST_SKIP() << "mbpoll is not installed";
    auto text = read_text_file(GYROTHERM_SOURCE_DIR "/profiles/rigs/virtual.toml").value();
    replace(text, "../chambers/virtual.toml", "../chambers/virtual_limiter.toml");
    text.insert(text.find("[[thermometer]]"), kAlso);
    std::ofstream(folder / "template.toml") << text;
    for (std::string from = "\"../"; text.find(from) != std::string::npos;)
      replace(text, from, "\"" GYROTHERM_SOURCE_DIR "/profiles/");
    std::ofstream(folder / "virtual.toml") << text;
    simulate = std::make_unique<Background>(
        std::vector<std::string>{"simulate", "--rig", folder / "virtual.toml", "--pace", "x40"}, folder / "log");
    ASSERT_TRUE(simulate->wait_for("relay  ", 60)) << simulate->output();
    const auto output = simulate->output();
    port = find_port("chamber", output);
    // The relay's line is the first in the file after the chamber's, and stays as it is.
    const auto made = shell("GYROTHERM_TEST_OBSERVE='0 s' /usr/bin/python3 tests/apps/gyrotherm/real_rig.py " +
                            (folder / "template.toml") + " " + port + " " + find_port("thermometer 1", output) + " " +
                            find_port("thermometer 2", output) + " " + find_port("gyro", output));
    ASSERT_EQ(made.exit_code, 0) << made.err;
    auto real = made.out;
    replace(real, "tcp://127.0.0.1:1\"", "tcp://127.0.0.1:" + find_port("relay", output) + "\"");
    std::ofstream(rig) << real;
  }
  static void replace(std::string& text, const std::string& from, const std::string& to) {
    ASSERT_NE(text.find(from), std::string::npos) << from;
    text.replace(text.find(from), from.size(), to);
  }

  /// Returns registers 103 to 111, as mbpoll prints them.
  std::string registers() const {
    return read("-t 4 -r 103 -c 3") + read("-t 4 -r 108 -c 2") + read("-t 4 -r 111 -c 1");
  }
  std::string read(const std::string& what) const {
    return shell("mbpoll -m tcp -a 1 -0 -1 -q -p " + port + " " + what + " 127.0.0.1").out;
  }
  bool becomes_safe(int tenths = 200) const {
    for (int i = 0; i < tenths; ++i) {
      if (read("-B -t 4:float -r 103 -c 1").find("\t20") != std::string::npos) return true;
      shell("sleep 0.1");
    }
    return false;
  }
  Ran by_hand(const std::string& mode) const {
    return shell("/usr/bin/python3 tests/apps/gyrotherm/limiter_by_hand.py " + mode + " " + port + " " +
                 GYROTHERM_PROGRAM + " prove " + rig + " --only limiter");
  }
  std::string newest_protocol() const {
    std::string newest;
    for (const auto& one : list_folder(folder / "proofs")) newest = std::max(newest, one.string());
    return newest;
  }

  const Folder folder;
  const std::string rig = folder / "rig.toml";
  std::string port;
  std::unique_ptr<Background> simulate;
};

TEST_F(ProofCommand, RefusesLimiterWithoutPerson) {
  const auto ran = gyrotherm_with("prove " + rig);
  EXPECT_EQ(ran.exit_code, 2);
  EXPECT_NE(ran.err.find("--only make-safe,line"), std::string::npos) << ran.err;
  EXPECT_FALSE(std::filesystem::exists(folder / "proofs"));
  const auto run =
      gyrotherm_with("run tests/profiles/ten-minutes-warm.toml --rig " + rig + " --out " + (folder / "r.db"));
  EXPECT_EQ(run.exit_code, 3) << run.err;
  EXPECT_NE(run.err.find("proof test limiter: never passed"), std::string::npos) << run.err;
}

TEST_F(ProofCommand, LeavesChamberAsFoundAndSignsProtocol) {
  const auto before = registers();
  const auto ran = gyrotherm_with("prove " + rig + " --only make-safe,line,relay,interlocks --by Ada");
  EXPECT_EQ(ran.exit_code, 0) << ran.out << ran.err;
  EXPECT_EQ(registers(), before);
  const auto protocol = newest_protocol();
  const auto page = read_text_file(protocol + "/proof.de.html").value_or("");
  EXPECT_NE(page.find("NICHT SIGNIERT"), std::string::npos);
  EXPECT_NE(page.find("<h2>Sicherer Zustand – bestanden</h2>"), std::string::npos);
  EXPECT_EQ(page.find(">make-safe<"), std::string::npos);
  for (const char* english : {"abort after", "hold after", "not tested", "confirmed by the guard", "program drives",
                              "; set point", ", running"})
    EXPECT_EQ(page.find(english), std::string::npos) << english << " in " << page;
  EXPECT_NE(page.find("<td>Programm fährt die Kammer auf</td>"), std::string::npos) << page;
  const auto interlocks = page.find("jede Verriegelung wirkt");
  ASSERT_NE(interlocks, std::string::npos);
  EXPECT_NE(page.find("<td>program</td>", interlocks), std::string::npos) << "an identifier of an interlock";
  const auto check = gyrotherm_with("check --rig " + rig).out;
  EXPECT_NE(check.find("a rehearsal on a virtual chamber"), std::string::npos) << check;
  EXPECT_NE(check.find("proof test make-safe: never passed"), std::string::npos) << check;
  const auto key = folder / "lab.key", certificate = folder / "lab.pem";
  ASSERT_EQ(shell("openssl req -x509 -newkey rsa:2048 -nodes -keyout " + key + " -out " + certificate +
                  " -days 30 -subj /CN=Lab -addext basicConstraints=critical,CA:FALSE "
                  "-addext keyUsage=critical,digitalSignature")
                .exit_code,
            0);
  const auto verify = "report verify " + protocol + " --trusted " + certificate;
  EXPECT_EQ(gyrotherm_with(verify).exit_code, 4) << "unsigned";
  const auto sign = "report sign " + protocol + " --key " + key + " --certificate " + certificate;
  const auto done = gyrotherm_with(sign);
  ASSERT_EQ(done.exit_code, 0) << done.err;
  EXPECT_EQ(gyrotherm_with(verify).exit_code, 0) << gyrotherm_with(verify).err;
  const auto checked = nlohmann::json::parse(gyrotherm_with(verify + " --json").out);
  EXPECT_EQ(checked["report"], protocol + "/proof.json");
  EXPECT_EQ(checked["holds"], true);
  EXPECT_EQ(checked["signer"]["subject"], "CN=Lab");
  EXPECT_EQ(checked["checks"][0]["outcome"], "holds");
  EXPECT_EQ(gyrotherm_with(sign).exit_code, 2) << "signed already";
  std::ofstream(protocol + "/proof.en.html", std::ios::app) << " ";
  EXPECT_EQ(gyrotherm_with(verify).exit_code, 0) << "another page, which no signature covers";
  std::ofstream(protocol + "/proof.json", std::ios::app) << " ";
  EXPECT_EQ(gyrotherm_with(verify).exit_code, 4) << "another protocol";
}

/// The limit of the rig's air leaves no room for the test of the limiter.
TEST_F(ProofCommand, ExitsWithOneIfTestCannotBeCarriedOut) {
  auto text = read_text_file(rig).value();
  replace(text, "limiter_hold = \"10 s\"\n", "limiter_hold = \"10 s\"\nlimiter_at = \"21 °C\"\n");
  std::ofstream(rig) << text;
  const auto ran = by_hand("finish");
  EXPECT_EQ(ran.exit_code, 1) << ran.out;
  EXPECT_NE(ran.out.find("proof test limiter: not tested"), std::string::npos) << ran.out;
  EXPECT_NE(read_text_file(newest_protocol() + "/proof.json").value_or("").find("\"not tested\""), std::string::npos);
}

/// The rig file describes real instruments, but the chamber identifies itself as a virtual one.
TEST_F(ProofCommand, MarksProtocolOfServedChamberAsSimulated) {
  EXPECT_EQ(read_text_file(rig).value_or("").find("simulated"), std::string::npos) << "not in the rig file";
  const auto ran = gyrotherm_with("prove " + rig + " --only relay --by Ada");
  EXPECT_EQ(ran.exit_code, 0) << ran.out << ran.err;
  const auto protocol = newest_protocol();
  EXPECT_NE(read_text_file(protocol + "/proof.json").value_or("").find("\"simulated\": true"), std::string::npos);
  EXPECT_NE(read_text_file(protocol + "/proof.en.html").value_or("").find("SIMULATED"), std::string::npos);
  EXPECT_NE(read_text_file(protocol + "/proof.de.html").value_or("").find("SIMULIERT"), std::string::npos);
}

TEST_F(ProofCommand, LeavesChamberSafeWhenKilledInEachStep) {
  for (const auto& [test, step] : {std::pair("make-safe", "program drives"), std::pair("line", "line cut")}) {
    Background prove({"prove", rig, "--only", test}, folder / (std::string(test) + ".log"));
    ASSERT_TRUE(prove.wait_for(step, 60)) << prove.output();
    prove.signal(SIGKILL);
    EXPECT_TRUE(becomes_safe()) << test << prove.output();
    EXPECT_EQ(prove.wait(), -SIGKILL);
    shell("sleep 3");  // the guard opens the relay if its line is dead
  }
}

TEST_F(ProofCommand, LeavesChamberSafeWhenKilledWhileItHeats) {
  EXPECT_EQ(by_hand("kill").exit_code, 128 + SIGKILL);
  EXPECT_TRUE(becomes_safe());
}

TEST_F(ProofCommand, RestoresChamberAfterCtrlC) {
  const auto before = registers();
  const auto ran = by_hand("interrupt");
  EXPECT_EQ(ran.exit_code, 5) << ran.out;
  EXPECT_NE(ran.out.find("interrupted"), std::string::npos) << ran.out;
  const auto after = registers();
  EXPECT_EQ(after.substr(0, after.find("[108]")), before.substr(0, before.find("[108]"))) << "all but the knob";
}

}  // namespace
}  // namespace gyrotherm::app
