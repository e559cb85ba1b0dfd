// SPDX-License-Identifier: Apache-2.0
/// Compensation of text rows: in bulk, one by one, and malformed.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <sstream>
#include <string>

#include "core/file.hpp"
#include "tests/apps/gyrotherm/small_record.hpp"

namespace gyrotherm::app {
namespace {

std::vector<std::string> split_lines(const std::string& text) {
  std::istringstream stream(text);
  std::vector<std::string> lines;
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

class Compensate : public testing::Test {
 protected:
  void SetUp() override { make_small_model(folder_); }
  [[nodiscard]] Ran compensate(const std::string& rows, const std::string& options = "") const {
    return gyrotherm_with("compensate " + (folder_ / "model.json") + " " + options, rows);
  }
  const Folder folder_;
};

TEST_F(Compensate, PrintsLinePerRow) {
  const auto ran = compensate(small_rows(300));
  ASSERT_EQ(ran.exit_code, 0) << ran.err;
  const auto lines = split_lines(ran.out);
  ASSERT_EQ(lines.size(), 301u);
  EXPECT_EQ(lines[0], "compensated_bias_deg_per_h");
  for (int row = 1; row <= 300; ++row) EXPECT_EQ(lines[row].empty(), row < 100) << "the first mean is of 100 rows";
  EXPECT_NE(ran.err.find("lag by 50 s"), std::string::npos) << ran.err;
}

TEST_F(Compensate, AnswersSingleRowImmediately) {
  std::ofstream(folder_ / "rows") << small_rows(101);
  // The writer keeps its end open and continues only after its rows have been answered. It gives up after a minute.
  const auto ran = shell("cd " + (folder_ / ".") +
                         " && mkfifo in && "
                         "{ gyrotherm compensate $PWD/model.json < $PWD/in > $PWD/out & } && exec 3> in && "
                         "answered() { i=0; until [ $(wc -l < out) -ge $1 ]; do i=$((i+1)); [ $i -lt 600 ] || exit 7; "
                         "sleep 0.1; done; } && head -100 rows >&3 && answered 100 && tail -2 rows | head -1 >&3 && "
                         "answered 101 && tail -1 rows >&3 && answered 102 && exec 3>&- && wait");
  EXPECT_EQ(ran.exit_code, 0) << "7: a row was not answered while the input was open\n" << ran.err;
}

TEST_F(Compensate, EndsWhenOutputIsClosed) {
  std::ofstream(folder_ / "rows") << small_rows(200);
  // The writer would continue for 15 s; it prints how many rows it wrote.
  const std::string rows = "cd " + (folder_ / ".") +
                           " && { cat rows; row=$(tail -1 rows); i=0; while [ $i -lt 300 ] && echo \"$row\" "
                           "2> /dev/null; do i=$((i+1)); sleep 0.05; done; echo $i rows >&2; } | ";
  const auto left = shell(rows + "gyrotherm compensate $PWD/model.json | head -1");
  EXPECT_EQ(left.out, "compensated_bias_deg_per_h\n");
  EXPECT_EQ(left.err.find("300 rows"), std::string::npos) << left.err;
  const auto full = shell(rows + "gyrotherm compensate $PWD/model.json > /dev/full");
  EXPECT_EQ(full.exit_code, 4);
  EXPECT_EQ(full.err.find("300 rows"), std::string::npos) << full.err;
  EXPECT_NE(full.err.find("stdout: cannot be written"), std::string::npos) << full.err;
}

TEST_F(Compensate, RefusesUnitOfTableWithOneBias) {
  for (const char* option : {"--unit", "--axis"}) {
    const auto refused = shell("gyrotherm compensate " + (folder_ / "model.json") + " " + option + " x", small_rows(3));
    EXPECT_EQ(refused.exit_code, 2) << refused.out;
    EXPECT_NE(refused.err.find(std::string(option) + ": not valid"), std::string::npos) << refused.err;
  }
}

TEST_F(Compensate, AnswersIndependentlyOfInputPieces) {
  const auto bulk = compensate(small_rows(700));
  const auto single =
      shell("while IFS= read -r row; do echo \"$row\"; done | gyrotherm compensate " + (folder_ / "model.json"),
            small_rows(700));
  EXPECT_EQ(bulk.out, single.out);
}

TEST_F(Compensate, DistinguishesThermometerAndGyroOfSameName) {
  const auto rows = split_lines(small_rows(300));
  std::string exported = "# axis gyro: scale 1, earth rate 0\nslot,gyro [°C],B [°C],gyro [1 °/h]\n";
  for (int row = 1; row <= 300; ++row) exported += fmt::format("{},{}\n", row - 1, rows[row]);
  const auto renamed =
      shell("sed 's/\\bA\\b/gyro/g; s/\"type\": *\"gyro/\"type\": \"A/' " + (folder_ / "model.json") + " > " +
                (folder_ / "gyro.json") + " && gyrotherm compensate " + (folder_ / "gyro.json"),
            exported);
  EXPECT_EQ(renamed.exit_code, 0) << renamed.err;
  EXPECT_EQ(renamed.out, compensate(small_rows(300)).out);
}

/// Returns rows in the format of `export`, with these slots.
std::string exported_rows(const std::vector<int>& slots) {
  const auto rows = split_lines(small_rows(static_cast<int>(slots.size())));
  std::string text = "# axis gyro: scale 1, earth rate 0\nslot,A [°C],B [°C],gyro [1 °/h]\n";
  for (std::size_t row = 0; row < slots.size(); ++row) text += fmt::format("{},{}\n", slots[row], rows[row + 1]);
  return text;
}

TEST_F(Compensate, AppliesSignOfEarthRateToTurnedRows) {
  const auto rows = split_lines(small_rows(300));
  std::string text = "# axis gyro: scale 1, earth rate 10\nslot,A [°C],B [°C],gyro [1 °/h],turned\n";
  for (int row = 1; row <= 300; ++row) {
    const auto comma = rows[row].rfind(',');
    const char* turned = row <= 150 ? "0" : row <= 200 ? "" : "1";
    const double rate = std::stod(rows[row].substr(comma + 1)) + (row <= 200 ? 10 : -10);
    text += fmt::format("{},{},{},{}\n", row - 1, rows[row].substr(0, comma), rate, turned);
  }
  const auto known = split_lines(compensate(small_rows(300)).out), found = split_lines(compensate(text).out);
  ASSERT_EQ(found.size(), 301u);
  for (std::size_t row = 100; row <= 300; ++row)
    if (row > 150 && row <= 200)
      EXPECT_EQ(found[row], "") << "while an operator handles the unit";
    else
      EXPECT_NEAR(std::stod(found[row]), std::stod(known[row]), 2e-7) << row;
}

TEST_F(Compensate, PrintsNoValueAfterGapUntilMeanIsComplete) {
  std::vector<int> slots(400), with_gap(400);
  for (int row = 0; row < 400; ++row) {
    slots[row] = 60 + row;
    with_gap[row] = row < 150 ? row : row + 3000;
  }
  const auto whole = compensate(exported_rows(slots)), ran = compensate(exported_rows(with_gap));
  ASSERT_EQ(ran.exit_code, 0) << ran.err;
  EXPECT_EQ(whole.out, compensate(small_rows(400)).out) << "the rows may begin after the start of the run";
  EXPECT_EQ(whole.err.find("missing"), std::string::npos) << whole.err;
  const auto lines = split_lines(ran.out);
  ASSERT_EQ(lines.size(), 401u);
  for (std::size_t row = 1; row <= 400; ++row)
    EXPECT_EQ(lines[row].empty(), row < 100 || (row > 150 && row < 250)) << row;
  EXPECT_NE(ran.err.find("3000 seconds are missing"), std::string::npos) << ran.err;
}

TEST_F(Compensate, RefusesAveragedRows) {
  for (const int step : {2, 10, 60}) {
    std::vector<int> slots(200);
    for (int row = 0; row < 200; ++row) slots[row] = row * step;
    const auto ran = compensate(exported_rows(slots));
    EXPECT_EQ(ran.exit_code, 4) << ran.out;
    EXPECT_NE(ran.err.find(fmt::format("these rows are {} s apart; export the record without --every", step)),
              std::string::npos)
        << ran.err;
  }
}

TEST_F(Compensate, AcceptsRecordWithManyGaps) {
  std::vector<int> slots(400);
  for (int row = 0; row < 400; ++row) slots[row] = row + 10 * (row / 3);
  const auto ran = compensate(exported_rows(slots));
  EXPECT_EQ(ran.exit_code, 0) << ran.err;
}

TEST_F(Compensate, RefusesSlotOutOfOrderWithPosition) {
  std::vector<int> slots(120);
  for (int row = 0; row < 120; ++row) slots[row] = row;
  for (const int wrong : {109, 108, 0, -1, 2'000'000'000}) {
    slots[110] = wrong;
    const auto ran = compensate(exported_rows(slots));
    EXPECT_EQ(ran.exit_code, 4) << wrong;
    EXPECT_NE(ran.err.find(fmt::format("stdin:113:1: slot {}, expected a whole number from 110 to", wrong)),
              std::string::npos)
        << ran.err;
    EXPECT_EQ(split_lines(ran.out).size(), 111u) << "the rows before it are answered";
  }
  const auto ran = compensate("# axis gyro: scale 1, earth rate 0\nslot,A [°C],B [°C],gyro [1 °/h]\n,20,20,1\n");
  EXPECT_NE(ran.err.find("stdin:3:1: no slot, expected"), std::string::npos) << ran.err;
}

TEST_F(Compensate, RefusesMalformedRowAfterAnsweringEarlierRows) {
  auto rows = small_rows(150) + "20,warm,1\n";
  const auto ran = compensate(rows);
  EXPECT_EQ(ran.exit_code, 4);
  EXPECT_NE(ran.err.find("stdin:152:4: \"warm\", expected a number"), std::string::npos) << ran.err;
  EXPECT_EQ(split_lines(ran.out).size(), 151u);
  EXPECT_EQ(compensate("A,bias\n").exit_code, 2) << "the model needs B";
  EXPECT_EQ(compensate("A,B\n").exit_code, 4);
  EXPECT_EQ(compensate("").exit_code, 4);
  EXPECT_EQ(gyrotherm_with("compensate " + (folder_ / "none.json")).exit_code, 4);
}

TEST_F(Compensate, RefusesImpossibleValueAfterAnsweringEarlierRows) {
  for (const std::string row : {"1e99,20,1\n", "20,-300,1\n", "20,20,-1e12\n"}) {
    const auto ran = compensate(small_rows(150) + row);
    EXPECT_EQ(ran.exit_code, 4) << row;
    EXPECT_NE(ran.err.find("stdin:152:1: "), std::string::npos) << ran.err;
    EXPECT_NE(ran.err.find("which is impossible"), std::string::npos) << ran.err;
    EXPECT_EQ(split_lines(ran.out).size(), 151u) << row;
  }
}

TEST_F(Compensate, RefusesColumnsInOtherUnits) {
  const auto rows = [](const std::string& header) {
    const auto plain = small_rows(101);
    return header + plain.substr(plain.find('\n'));
  };
  const auto as_plain = compensate(rows("A,B,bias"));
  EXPECT_EQ(compensate(rows("A [°C],B [degC],bias [°/h]")).out, as_plain.out);
  for (const auto* header : {"A [K],B [°C],bias", "A [°F],B,bias [°/h]"}) {
    const auto ran = compensate(rows(header));
    EXPECT_EQ(ran.exit_code, 4) << header;
    EXPECT_NE(ran.err.find("expected a temperature in [°C]"), std::string::npos) << ran.err;
    EXPECT_NE(ran.err.find("column 1 is \"A ["), std::string::npos) << ran.err;
  }
  const auto bias = compensate(rows("A [°C],B [°C],bias [°/s]"));
  EXPECT_EQ(bias.exit_code, 4) << bias.out;
  EXPECT_NE(bias.err.find("column 3 is \"bias [°/s]\", expected a bias in [°/h]"), std::string::npos) << bias.err;
}

TEST_F(Compensate, LeavesMeansEmptyWhenReadingIsMissing) {
  const auto lines = split_lines(compensate(small_rows(150) + "20,,1\n" + small_rows(250).substr(9)).out);
  ASSERT_EQ(lines.size(), 402u);
  for (std::size_t row = 100; row <= 401; ++row) EXPECT_EQ(lines[row].empty(), row > 150 && row <= 250) << row;
}

TEST_F(Compensate, PrintsUncertaintyInSecondColumn) {
  const auto plain = compensate(small_rows(300)), with = compensate(small_rows(300), "--uncertainty");
  ASSERT_EQ(with.exit_code, 0) << with.err;
  const auto values = split_lines(plain.out), lines = split_lines(with.out);
  ASSERT_EQ(lines.size(), values.size());
  EXPECT_EQ(lines[0], "compensated_bias_deg_per_h,U_deg_per_h");
  EXPECT_EQ(lines[1], ",") << "no value, no U";
  const auto comma = lines[300].find(',');
  EXPECT_EQ(lines[300].substr(0, comma), values[300]);
  EXPECT_GT(std::stod(lines[300].substr(comma + 1)), 0);
  EXPECT_NE(with.err.find("95 %"), std::string::npos) << with.err;
}

TEST_F(Compensate, WidensUncertaintyOutsideTrainedRange) {
  const auto last_u = [this](double temperature) {
    std::string rows = "A,B,bias\n";
    for (int i = 0; i < 120; ++i) rows += fmt::format("{0},{0},1\n", temperature);
    const auto lines = split_lines(compensate(rows, "--uncertainty").out);
    return lines.size() == 121 ? std::stod(lines[120].substr(lines[120].find(',') + 1)) : 0.0;
  };
  const auto inside = split_lines(compensate(small_rows(300), "--uncertainty").out);
  const double u = std::stod(inside[300].substr(inside[300].find(',') + 1));
  EXPECT_GT(last_u(90), u);
  EXPECT_GT(last_u(120), last_u(90));
}

TEST_F(Compensate, ReportsInputsOutsideTrainedRange) {
  std::string hot = "A,B,bias\n";
  for (int i = 0; i < 120; ++i) hot += "90,90,1\n";
  const auto continued = compensate(hot), refused = compensate(hot, "--outside refuse");
  EXPECT_NE(continued.err.find("21 rows had an input outside"), std::string::npos) << continued.err;
  EXPECT_FALSE(split_lines(continued.out)[120].empty());
  EXPECT_TRUE(split_lines(refused.out)[120].empty());
  EXPECT_EQ(compensate(hot, "--outside guess").exit_code, 2);
}

TEST_F(Compensate, RefusesRecordWithoutRowPerSecond) {
  const auto exported = [&](const std::string& time, const std::string& rows) {
    std::ofstream(folder_ / "rows.csv") << rows;
    const auto map = folder_ / "rows.toml", record = folder_ / "rows.db";
    std::ofstream(map) << small_map(time);
    const auto made = shell("rm -f " + record + "* && gyrotherm import " + (folder_ / "rows.csv") + " --map " + map +
                            " --out " + record);
    EXPECT_EQ(made.exit_code, 0) << made.err;
    return gyrotherm_with("export " + record + " --compensated --model " + (folder_ / "model.json") +
                          " --force --out " + (folder_ / "rows.out"));
  };
  const auto refused = exported("interval = \"100 ms\"", small_rows(300));
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_NE(refused.err.find("0.1 s apart"), std::string::npos) << refused.err;
  EXPECT_NE(refused.err.find("every = \"1 s\""), std::string::npos) << refused.err;
  EXPECT_EQ(exported("interval = \"100 ms\"\nevery = \"1 s\"", small_rows(3000)).exit_code, 0);

  std::string rows = "t,A,B,bias\n";
  const auto plain = split_lines(small_rows(300));
  for (int row = 0; row < 300; ++row) rows += fmt::format("{},{}\n", row < 150 ? row : row + 50, plain[row + 1]);
  ASSERT_EQ(exported("column = \"t\"\nunit = \"s\"", rows).exit_code, 0);
  const auto lines = split_lines(read_text_file(folder_ / "rows.out").value());
  ASSERT_EQ(lines.size(), 302u);
  for (int i = 0; i < 300; ++i)
    EXPECT_EQ(lines[i + 2].find(",,") != std::string::npos, i < 99 || (i >= 150 && i < 249)) << lines[i + 2];
}

/// Record long enough to estimate the noise of its residual.
class CompensateAndTrack : public Compensate {
 protected:
  void SetUp() override {
    Compensate::SetUp();
    std::ofstream(folder_ / "long.csv") << small_rows(kRows);
    const auto imported = gyrotherm_with("import " + (folder_ / "long.csv") + " --map " + (folder_ / "map.toml") +
                                         " --out " + (folder_ / "long.db"));
    ASSERT_EQ(imported.exit_code, 0) << imported.err;
  }
  /// Returns rows of a gyro whose bias is larger by 1 °/h, with a last column at_rest.
  static std::string shifted_rows(const std::string& at_rest) {
    std::string text = "A,B,bias,at_rest\n";
    for (const auto& line : split_lines(small_rows(kRows))) {
      const auto comma = line.rfind(',');
      if (line.front() == 'A') continue;
      text += line.substr(0, comma + 1) + std::to_string(std::stod(line.substr(comma + 1)) + 1) + "," + at_rest + "\n";
    }
    return text;
  }
  /// Returns the mean of the last 1000 answers.
  static double last_mean(const Ran& ran) {
    const auto lines = split_lines(ran.out);
    double sum = 0;
    for (std::size_t i = lines.size() - 1000; i < lines.size(); ++i) sum += std::stod(lines[i]);
    return sum / 1000;
  }
  static constexpr int kRows = 9000;
  [[nodiscard]] std::string options() const { return "--track --noise " + (folder_ / "long.db"); }
};

TEST_F(CompensateAndTrack, RemovesResidualBiasAtRest) {
  const auto resting = compensate(shifted_rows("1"), options()), moving = compensate(shifted_rows("0"), options());
  ASSERT_EQ(resting.exit_code, 0) << resting.err;
  ASSERT_EQ(moving.exit_code, 0) << moving.err;
  EXPECT_NE(resting.err.find("tracking the residual bias, N "), std::string::npos) << resting.err;
  EXPECT_LT(std::abs(last_mean(resting)), 0.2) << "of 1 °/h";
  EXPECT_GT(last_mean(moving), 0.8) << "a possible rotation is not corrected";
  EXPECT_EQ(compensate(shifted_rows(""), options()).out, moving.out) << "an empty field does not mean rest";
}

TEST_F(CompensateAndTrack, RequiresNoiseOfResidual) {
  const auto ran = compensate(small_rows(10), "--track");
  EXPECT_EQ(ran.exit_code, 2) << "its 40 clusters were too few";
  EXPECT_NE(ran.err.find("--noise"), std::string::npos) << ran.err;
  EXPECT_EQ(compensate(small_rows(10), "--noise " + (folder_ / "long.db")).exit_code, 2) << "noise without tracking";
  EXPECT_EQ(compensate(shifted_rows("1"), "").exit_code, 4) << "at_rest is for tracking";
}

}  // namespace
}  // namespace gyrotherm::app
