// SPDX-License-Identifier: Apache-2.0
#include "acquisition/exchange/guess.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "tests/acquisition/exchange/foreign.hpp"

namespace gyrotherm::exchange {
namespace {

/// A draft map and the result of reading its file with it.
struct Guessed {
  std::string text;
  ImportMap map;
  ReadRows rows;
};

Guessed draft_map(std::string_view bytes) {
  const auto text = guess_map_from_bytes(bytes, "folder/file.csv");
  EXPECT_TRUE(text) << gyrotherm::text(text.error());
  auto map = parse_import_map(text.value_or(""), "guess.toml");
  EXPECT_TRUE(map) << gyrotherm::text(map.error()) << *text;
  const auto rows = read_rows(bytes, *map, "f");
  EXPECT_TRUE(rows) << gyrotherm::text(rows.error()) << *text;
  return {text.value(), map.value(), rows.value()};
}

ImportMap draft(std::string_view bytes) { return draft_map(bytes).map; }

/// Returns the line of a map that assigns a key, with its comment.
std::string map_line(const std::string& map, const std::string& key, const std::string& behind = "[time]") {
  const auto at = map.find("\n" + key + " = ", map.find(behind));
  return at == std::string::npos ? "" : map.substr(at + 1, map.find('\n', at + 1) - at - 1);
}

/// Returns a table with rows `step` apart.
std::string counter(const std::string& name, std::int64_t from, std::int64_t step = 4000) {
  std::string table = name + ",temp,gyro_x\n";
  for (int i = 0; i < 20; ++i) table += std::to_string(from + step * i) + ",25,0.01\n";
  return table;
}

TEST(Guess, ReadsSpreadsheetTableWithoutCorrection) {
  const ImportMap map = draft(
      "\xEF\xBB\xBFsep=;\r\nZeit [ms];Gehäuse Temp [°C];Kern T [°C];Gyro X [°/s];Gyro Y [°/s]\r\n"
      "0;20,5;21,5;0,001;0,002\r\n1000;20,6;;0,001;NaN\r\n2000;20,7;21,7;0,001;0,002\r\n");
  EXPECT_EQ(map.separator, ';');
  EXPECT_EQ(map.decimal, ',');
  EXPECT_EQ(map.missing, (std::vector<std::string>{"", "NaN"}));
  EXPECT_EQ(map.time->name, "Zeit [ms]");
  EXPECT_EQ(map.time_unit, std::chrono::milliseconds(1));
  EXPECT_EQ(map.thermometers, (std::vector<std::string>{"Gehaeuse Temp", "Kern T"}));
  ASSERT_EQ(map.units[0].axes.size(), 2u);
  EXPECT_EQ(map.units[0].axes[1].name, "y");
  EXPECT_EQ(map.units[0].axes[1].scale, 3600);
  EXPECT_EQ(map.every, Duration{}) << "a row a second stays one";
}

TEST(Guess, GivesThermometersNoReservedNames) {
  const ImportMap map = draft(
      "slot,time [s],set point [°C],chamber air [°C],A [°C],self temp [°C],gyro [°/h]\n"
      "0,1,20,20.5,21,22,0.1\n1,2,20,20.5,21,22,0.1\n2,3,20,20.5,21,22,0.1\n");
  EXPECT_EQ(map.thermometers, (std::vector<std::string>{"set pointT", "chamber airT", "A", "self temp"}));
}

TEST(Guess, CombinesFastRows) {
  std::string table = "timestamp,temp,gx,gy,gz\n";
  for (int i = 0; i < 100; ++i) table += std::to_string(i * 10) + ",20,1,2,3\n";
  const ImportMap map = draft(table);
  EXPECT_EQ(map.time_unit, std::chrono::milliseconds(1)) << "rows do not come every 10 s";
  EXPECT_EQ(map.units[0].axes.size(), 3u);
}

TEST(Guess, DetectsUnixAndCalendarTimes) {
  EXPECT_EQ(draft("time,T,w\n1772362800000,20,1\n1772362801000,20,1\n").since, CountedTime{});
  const ImportMap map = draft("when\tT\tw\n2026-03-01 12:00:00\t20\t1\n2026-03-01 12:00:01\t20\t1\n");
  EXPECT_EQ(map.time_form, TimeForm::civil);
  EXPECT_EQ(map.zone, Duration{});
  EXPECT_EQ(map.separator, '\t');
}

TEST(Guess, DoesNotTreatMicrosecondCounterAsClock) {
  for (const char* name : {"time_us", "TimeUS", "t [us]", "t (µs)", "Time [ US ]", "us"}) {
    const Guessed guess = draft_map(counter(name, 1'200'000'000));
    EXPECT_EQ(guess.map.time_unit, std::chrono::microseconds(1)) << name;
    EXPECT_EQ(guess.map.since, std::nullopt) << name;
    EXPECT_EQ(guess.rows.time.size(), 1u) << "all in one second: " << name;
    EXPECT_EQ(map_line(guess.text, "unit"), "unit = \"us\"        # from its name");
  }
  const Guessed bare = draft_map(counter("timestamp", 1'200'000'000));
  EXPECT_EQ(bare.map.since, std::nullopt) << "rows would come every hour";
  EXPECT_EQ(map_line(bare.text, "unit"), "unit = \"ms\"        # a guess from the steps of the numbers");
}

TEST(Guess, AcceptsClockOnlyWithUnitInName) {
  const Guessed named = draft_map(counter("time_us", 1'772'362'800'000'000));
  EXPECT_EQ(named.map.since, CountedTime{});
  EXPECT_NE(map_line(named.text, "since").find("# inferred from the size of the numbers"), std::string::npos)
      << named.text;
  const Guessed bare = draft_map(counter("time", 1'772'362'800'000));
  EXPECT_EQ(bare.map.time_unit, std::chrono::milliseconds(1));
  EXPECT_EQ(map_line(bare.text, "unit"), "unit = \"ms\"        # a guess from the size of the numbers");
  EXPECT_EQ(draft(counter("time [s]", 1'772'362'800, 1)).since, CountedTime{});
  EXPECT_EQ(draft(counter("time [UTC]", 1'772'362'800, 300)).since, CountedTime{}) << "a row every five minutes";
  EXPECT_EQ(draft(counter("time [ms]", 1'772'362'800, 1)).since, std::nullopt);
}

TEST(Guess, ReportsUnknownTimeUnit) {
  EXPECT_EQ(map_line(draft_map("t [weeks],T,w\n0,20,1\n0.5,20,1\n1,20,1\n").text, "unit"),
            "unit = \"s\"        # a guess from the steps of the numbers, the unit \"weeks\" is not supported");
}

TEST(Guess, MatchesOnlyWholeRateUnits) {
  const auto scale_of = [](const std::string& name) {
    const Guessed guess = draft_map("t [s],T [°C]," + name + "\n0,20,1\n1,20,1\n");
    const bool is_said = map_line(guess.text, "scale").find("a guess") != std::string::npos;
    return std::pair(guess.map.units[0].axes[0].scale, is_said);
  };
  for (const char* name : {"gyro_x [kdeg/s]", "gyro_x_100_dps", "gyro_x [deg/s/s]", "gyro_x_mrad",
                           "gyro_x [deg/s] [raw]", "gyro_x", "gyro_x [LSB]"})
    EXPECT_EQ(scale_of(name), std::pair(1., true)) << name;
  for (const char* name : {"gyro_x [dps]", "gyro_x [deg/s]", "gyro_x (°/s)", "gyro_x_dps", "gyro_x_deg_per_s",
                           "gyro_x dps", "gyro_x [ deg / s ]", "gyro_1x_dps"})
    EXPECT_EQ(scale_of(name), std::pair(3600., false)) << name;
  for (const char* name : {"gyro_x [rad/s]", "gyro_x_radps", "sensor_combined.gyro_rad[0]"})
    EXPECT_NEAR(scale_of(name).first, 206264.806247, 1e-6) << name;
  EXPECT_EQ(scale_of("gyro_x [°/h]"), std::pair(1., false));
  for (const char* name : {"gyro_x [mdps]", "gyro_x [mdeg/s]", "gyro_x_mdps", "gyro_x [0.001 deg/s]"})
    EXPECT_NEAR(scale_of(name).first, 3.6, 1e-12) << name;
  for (const char* name : {"gyro_x (mrad/s)", "gyro_x [1e-3 rad/s]"})
    EXPECT_NEAR(scale_of(name).first, 206.264806247, 1e-9) << name;
  EXPECT_NEAR(scale_of("gyro_x [µrad/s]").first, 0.206264806247, 1e-12);
  EXPECT_NEAR(scale_of("gyro_x [0.01 deg/s]").first, 36, 1e-12);
  EXPECT_NEAR(scale_of("gyro_x [°/min]").first, 60, 1e-12);
}

TEST(Guess, ConvertsOrReportsOtherTemperatureUnits) {
  const auto lines_of = [](const std::string& name) {
    const auto text = draft_map("t [s]," + name + ",gyro_x\n0,20,1\n1,20,1\n").text;
    const auto from = text.find("[[thermometer]]"), column = text.find("column", from);
    return text.substr(column, text.find("\n\n", column) - column);
  };
  for (const char* name : {"Temp [°C]", "T1 (degC)", "die T [C]", "temp_c", "temp_degC"})
    EXPECT_EQ(lines_of(name), "column = \"" + std::string(name) + "\"");
  EXPECT_EQ(lines_of("Temp [K]"), "column = \"Temp [K]\"\noffset = -273.15        # from K");
  const auto scale_of = [](const std::string& name) {
    const auto column = draft("t [s]," + name + ",gyro_x\n0,20,1\n1,20,1\n").thermometer_columns[0];
    return std::pair(column.scale, column.offset);
  };
  for (const char* name : {"Temp [°F]", "T1 (degF)", "temp_f"}) {
    EXPECT_NEAR(scale_of(name).first, 5.0 / 9, 1e-12) << name;
    EXPECT_NEAR(scale_of(name).second, -160.0 / 9, 1e-12) << name;
  }
  EXPECT_EQ(scale_of("Temp [m°C]"), std::pair(1e-3, 0.));
  EXPECT_EQ(scale_of("Temp [0.01 °C]"), std::pair(1e-2, 0.));
  EXPECT_EQ(scale_of("Temp [mK]"), std::pair(1e-3, -273.15));
  for (const char* unit : {"°R", "raw", "Ohm"})
    EXPECT_EQ(lines_of("Temp [" + std::string(unit) + "]"), "column = \"Temp [" + std::string(unit) +
                                                                "]\"        # a guess, \"" + unit +
                                                                "\" is not known: °C = number × scale + offset");
  for (const char* name : {"temp", "temp_raw", "temp_mC", "T1"})
    EXPECT_EQ(lines_of(name),
              "column = \"" + std::string(name) + "\"        # a guess, taken as °C: °C = number × scale + offset");
}

TEST(Guess, JoinsDateAndTimeOfDay) {
  for (const auto& [table, start_s] :
       {std::pair("Index,Date,Time,T1,gyro_x\n5,2026-03-01,23:59:59,20,1\n6,2026-03-02,00:00:00,20,1\n"
                  "7,2026-03-02,00:00:01,20,1\n8,2026-03-02,00:00:02,20,1\n",
                  1772409599),
        std::pair("Datum;Uhrzeit;T1;gyro_x\n01.03.2026;23:59:59;20;1\n02.03.2026;00:00:00;20;1\n"
                  "02.03.2026;00:00:01;20;1\n02.03.2026;00:00:02;20;1\n",
                  1772409599),
        std::pair("Time\tDate\tT1\tgyro_x\n11:59:59 PM\t2026/03/01\t20\t1\n12:00:00 AM\t2026/03/02\t20\t1\n"
                  "12:00:01 AM\t2026/03/02\t20\t1\n12:00:02 AM\t2026/03/02\t20\t1\n",
                  1772409599)}) {
    const Guessed guess = draft_map(table);
    ASSERT_EQ(guess.rows.time.size(), 4u) << guess.text;
    EXPECT_EQ(guess.rows.time.back(), std::chrono::seconds(3));
    EXPECT_EQ(guess.rows.utc.front(), std::chrono::seconds(start_s)) << guess.text;
  }
}

TEST(Guess, CombinesRowsOfEqualTime) {
  const Guessed guess = draft_map("time,T,w\n5,20,1\n5,20,3\n5,20,5\n6,20,1\n");
  EXPECT_EQ(guess.map.every, std::chrono::seconds(1)) << guess.text;
  EXPECT_EQ(guess.rows.columns[1], (std::vector<double>{3, 1}));
  EXPECT_EQ(draft("when,T,w\n2026-03-01,20,1\n2026-03-02,20,1\n").time_form, TimeForm::civil) << "a row a day";
}

TEST(Guess, AsksWhenTimeColumnIsMissing) {
  for (const char* table : {"T1,gyro_x\n20,1\n21,3\n20,2\n", "when,T1,gyro_x\nnever,20,1\nnever,20,2\nnever,20,1\n",
                            "Date,T1,gyro_x\n2026-03-01,20,1\n2026-03-01,20,3\n2026-03-01,20,2\n"}) {
    const auto map = guess_map_from_bytes(table, "f").value();
    EXPECT_FALSE(parse_import_map(map, "f")) << map;
    EXPECT_EQ(map.find("\ninterval"), std::string::npos) << map;
  }
}

TEST(Guess, NamesTimeInUnknownNotation) {
  for (const char* time : {"2026-060 08:00:0", "1.3.26 8h0m", "Sun 08:00:0"}) {
    std::string table = "Logged,T1,gyro_x\n";
    for (int i = 0; i < 5; ++i) table += time + std::to_string(i) + ",20,1\n";
    const auto map = guess_map_from_bytes(table, "f").value();
    EXPECT_NE(map.find("\"Logged\" looks like a time"), std::string::npos) << map;
    EXPECT_FALSE(parse_import_map(map, "f")) << map;
  }
}

TEST(Guess, ShowsBothNotationsOfDate) {
  for (const char* format : {"03/04/2026 08:00:0", "3/4/2026 8:00:0", "03-04-2026 08:00:0"}) {
    std::string table = "Date,T1,gyro_x\n";
    for (int i = 0; i < 5; ++i) table += format + std::to_string(i) + ",20,1\n";
    const auto map = guess_map_from_bytes(table, "f").value();
    EXPECT_NE(map.find("2026-04-03; which line"), std::string::npos) << map;
    EXPECT_NE(map.find("2026-03-04; which line"), std::string::npos) << map;
    EXPECT_FALSE(parse_import_map(map, "f")) << map;
  }
  EXPECT_EQ(draft("Date,T1,w\n12/03/2026 23:59:59,20,1\n13/03/2026 00:00:00,20,1\n").date_order, DateOrder::day_first);
  EXPECT_EQ(
      draft("Date,T1,w\n03/08/2026 23:59:58,20,1\n03/08/2026 23:59:59,20,1\n03/09/2026 00:00:00,20,1\n").date_order,
      DateOrder::month_first)
      << "the other order would put a month between two rows";
}

TEST(Guess, DetectsUnitsAndSerialDates) {
  const auto unit_of = [](const std::string& title, double first, double step, int digits) {
    std::string table = title + ";T1 [°C];Gyro [°/h]\n";
    for (int i = 0; i < 20; ++i) table += fmt::format("{:.{}f};20;1\n", first + step * i, digits);
    const Guessed guess = draft_map(table);
    EXPECT_EQ(guess.rows.time.size(), 20u) << guess.text;
    return std::pair(std::llround(to_seconds(guess.rows.time.back())),
                     guess.rows.utc.front() ? std::llround(to_seconds(*guess.rows.utc.front())) : -1LL);
  };
  constexpr long long kUnknown = -1;
  EXPECT_EQ(unit_of("Time [min]", 0, 1.0 / 6, 5), std::pair(190LL, kUnknown));
  EXPECT_EQ(unit_of("t (hours)", 3, 0.5, 2), std::pair(34200LL, kUnknown));
  EXPECT_EQ(unit_of("Elapsed [d]", 0, 1, 0), std::pair(1641600LL, kUnknown));
  EXPECT_EQ(unit_of("Date", 46082 + 1 / 3., 10 / 86400., 8), std::pair(190LL, 1772352000LL));
  EXPECT_EQ(unit_of("Zeit", 740042.25, 10 / 86400., 8), std::pair(190LL, 1772344800LL));
  EXPECT_EQ(unit_of("X_Value", 3855192000, 10, 0), std::pair(190LL, 1772347200LL));
}

TEST(Guess, DistinguishesSecondsFromMillisecondsByTemperatureRate) {
  const auto unit_of = [](const std::string& title, int step, double kelvins) {
    std::string table = title + ",T1 [degC],gyro_x\n";
    for (int i = 0; i < 400; ++i) table += fmt::format("{},{:.3f},1\n", step * i, 20 + kelvins * i / 400);
    return guess_map_from_bytes(table, "f").value();
  };
  for (const int step : {10, 30, 60}) {
    const auto map = unit_of("Time", step, 60);
    EXPECT_NE(map.find("unit = \"s\"        # a guess"), std::string::npos) << map;
  }
  EXPECT_NE(unit_of("timestamp", 12, 1).find("unit = \"ms\"        # a guess"), std::string::npos);
  const auto flat = unit_of("Time", 10, 0);
  EXPECT_FALSE(parse_import_map(flat, "f")) << flat;
  EXPECT_NE(flat.find("1 h 06 min 30 s; which line"), std::string::npos) << flat;
}

TEST(Guess, FindsHeaderAfterOtherLines) {
  const std::string rows = "0,20.5,1.5\n10,20.6,1.25\n20,20.7,1.125\n";
  for (const std::string before :
       {"Instrument: 34970A\nSerial: 42\n\nTime [s],T1 [°C],Gyro [°/h]\n",
        "\"TOA5\",\"CR1000\",\"x\",\"1234\"\n\"Time\",\"T1 degC\",\"Gyro_dph\"\n\"s\",\"Deg "
        "C\",\"deg/h\"\n\"\",\"Avg\",\"Smp\"\n",
        "Title,,\nOwner: lab 3,,\nTime [s],T1 [°C],Gyro [°/h]\n", "\"Time\n[s]\",\"T1\n[°C]\",\"Gyro [°/h]\"\n",
        "# Time [s],T1 [°C],Gyro [°/h]\n", "Time [s],T1 [°C],Gyro [°/h],Comment\n"}) {
    const Guessed guess = draft_map(before + rows);
    ASSERT_EQ(guess.rows.time.size(), 3u) << guess.text;
    EXPECT_EQ(guess.rows.time.back(), std::chrono::seconds(20)) << guess.text;
    EXPECT_EQ(guess.rows.columns, (std::vector<std::vector<double>>{{20.5, 20.6, 20.7}, {1.5, 1.25, 1.125}}));
  }
}

TEST(Guess, DoesNotTreatNumberAsMissing) {
  const auto read = [](const std::string& cells) {
    const Guessed guess = draft_map("t [s];T1 [°C];w [°/h]\n" + cells);
    EXPECT_TRUE(guess.map.missing.empty()) << guess.text;
    return guess.rows.columns[1];
  };
  EXPECT_EQ(read("0;20;998\n1;20;999\n2;20;1,000\n3;20;1,001\n"), (std::vector<double>{998, 999, 1000, 1001}));
  EXPECT_EQ(read("0;20,5;1.998,5\n1;20,5;1.999,5\n2;20,5;2.000,25\n"), (std::vector<double>{1998.5, 1999.5, 2000.25}));
  EXPECT_EQ(read("0;20;1 998.5\n1;20;1 999.5\n2;20;2 000.5\n"), (std::vector<double>{1998.5, 1999.5, 2000.5}));
  EXPECT_EQ(read("0;20;\xE2\x88\x92"
                 "1.5\n1;20;0.5\n2;20;\xE2\x80\x93"
                 "2\n"),
            (std::vector<double>{-1.5, 0.5, -2}));
  EXPECT_EQ(read("0;20;1.5 °/h\n1;20;-0.5 °/h\n2;20;2 °/h\n"), (std::vector<double>{1.5, -0.5, 2}));
  const Guessed marked = draft_map("t [s],T1,w\n0,20,1\n1,#DIV/0!,2\n2,---,3\n3,20,1.#QNAN\n4,20,5\n");
  EXPECT_EQ(marked.map.missing, (std::vector<std::string>{"#DIV/0!", "---", "1.#QNAN"}));
}

TEST(Guess, LeavesOutAndCountsDamagedLines) {
  for (const std::string damage : {"5,20\n", "t [s],T1,w\n", "5,2x.5,1\n", "5,20,16,20,1\n"}) {
    const Guessed guess = draft_map("t [s],T1,w\n0,20,1\n1,21,2\n" + damage + "2,22,3\n3,23,4\n");
    EXPECT_TRUE(guess.map.leaves_out_damaged) << damage << guess.text;
    EXPECT_EQ(guess.rows.columns[0], (std::vector<double>{20, 21, 22, 23})) << damage;
    ASSERT_EQ(guess.rows.notes.size(), 1u);
    EXPECT_EQ(guess.rows.notes[0].rfind("1 line cannot be read and was left out; the first: f:4:", 0), 0u);
  }
}

TEST(Guess, NumbersColumnsOfEqualNames) {
  const Guessed guess = draft_map("t [s],Temp,Temp,,w\n0,20,30,40,1\n1,21,31,41,2\n2,22,32,42,3\n");
  EXPECT_EQ(guess.rows.columns[0], (std::vector<double>{20, 21, 22})) << guess.text;
  EXPECT_EQ(guess.rows.columns[1], (std::vector<double>{30, 31, 32})) << guess.text;
}

TEST(Guess, HandlesEachKindOfClock) {
  const auto text_of = [](const std::string& title, const std::vector<double>& times) {
    std::string table = title + ",T1,w\n";
    for (const double time : times) table += fmt::format("{:.0f},20,1\n", time);
    return draft_map(table);
  };
  std::vector<double> wrapped, restarted, glitch;
  for (int i = 0; i < 200; ++i) {
    wrapped.push_back(std::fmod(4.2e9 + 1e6 * i, 4294967296.0));
    restarted.push_back(i < 100 ? i : i - 100);
    glitch.push_back(i == 50 ? 1e6 : i);
  }
  const Guessed counter = text_of("micros", wrapped);
  EXPECT_EQ(counter.rows.time.back(), std::chrono::seconds(199)) << counter.text;
  const Guessed again = text_of("t [s]", restarted);
  EXPECT_EQ(again.rows.time.size(), 200u) << again.text;
  EXPECT_EQ(again.rows.time.back(), std::chrono::seconds(199));
  const Guessed one = text_of("t [s]", glitch);
  EXPECT_EQ(one.rows.time.size(), 199u) << one.text;
  EXPECT_EQ(one.rows.time.back(), std::chrono::seconds(199));
}

TEST(Guess, FindsLatin1Header) {
  const Guessed guess = draft_map(
      "Zeit [s];T [\xB0"
      "C];Gyro X [\xB0/s]\n0;20;1\n1;\xFC;1\n2;20;1\n");
  EXPECT_EQ(guess.map.thermometer_columns[0].column.name, "T [°C]");
  EXPECT_EQ(guess.map.missing, std::vector<std::string>{"ü"});
  EXPECT_EQ(guess.map.units[0].axes[0].scale, 3600);
}

TEST(Guess, AcceptsQuotesInNames) {
  EXPECT_EQ(draft("t [s],\"T \"\"die\"\"\",w\n0,20,1\n1,20,1\n").time->name, "t [s]");
}

TEST(Guess, SkipsUnitsBelowHeader) {
  const Guessed guess = draft_map("Time,Temp,Rate\ns,degC,deg/h\n0,20,1\n1,20,1\n2,20,2\n");
  EXPECT_EQ(guess.map.skip, 1u);
  EXPECT_EQ(guess.map.missing, std::vector<std::string>{});
  EXPECT_EQ(guess.rows.time.size(), 3u);
  const Guessed apart = draft_map("# a\nTime,Temp,Rate\n# b\n\ns,degC,deg/h\n0,20,1\n1,20,1\n");
  EXPECT_EQ(apart.map.skip, 2u) << "an empty line counts, a comment does not";
  EXPECT_EQ(apart.rows.time.size(), 2u);
  EXPECT_EQ(draft("Time,Temp,Rate\n0,x,y\n1,20,1\n2,20,2\n").skip, 0u) << "a row with a number is a data row";
}

TEST(Guess, UsesUnitsBelowHeader) {
  const ImportMap map = draft("Zeit;Block;Rueck;Wand;Drehrate\nms;°C;K;[°F];°/s\n0;20;293;68;1\n1000;20;293;68;1\n");
  EXPECT_EQ(map.thermometers, (std::vector<std::string>{"Block", "Rueck", "Wand"}));
  EXPECT_EQ(map.time_unit, std::chrono::milliseconds(1));
  EXPECT_NEAR(map.thermometer_columns[1].offset, -273.15, 1e-9);
  EXPECT_NEAR(map.thermometer_columns[2].scale, 5.0 / 9, 1e-9);
  EXPECT_EQ(map.units[0].axes[0].scale, 3600);
}

TEST(Guess, TakesColumnsWithUnitOfTemperatureAsThermometers) {
  const ImportMap map = draft(
      "t [s],Case [°F],Back [K],Shell (F),Front (K),Gehäuse [°F],gyro_x\n"
      "0,68,293,68,293,68,1\n1,68,293,68,293,68,1\n");
  EXPECT_EQ(map.thermometers, (std::vector<std::string>{"Case", "Back", "Shell", "Front", "Gehaeuse"}));
}

TEST(Guess, SaysThatDatesRunBackwards) {
  const auto text = guess_map_from_bytes(
      "date,T [°C],gyro_x\n2026-03-02 10:00:03,20,1\n2026-03-02 10:00:02,20,1\n2026-03-02 10:00:01,20,1\n", "f.csv");
  ASSERT_TRUE(text) << gyrotherm::text(text.error());
  EXPECT_NE(text->find("run backwards: sort the rows"), std::string::npos) << *text;
  EXPECT_EQ(text->find("unknown notation"), std::string::npos) << *text;
}

TEST(Guess, NumbersColumnsWithoutHeader) {
  const ImportMap map = draft("% made by hand\n0 20 5\n1 21 6\n2 22 7\n");
  EXPECT_FALSE(map.header);
  EXPECT_EQ(map.comment, "%");
  EXPECT_EQ(map.time->number, 1u);
  EXPECT_EQ(map.axis_columns[0].number, 3u);
}

TEST(Guess, DetectsDecreasingTime) {
  EXPECT_EQ(draft("time,T,w\n0,20,1\n2,20,1\n1,20,1\n3,20,1\n").out_of_order, OutOfOrder::skip);
}

TEST(Guess, DetectsLogsByFirstBytes) {
  UlogText px4;
  px4.format("sensor_gyro:uint64_t timestamp;float x;float y;float z;float temperature;");
  px4.format("sensor_baro:uint64_t timestamp;float temperature;")
      .subscribe(0, "sensor_baro")
      .subscribe(1, "sensor_gyro");
  px4.data(0, little(std::uint64_t{900}) + little(25.F));
  px4.data(1, little(std::uint64_t{1000}) + little(1.F) + little(2.F) + little(3.F) + little(30.F));
  const ImportMap map = draft(px4.text());
  EXPECT_EQ(map.format, FileFormat::ulog);
  EXPECT_EQ(map.thermometers, (std::vector<std::string>{"sensor_baro.temperature", "sensor_gyro.temperature"}));
  ASSERT_EQ(map.axis_columns.size(), 3u);
  EXPECT_EQ(map.axis_columns[2].name, "sensor_gyro.z");
  EXPECT_NEAR(map.units[0].axes[0].scale, 206264.806247, 1e-6);
  DataflashText ardupilot;
  ardupilot.format(9, "IMU", "Qfff", "TimeUS,GyrX,GyrY,T", 23);
  ardupilot.message(9, little(std::uint64_t{1000}) + little(1.F) + little(2.F) + little(30.F));
  EXPECT_EQ(draft(ardupilot.text()).axis_columns.size(), 2u);
}

TEST(Guess, SelectsPublishedRawRatesOfLog) {
  const auto log_of = [](const std::vector<std::string>& published) {
    UlogText log;
    log.format("estimator_sensor_bias:uint64_t timestamp;float[3] gyro_bias;");
    log.format("optical_flow:uint64_t timestamp;float gyro_x_rate_integral;");
    log.format(
        "sensor_combined:uint64_t timestamp;float[3] gyro_rad;uint32_t gyro_integral_dt;uint8_t "
        "gyro_calibration_count;");
    log.format("sensor_gyro:uint64_t timestamp;float x;float y;float z;float temperature;");
    log.subscribe(1, "estimator_sensor_bias").subscribe(2, "optical_flow").subscribe(3, "sensor_combined");
    log.subscribe(4, "sensor_gyro").subscribe(5, "sensor_gyro", 1);
    for (unsigned i = 0; i < 5; ++i) {
      const auto time = little(std::uint64_t{1'000'000} * i);
      for (const auto& name : published) {
        const auto three = little(1.F) + little(2.F) + little(3.F);
        if (name == "bias") log.data(1, time + three);
        if (name == "combined") log.data(3, time + three + little(std::uint32_t{4000}) + '\1');
        if (name == "gyro") log.data(4, time + three + little(30.F));
        if (name == "gyro1") log.data(5, time + three + little(31.F));
      }
    }
    return draft_map(log.text());
  };
  const Guessed two = log_of({"bias", "combined", "gyro", "gyro1"});
  ASSERT_EQ(two.map.units.size(), 2u) << two.text;
  EXPECT_EQ(two.map.axis_columns[0].name, "sensor_gyro.x");
  EXPECT_EQ(two.map.axis_columns[5].name, "sensor_gyro[1].z");
  EXPECT_EQ(two.map.units[0].gradients, std::vector<std::string>{"sensor_gyro.temperature"});
  EXPECT_EQ(make_channels(two.map, "")[1].unit_under_test, "imu1") << "each with its own temperature";
  const Guessed combined = log_of({"bias", "combined"});
  ASSERT_EQ(combined.map.axis_columns.size(), 3u) << combined.text;
  EXPECT_EQ(combined.map.axis_columns[2].name, "sensor_combined.gyro_rad[2]");
  const Guessed second = log_of({"bias", "gyro1"});
  EXPECT_EQ(second.map.axis_columns.front().name, "sensor_gyro[1].x");
}

TEST(Guess, NamesUnsupportedFormats) {
  for (const auto& [bytes, said] :
       {std::pair(std::string("BZh91AY"), "bzip2"), std::pair(std::string("PK\x03\x04 log.csv"), "zip"),
        std::pair("log.csv" + std::string(250, '\0') + "ustar", "tar"),
        std::pair(std::string("PK\x03\x04 [Content_Types].xml"), "xlsx"),
        std::pair(std::string("MATLAB 5.0 MAT-file, Platform"), "MATLAB"),
        std::pair(std::string("MDF     4.10"), "MDF"), std::pair(std::string("TDSm"), "TDMS"),
        std::pair(std::string("PAR1"), "Parquet")}) {
    const auto map = guess_map_from_bytes(bytes, "f");
    ASSERT_FALSE(map);
    EXPECT_NE(map.error().what.find(said), std::string::npos) << map.error().what;
  }
}

TEST(Guess, RefusesFileWithoutTable) {
  for (const std::string bytes : {"", "\n\n", "one\ntwo\n", "#\n", "a,b\n"}) {
    const auto map = guess_map_from_bytes(bytes, "f");
    ASSERT_FALSE(map) << bytes;
    EXPECT_EQ(text(map.error()), "f: neither a text table of at least two columns nor a known log format");
  }
}

TEST(Guess, AsksForMissingGyro) {
  const auto map = guess_map_from_bytes("time,T\n0,20\n1,21\n", "f");
  ASSERT_TRUE(map);
  EXPECT_NE(map->find("column = \"\"        # which column is the gyro's?"), std::string::npos) << *map;
}

/// The names below the header are fewer than the fields of every row, so the file is read like any other table.
TEST(Guess, ReadsTableWhoseLabViewHeaderDoesNotFit) {
  for (const char* names : {"X_Value\tComment", "X_Value\tBlock", "X_Value\tBlock\tComment"})
    for (const int columns : {5, 40}) {
      std::string text =
          fmt::format("LabVIEW Measurement\nSeparator\tTab\nY_Unit_Label\tDeg C\n***End_of_Header***\n{}\n", names);
      for (int row = 0; row < 30; ++row) {
        text += fmt::format("{}", row);
        for (int column = 1; column < columns; ++column) text += fmt::format("\t{}", (7 * row + column) % 11);
        text += "\n";
      }
      const auto map = guess_map_from_bytes(text, "folder/file.lvm");
      ASSERT_TRUE(map) << gyrotherm::text(map.error());
      EXPECT_NE(map->find("header = false\nskip = 5"), std::string::npos) << *map;
      EXPECT_EQ(map->find("segment"), std::string::npos) << *map;
      EXPECT_EQ(map->find("damaged"), std::string::npos) << *map;
    }
}

TEST(Guess, AcceptsTimesOfAnySize) {
  for (const char* name : {"Time [s]", "time", "millis", "t [d]", "x"})
    for (const char* wild : {"1e300", "-1e300", "1.7e308", "99999999999999999999", "-1.7e308"}) {
      std::string text = fmt::format("{},T [°C],gyro [deg/h]\n", name);
      for (int row = 0; row < 60; ++row)
        text += fmt::format("{},{},{}\n", row % 20 == 7 ? wild : fmt::format("{}", 2 * row), 20 + 0.1 * row, row % 7);
      EXPECT_TRUE(guess_map_from_bytes(text, "folder/file.csv")) << name << " " << wild;
    }
}

/// Properties of a LabVIEW measurement file.
struct Lvm {
  char decimal = '.';
  int channels = 2;
  std::string x_columns = "One";  ///< or "Multi", "No"
  int segments = 1;
  bool has_comment_text = false;
  std::string separator = "\t";
};

std::string lvm_number(double number, char decimal) {
  auto text = fmt::format("{:.6f}", number);
  if (decimal == ',') text[text.find('.')] = ',';
  return text;
}

std::string lvm_cells(const Lvm& lvm, const std::string& first, const std::string& each) {
  std::string line = first;
  for (int i = 0; i < lvm.channels; ++i) line += lvm.separator + each;
  return line + "\r\n";
}

/// Returns a file as "Write To Measurement File" writes it: temperature, gyros, ten rows of 0.5 s per segment.
std::string lvm_file(const Lvm& lvm) {
  const auto& s = lvm.separator;
  std::string text = "LabVIEW Measurement" + s + "\r\nWriter_Version" + s + "2\r\nReader_Version" + s +
                     "2\r\nSeparator" + s + (s == "\t" ? "Tab" : "Comma") + "\r\nDecimal_Separator" + s + lvm.decimal +
                     "\r\nMulti_Headings" + s + (lvm.segments > 1 ? "Yes" : "No") + "\r\nX_Columns" + s +
                     lvm.x_columns + "\r\nTime_Pref" + s + "Relative\r\nOperator" + s + "M. Weber\r\nDate" + s +
                     "2026/03/02\r\nTime" + s + "08:00:00" + lvm.decimal + "1234567\r\n***End_of_Header***" + s +
                     "\r\n" + s + "\r\n";
  for (int segment = 0; segment < lvm.segments; ++segment) {
    text += fmt::format("Channels{}{}\r\n", s, lvm.channels) + lvm_cells(lvm, "Samples", "10") +
            lvm_cells(lvm, "Date", "2026/03/02") + lvm_cells(lvm, "Time", std::string("08:00:00") + lvm.decimal + "5");
    text += "Y_Unit_Label" + s + "Deg C";
    for (int i = 1; i < lvm.channels; ++i) text += s + "deg/h";
    text += "\r\n" + lvm_cells(lvm, "X_Dimension", "Time") + lvm_cells(lvm, "X0", lvm_number(0, lvm.decimal)) +
            lvm_cells(lvm, "Delta_X", lvm_number(0.5, lvm.decimal)) + "***End_of_Header***" + s + s + s + "\r\n";
    for (int i = 0; i < lvm.channels; ++i) {
      if (lvm.x_columns == "Multi" || i == 0) text += (lvm.x_columns == "No" ? "" : "X_Value") + s;
      text += (i == 0 ? "Block" : fmt::format("Axis {}", i)) + s;
    }
    text += "Comment\r\n";
    for (int row = 0; row < 10; ++row) {
      for (int i = 0; i < lvm.channels; ++i) {
        if (i > 0) text += s;
        if (lvm.x_columns == "Multi" || i == 0)
          text += (lvm.x_columns == "No" ? "" : lvm_number(0.5 * row, lvm.decimal)) + s;
        text += lvm_number(i == 0 ? 20 + 0.1 * row : 100 * i + row, lvm.decimal);
      }
      text += (lvm.has_comment_text && row == 3 ? s + "door opened" : "") + "\r\n";
    }
    if (segment + 1 < lvm.segments) text += s + "\r\n\r\n";
  }
  return text;
}

TEST(Guess, ReadsLabviewMeasurementFiles) {
  int seen = 0;
  for (const char decimal : {'.', ','})
    for (const char* x_columns : {"One", "Multi", "No"})
      for (const int channels : {2, 4})
        for (const bool has_comment_text : {false, true}) {
          const std::string file = lvm_file({decimal, channels, x_columns, 1, has_comment_text});
          SCOPED_TRACE(file.substr(0, 1500));
          const Guessed guess = draft_map(file);
          EXPECT_EQ(guess.map.decimal, decimal);
          EXPECT_EQ(guess.map.thermometers, std::vector<std::string>{"Block"}) << guess.text;
          ASSERT_EQ(guess.map.axis_columns.size(), static_cast<std::size_t>(channels - 1)) << guess.text;
          EXPECT_EQ(guess.map.units[0].axes[0].scale, 1);
          ASSERT_EQ(guess.rows.time.size(), 10u) << guess.text;
          EXPECT_EQ(guess.rows.time.back(), std::chrono::milliseconds(4500)) << guess.text;
          EXPECT_NEAR(guess.rows.columns[0][9], 20.9, 1e-9);
          EXPECT_NEAR(guess.rows.columns.back()[9], 100 * (channels - 1) + 9, 1e-9);
          ++seen;
        }
  EXPECT_EQ(seen, 24);
}

TEST(Guess, ReadsSegmentsOfLabviewFile) {
  for (const char* x_columns : {"One", "No"}) {
    const Guessed guess = draft_map(lvm_file({',', 2, x_columns, 3, true}));
    EXPECT_EQ(guess.rows.time.size(), 30u) << guess.text;
    EXPECT_TRUE(std::ranges::is_sorted(guess.rows.time));
    EXPECT_NEAR(guess.rows.columns[1][29], 109, 1e-9);
  }
}

TEST(Guess, ReadsLabviewFileWithCommas) {
  const Guessed guess = draft_map(lvm_file({'.', 3, "One", 2, false, ","}));
  EXPECT_EQ(guess.map.separator, ',');
  EXPECT_EQ(guess.rows.time.size(), 20u) << guess.text;
}

TEST(Guess, RefusesLabviewSegmentWithOtherColumns) {
  const std::string file = lvm_file({'.', 2, "One", 1}) + "\t\r\n" +
                           lvm_file({'.', 3, "One", 1}).substr(lvm_file({'.', 3, "One", 1}).find("Channels"));
  const auto map = guess_map_from_bytes(file, "f.lvm");
  ASSERT_TRUE(map) << text(map.error());
  auto parsed = parse_import_map(*map, "guess.toml").value();
  parsed.leaves_out_damaged = false;
  const auto rows = read_rows(file, parsed, "f");
  ASSERT_FALSE(rows);
  EXPECT_NE(rows.error().what.find("differ"), std::string::npos) << text(rows.error());
  for (const std::size_t cut : {700u, 500u, 300u, 20u}) (void)guess_map_from_bytes(file.substr(0, cut), "f.lvm");
}

TEST(Guess, TakesColumnsWithUnitOfRateAsGyro) {
  for (const char* name :
       {"rate_dph", "Kreisel [°/h]", "Kreisel °/h", "Achse 1 (deg/s)", "channel_rad_s", "Drehrate"}) {
    const ImportMap map = draft(fmt::format("t [s];T °C;{}\n0;20;1\n1;20;2\n2;21;3\n", name));
    ASSERT_EQ(map.axis_columns.size(), 1u) << name;
    EXPECT_EQ(map.axis_columns[0].name, name);
    EXPECT_EQ(map.thermometers, std::vector<std::string>{"T"});
  }
  const ImportMap fan = draft("t [s];T °C;Fan [rpm];Gyro [°/h]\n0;20;1000;1\n1;20;1001;2\n2;21;1002;3\n");
  ASSERT_EQ(fan.axis_columns.size(), 1u);
  EXPECT_EQ(fan.axis_columns[0].name, "Gyro [°/h]");
}

TEST(Guess, KeepsLettersOfNames) {
  const ImportMap map = draft(
      "t [s];Température (°C);Ofen °C;Wärmebad Temp °C;Tłumik temp [K];gyro [°/h]\n0;20;20;20;290;1\n1;20;20;20;290;2\n"
      "2;20;20;20;290;2\n");
  EXPECT_EQ(map.thermometers, (std::vector<std::string>{"Temperature", "Ofen", "Waermebad Temp", "Tlumik temp"}));
}

TEST(Guess, IgnoresRawCountsInPaceOfTemperatures) {
  std::string table = "Time,dTemp,Temp,Gx\n";
  for (int i = 0; i < 3000; ++i)
    table += fmt::format("{},{},{:.2f},{}\n", 17139 + 35 * i, -8884 + 2 * i, 8.5 + 0.0003 * i, i % 5);
  const auto text = guess_map_from_bytes(table, "f.csv").value();
  EXPECT_EQ(map_line(text, "unit"), "unit = \"ms\"        # a guess from the steps of the numbers");
  EXPECT_NE(text.find("# The rows are then 0.035 s apart and span 1 min 45 s; is this right?"), std::string::npos)
      << text;
}

TEST(Guess, AsksOneQuestionAboutTimeOfTableWithoutTime) {
  std::string table;
  for (int i = 0; i < 30; ++i) table += fmt::format("{} {} {}\n", i % 3, (i * 7) % 5, (i * 5) % 11);
  const auto text = guess_map_from_bytes(table, "f.imu").value();
  EXPECT_NE(text.find("# The columns have no names: the last one is a guess."), std::string::npos) << text;
  const auto map = parse_import_map(text, "guess.toml");
  ASSERT_FALSE(map);
  EXPECT_EQ(std::ranges::count(map.error().what, '\n'), 0) << map.error().what;
  EXPECT_NE(map.error().what.find("interval = \"1 s\""), std::string::npos) << map.error().what;
}

}  // namespace
}  // namespace gyrotherm::exchange
