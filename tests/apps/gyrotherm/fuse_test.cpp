// SPDX-License-Identifier: Apache-2.0
/// Four skewed axes on the virtual rig, trained and fused with the commands.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "tests/apps/gyrotherm/program.hpp"

namespace gyrotherm::app {
namespace {

std::string whole(const std::string& path) {
  std::ostringstream text;
  text << std::ifstream(path).rdbuf();
  return text.str();
}

/// Recorded and trained once for all tests.
class Fuse : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder() = std::make_unique<Folder>();
    const Folder& in = *folder();
    const std::string rig = " --rig profiles/rigs/virtual-tetrad.toml --seed 3 --out ";
    for (const auto& [profile, name] : {std::pair{"short-rate", "ramp.db"}, std::pair{"short-random", "random.db"}}) {
      const auto ran = gyrotherm_with("run tests/profiles/" + std::string(profile) + ".toml" + rig + (in / name));
      ASSERT_EQ(ran.exit_code, 0) << ran.err;
    }
    for (const std::string axis : {"a", "b", "c", "d"}) {
      std::filesystem::create_directories(in / ("tetrad/" + axis));
      const auto trained =
          gyrotherm_with("train " + (in / "ramp.db") + " --unit tetrad --axis " + axis +
                         " --method ridge-u --quick --out " + (in / ("tetrad/" + axis + "/model-multi-point-t.json")));
      ASSERT_EQ(trained.exit_code, 0) << trained.err;
    }
  }
  static void TearDownTestSuite() { folder().reset(); }

  [[nodiscard]] static Ran fuse(const std::string& options) {
    return gyrotherm_with("fuse " + in("random.db") + " " + options);
  }
  [[nodiscard]] static std::string models() { return "--models " + in("."); }
  [[nodiscard]] static std::string in(const std::string& name) { return *folder() / name; }

 private:
  static std::unique_ptr<Folder>& folder() {
    static std::unique_ptr<Folder> one;
    return one;
  }
};

TEST_F(Fuse, PrintsLinePerRecordAsJson) {
  const auto ran = gyrotherm_with("fuse " + in("random.db") + " " + in("ramp.db") + " " + models() + " --json");
  ASSERT_EQ(ran.exit_code, 0) << ran.err;
  std::istringstream lines(ran.out);
  std::vector<std::string> profiles;
  for (std::string line; std::getline(lines, line);) profiles.push_back(nlohmann::json::parse(line)["profile"]);
  EXPECT_EQ(profiles, (std::vector<std::string>{"short-random", "short-rate"}));
}

TEST_F(Fuse, FindsEarthRateAndNorth) {
  const auto ran = fuse(models() + " --json");
  ASSERT_EQ(ran.exit_code, 0) << ran.err;
  const auto summary = nlohmann::json::parse(ran.out);
  EXPECT_EQ(summary["schema"], "gyrotherm-fusion/1");
  EXPECT_TRUE(summary["simulated"]);
  EXPECT_TRUE(summary["thermometers_vote"]) << "ramp.db is next to the models";
  EXPECT_EQ(summary["axes"].size(), 4u);
  EXPECT_EQ(summary["fused"].get<int>() + 99, summary["seconds"].get<int>()) << "the first mean is of 100 s";
  EXPECT_NEAR(summary["said_heading_deg"].get<double>(), 30, 1e-9);
  const auto& rest = summary["rest"];
  // Earth rate on the axes of virtual-triad.toml, in the same orientation.
  const std::vector<double> earth{9.210735, 5.317820, 10.635640};
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_NEAR(summary["earth_deg_per_h"][k].get<double>(), earth[k], 1e-5);
    EXPECT_NEAR(rest["rate"]["deg_per_h"][k].get<double>(), earth[k], 2 * rest["rate"]["U_deg_per_h"][k].get<double>());
  }
  EXPECT_NEAR(rest["heading_deg"].get<double>(), 30, 2 * rest["heading_U_deg"].get<double>());
  EXPECT_LT(summary["error"]["rms_deg_per_h"].get<double>(), 0.02);
}

TEST_F(Fuse, WritesLinePerSecond) {
  const auto ran = fuse(models() + " --out " + in("fused.csv"));
  ASSERT_EQ(ran.exit_code, 0) << ran.err;
  EXPECT_NE(ran.out.find("SIMULATED"), std::string::npos);
  EXPECT_NE(ran.out.find("heading of x"), std::string::npos) << ran.out;
  EXPECT_NE(ran.out.find("χ² of readings and priors"), std::string::npos) << ran.out;
  std::istringstream table(whole(in("fused.csv")));
  std::vector<std::string> lines;
  for (std::string line; std::getline(table, line);) lines.push_back(line);
  ASSERT_GT(lines.size(), 1000u);
  EXPECT_EQ(lines[0], "# SIMULATED");
  EXPECT_TRUE(lines[1].starts_with("time_s,rate_x_deg_per_h,"));
  EXPECT_EQ(lines[2], "0,,,,,,,,0,tetrad.a+tetrad.b+tetrad.c+tetrad.d");
  EXPECT_EQ(std::ranges::count(lines[900], ','), 9);
  EXPECT_EQ(lines[900].find(",,"), std::string::npos) << lines[900];
  const auto piped = fuse(models() + " --out -");
  EXPECT_EQ(piped.out, whole(in("fused.csv"))) << "the same on standard output, and the summary elsewhere";
}

TEST_F(Fuse, WritesSelfContainedPage) {
  const auto ran = fuse(models() + " --report " + in("page"));
  ASSERT_EQ(ran.exit_code, 0) << ran.err;
  const std::string html = whole(in("page/fusion.html"));
  for (const char* part : {"SIMULATED", "id=\"fused-rate\"", "id=\"parity\"", "id=\"axes\"", "At rest"})
    EXPECT_NE(html.find(part), std::string::npos) << part;
  EXPECT_EQ(html.find("<script"), std::string::npos);
  EXPECT_EQ(html.find("<link"), std::string::npos);
  EXPECT_EQ(nlohmann::json::parse(whole(in("page/fusion.json")))["schema"], "gyrotherm-fusion/1");
  const auto again = fuse(models() + " --report " + in("page"));
  EXPECT_EQ(again.exit_code, 2);
  EXPECT_NE(again.err.find("fusion.html: exists; --force"), std::string::npos) << again.err;
}

TEST_F(Fuse, HasNoParityWithThreeAxes) {
  const auto ran = fuse(models() + " --axes tetrad.a,tetrad.b,tetrad.d");
  ASSERT_EQ(ran.exit_code, 0) << ran.err;
  EXPECT_NE(ran.out.find("parity: not available with three axes"), std::string::npos) << ran.out;
  EXPECT_EQ(fuse(models() + " --axes tetrad.a,tetrad.b").exit_code, 2);
  const auto unknown = fuse(models() + " --axes tetrad.e");
  EXPECT_EQ(unknown.exit_code, 2);
  EXPECT_NE(unknown.err.find("its axes are tetrad.a, tetrad.b"), std::string::npos) << unknown.err;
}

TEST_F(Fuse, TakesModelsByAxisName) {
  const std::string model = in("tetrad/a/model-multi-point-t.json");
  const auto ran = fuse(models() + " --inputs none --model tetrad.a=" + model);
  EXPECT_EQ(ran.exit_code, 4) << "the others do not exist under that name";
  EXPECT_NE(ran.err.find("tetrad/b/model-none.json"), std::string::npos) << ran.err;
  std::string all;
  for (const std::string axis : {"a", "b", "c", "d"})
    all += " --model tetrad." + axis + "=" + in("tetrad/" + axis + "/model-multi-point-t.json");
  const auto named = fuse(all + " --healthy " + in("ramp.db"));
  EXPECT_EQ(named.exit_code, 0) << named.err;
  EXPECT_EQ(fuse("--model tetrad.a").exit_code, 2);
  const auto nobody = fuse(models() + " --model tetrad.e=" + model);
  EXPECT_EQ(nobody.exit_code, 2) << nobody.out;
  EXPECT_NE(nobody.err.find("\"tetrad.e\" is not one of the axes"), std::string::npos) << nobody.err;
  const auto twice = fuse(models() + " --model tetrad.a=" + model + " --model tetrad.a=" + model);
  EXPECT_EQ(twice.exit_code, 2) << twice.out;
  EXPECT_NE(twice.err.find("tetrad.a has two models"), std::string::npos) << twice.err;
  EXPECT_EQ(fuse("").exit_code, 2) << "no models";
}

TEST_F(Fuse, RefusesModelOfAnotherAxis) {
  const std::string of_b = in("tetrad/b/model-multi-point-t.json");
  const auto swapped = fuse(models() + " --model tetrad.a=" + of_b);
  EXPECT_EQ(swapped.exit_code, 2);
  EXPECT_NE(swapped.err.find("another axis: it was trained on tetrad.b"), std::string::npos) << swapped.err;
  const std::string axis_a = " --unit tetrad --axis a";
  const auto verified = gyrotherm_with("verify " + of_b + " " + in("random.db") + axis_a);
  EXPECT_EQ(verified.exit_code, 0) << verified.err;
  EXPECT_NE(verified.out.find("another axis: it was trained on tetrad.b, this is tetrad.a"), std::string::npos);
  const auto compensated =
      shell("gyrotherm export " + in("random.db") + " --out " + in("rows.csv") + " --force && head -n 40 " +
            in("rows.csv") + " | gyrotherm compensate " + of_b + axis_a);
  EXPECT_NE(compensated.err.find("another axis: it was trained on tetrad.b, this is tetrad.a"), std::string::npos);
}

TEST_F(Fuse, WarnsWhenModelIsOfAnotherGyro) {
  const std::string other = in("other.json");
  const auto made = shell("sed 's/seed 3/seed 4/' " + in("tetrad/a/model-multi-point-t.json") + " > " + other);
  ASSERT_EQ(made.exit_code, 0) << made.err;
  const std::string warning = "tetrad.a: the model belongs to another gyro: it was trained on V-0201, seed 4";
  const std::string options = models() + " --model tetrad.a=" + other;
  const auto said = fuse(options + " --report " + in("other"));
  ASSERT_EQ(said.exit_code, 0) << said.err;
  EXPECT_NE(said.out.find("warning: " + warning), std::string::npos) << said.out;
  EXPECT_NE(whole(in("other/fusion.html")).find(warning), std::string::npos);
  const auto summary = nlohmann::json::parse(fuse(options + " --json").out);
  ASSERT_EQ(summary["warnings"].size(), 1u);
  EXPECT_TRUE(nlohmann::json::parse(fuse(models() + " --json").out)["warnings"].empty());
}

TEST_F(Fuse, ExportsProgramWithSelfTest) {
  const auto ran = fuse(models() + " --export-c " + in("fixture.c"));
  ASSERT_EQ(ran.exit_code, 0) << ran.err;
  std::ofstream(in("main.c")) << "#include \"fixture.h\"\nint main(void) { return fixture_self_test(); }\n";
  const auto built =
      shell("cd " + in(".") + " && cc -std=c99 -Wall -Werror fixture.c main.c -lm -o fixture && ./fixture");
  EXPECT_EQ(built.exit_code, 0) << built.err;
  EXPECT_EQ(fuse(models() + " --export-c " + in("fixture.txt")).exit_code, 2);
}

}  // namespace
}  // namespace gyrotherm::app
