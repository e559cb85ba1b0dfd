// SPDX-License-Identifier: Apache-2.0
/// Guarantees of the command line: exit codes, positions of errors, suggestions.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "core/file.hpp"
#include "tests/apps/gyrotherm/program.hpp"
#include "tests/apps/gyrotherm/small_record.hpp"

namespace gyrotherm::app {
namespace {

TEST(CommandLine, SuggestsNearestCommandWhenMisspelt) {
  const auto ran = gyrotherm_with("qualifi --out x");
  EXPECT_EQ(ran.exit_code, 2);
  EXPECT_NE(ran.err.find("Did you mean \"qualify\"?"), std::string::npos) << ran.err;
}

TEST(CommandLine, SuggestsCommandBelowCommandWithFiles) {
  const auto ran = gyrotherm_with("standard explian");
  EXPECT_EQ(ran.exit_code, 2);
  EXPECT_NE(ran.err.find("\"explian\" is not a command of standard. Did you mean \"explain\"?"), std::string::npos)
      << ran.err;
}

TEST(CommandLine, NamesPlaceOfOptionBeforeItsCommand) {
  const auto ran = gyrotherm_with("--rig virtual check random");
  EXPECT_EQ(ran.exit_code, 2);
  EXPECT_NE(ran.err.find("--rig is an option of check, expected it after check"), std::string::npos) << ran.err;
}

TEST(CommandLine, RefusesMissingCommandAndUnknownOptions) {
  EXPECT_EQ(gyrotherm_with("").exit_code, 2);
  EXPECT_EQ(gyrotherm_with("check --colour").exit_code, 2);
  EXPECT_EQ(gyrotherm_with("check").exit_code, 2);
  EXPECT_EQ(gyrotherm_with("train").exit_code, 2);
}

TEST(CommandLine, AcceptsOnlyFiniteDecimalNumbers) {
  const auto refused = [](const std::string& arguments, const std::string& option) {
    const auto ran = gyrotherm_with(arguments);
    EXPECT_EQ(ran.exit_code, 2) << arguments;
    EXPECT_NE(ran.err.find(": " + option + ": \""), std::string::npos) << arguments << "\n" << ran.err;
    EXPECT_NE(ran.err.find("\" is not an accepted number"), std::string::npos) << arguments << "\n" << ran.err;
  };
  for (const auto* number : {"''", "' 25'", "'25 '", "0x19", "+25", "1e999", "nan", "inf", "25,5", "25C"})
    refused(std::string("go virtual ") + number, "at");
  for (const auto* number : {"''", "' 1'", "0x10", "1.5", "18446744073709551616"}) {
    refused(std::string("check --rig virtual --seed ") + number, "--seed");
  }
  for (const auto* number : {"''", "' 1'", "0x10"}) refused(std::string("simulate --port ") + number, "--port");
  for (const std::string words :
       {"1.5 is not a whole number", "65536 is outside 0 to 65535", "18446744073709551616 is outside 0 to 65535"}) {
    const auto ran = gyrotherm_with("simulate --port " + words.substr(0, words.find(' ')));
    EXPECT_EQ(ran.exit_code, 2);
    EXPECT_NE(ran.err.find("--port: " + words), std::string::npos) << ran.err;
  }
  for (const auto* option : {"--threshold", "--guard", "--threads"})
    refused(std::string("train run.db --out model.json ") + option + " nan", option);
  refused("fuse run.db --models out --false-alarm nan", "--false-alarm");
  refused("reduce model.json run.db --out small.json --within nan", "--within");
  for (const auto* option : {"--film", "--ambient", "--fit"})
    refused(std::string("thermal --out image ") + option + " nan", option);
  EXPECT_EQ(gyrotherm_with("check --rig virtual --seed ' -1'").exit_code, 2);
  EXPECT_EQ(gyrotherm_with("train run.db --out model.json --threads -5").exit_code, 2);
  for (const auto* pace : {"x", "'x 10'", "x0x10", "xnan", "xinf", "x-1"})
    EXPECT_EQ(gyrotherm_with(std::string("simulate --pace ") + pace).exit_code, 2) << pace;
}

TEST(CommandLine, RefusesEmptyValues) {
  for (const auto* arguments : {"train run.db --out model.json --inputs ''", "check --rig ''", "check ''",
                                "export run.db --out ''", "fuse run.db --models ''"}) {
    const auto ran = gyrotherm_with(arguments);
    EXPECT_EQ(ran.exit_code, 2) << arguments;
    EXPECT_NE(ran.err.find("is empty"), std::string::npos) << arguments << "\n" << ran.err;
  }
}

TEST(CommandLine, RefusesOptionWithoutEffect) {
  for (const auto* option : {"--model model.json", "--outside refuse", "--unit u1", "--axis x"}) {
    const auto ran = gyrotherm_with(std::string("export run.db --out rows.csv ") + option);
    EXPECT_EQ(ran.exit_code, 2) << option;
    EXPECT_NE(ran.err.find("--compensated"), std::string::npos) << option << "\n" << ran.err;
  }
}

TEST(CommandLine, RefusesSeedOnRealRig) {
  for (const std::string command : {"check", "run short"}) {
    const auto ran = gyrotherm_with(command + " --rig example-f4t-lakeshore-kvh --seed 7");
    EXPECT_EQ(ran.exit_code, 2);
    EXPECT_EQ(ran.err, "gyrotherm: --seed: only valid on a virtual rig\n");
  }
}

TEST(CommandLine, AnswersHelpAndVersionAsCommands) {
  EXPECT_EQ(gyrotherm_with("help").out, gyrotherm_with("--help").out);
  EXPECT_EQ(gyrotherm_with("help report sign").out, gyrotherm_with("report sign --help").out);
  EXPECT_EQ(gyrotherm_with("version").out, gyrotherm_with("--version").out);
  EXPECT_NE(gyrotherm_with("help rnu").err.find("Did you mean \"run\"?"), std::string::npos);
  EXPECT_EQ(gyrotherm_with("help rnu").exit_code, 2);
  EXPECT_EQ(gyrotherm_with("version 2").exit_code, 2);
}

TEST(CommandLine, NamesRemedyOfUsualSlips) {
  const Folder folder;
  const std::pair<std::string, std::string> kSlips[] = {
      {"status run.db -verify", "-verify is not an option of status. Did you mean --verify?"},
      {"tell", "run is required: "},
      {"release", "release: a command is required, one of review, sign, list"},
      {"plan virtual --target-u 0 --out p.toml", "--target-u: 0 is not a number above zero"},
      {"plan virtual --target-u 1 --out p.svg", "--out: p.svg does not end in .toml, as a profile does"},
      {"import table.csv --guess --out map.db", "--out: map.db does not end in .toml, as a map does"},
      {"export run.db --out rows.xlsx", "--out: no .xlsx file can be written"}};
  for (const auto& [arguments, message] : kSlips) {
    const auto ran = gyrotherm_with(arguments);
    EXPECT_EQ(ran.exit_code, 2) << arguments;
    EXPECT_NE(ran.err.substr(0, ran.err.find('\n')).find(message), std::string::npos) << ran.err;
  }
  std::ofstream(folder / "night.toml") << "";
  const auto ran = shell("cd '" + (folder / "") + "' && gyrotherm check night");
  EXPECT_NE(ran.err.find("write ./night.toml"), std::string::npos) << ran.err;
}

TEST(CommandLine, ReportsMissingRecordAsWrongFile) {
  const Folder folder;
  for (const char* command :
       {"status {}", "resume {}", "tell {} pause", "export {} --out rows.csv", "train {} --out model.json"}) {
    const auto ran = gyrotherm_with(fmt::format(fmt::runtime(command), "'" + (folder / "no.db") + "'"));
    EXPECT_EQ(ran.exit_code, 4) << command;
    EXPECT_NE(ran.err.find("no.db: no such file, expected "), std::string::npos) << ran.err;
  }
}

TEST(CommandLine, RefusesDashAsFileName) {
  const Folder folder;
  for (const auto* arguments :
       {"export run.db --out -", "train run.db --out -", "export-model model.json --as libsvm --out -",
        "import rows.csv --map map.toml --out -", "run day.toml --rig virtual --out -", "qualify --out -",
        "reduce model.json run.db --keep 3 --out -", "type-prior run.db --out -", "report run.db --out -"}) {
    const auto ran = shell("cd " + (folder / ".") + " && gyrotherm " + arguments);
    EXPECT_EQ(ran.exit_code, 2) << arguments << ran.err;
    EXPECT_NE(ran.err.find("\"-\" is not a file name here"), std::string::npos) << arguments << "\n" << ran.err;
    EXPECT_FALSE(std::filesystem::exists(folder / "-")) << arguments;
  }
}

/// SQLite discards a database in memory.
TEST(CommandLine, RefusesRecordInMemory) {
  const Folder folder;
  std::ofstream(folder / "rows.csv") << small_rows(3);
  std::ofstream(folder / "map.toml") << small_map();
  std::ofstream(folder / "day.toml") << read_text_file(GYROTHERM_SOURCE_DIR "/tests/profiles/ten-seconds.toml").value();
  for (const auto* arguments : {"import rows.csv --map map.toml --out ", "run day.toml --rig virtual --out "}) {
    const auto inside = [&](const std::string& out) {
      return shell("cd " + (folder / ".") + " && gyrotherm " + arguments + out);
    };
    const auto refused = inside(":memory:");
    EXPECT_EQ(refused.exit_code, 2) << arguments << refused.err;
    EXPECT_NE(refused.err.find("\":memory:\" is not accepted as a file name"), std::string::npos) << refused.err;
    EXPECT_FALSE(std::filesystem::exists(folder / ":memory:")) << arguments;
    const auto made = inside("./:memory:");
    EXPECT_EQ(made.exit_code, 0) << arguments << made.err;
    EXPECT_TRUE(std::filesystem::remove(folder / ":memory:")) << arguments;
  }
}

TEST(CommandLine, ReportsMissingFolderBeforeWork) {
  const Folder folder;
  for (const auto* arguments :
       {"export run.db --out ", "train run.db --out ", "import rows.csv --map freeimu --out "}) {
    const auto ran = gyrotherm_with(arguments + (folder / "none/file"));
    EXPECT_EQ(ran.exit_code, 2) << arguments << ran.err;
    EXPECT_NE(ran.err.find((folder / "none") + " does not exist"), std::string::npos) << arguments << "\n" << ran.err;
  }
  const auto itself = gyrotherm_with("export run.db --force --out " + (folder / "."));
  EXPECT_NE(itself.err.find("is a folder"), std::string::npos) << itself.err;
}

TEST(CommandLine, KeepsClosedStandardDescriptorsUnused) {
  const Folder folder;
  make_small_model(folder);
  const auto nothing_read = shell("gyrotherm compensate " + (folder / "model.json") + " <&-");
  EXPECT_EQ(nothing_read.exit_code, 4) << "stdin is at its end: there is no header\n" << nothing_read.err;
  const auto unheard = shell("gyrotherm check --rig virtual >&-");
  EXPECT_EQ(unheard.exit_code, 4) << unheard.err;
  EXPECT_NE(unheard.err.find("stdout: cannot be written"), std::string::npos) << unheard.err;
  const auto mute = shell("gyrotherm export " + (folder / "record.db") + " --out " + (folder / "rows.csv") +
                          " <&- >&- 2>&- && head -c 4 " + (folder / "rows.csv"));
  EXPECT_EQ(mute.exit_code, 0);
  EXPECT_EQ(mute.out.find("gyrotherm"), std::string::npos) << "a message is not written into the table";
}

TEST(CommandLine, BeginsHelpOfEachCommandWithExample) {
  for (const auto* command :
       {"qualify", "run", "go", "resume", "status", "simulate", "check", "import", "export", "train", "verify",
        "type-prior", "compensate", "fuse", "export-model", "reduce", "report", "doctor", "completion"}) {
    const auto ran = gyrotherm_with(std::string(command) + " --help");
    EXPECT_EQ(ran.exit_code, 0) << command;
    EXPECT_TRUE(ran.out.starts_with("Example: gyrotherm " + std::string(command))) << ran.out;
  }
}

TEST(MakeSafe, GivesUpOnlyRecords) {
  const Folder folder;
  std::ofstream(folder / "other.txt") << "text";
  for (const char* name : {"none.db", "other.txt"}) {
    const auto ran = shell(std::string(GYROTHERM_PROGRAM) + "-make-safe --give-up " + (folder / name) + " reason");
    EXPECT_EQ(ran.exit_code, 4) << name << ran.err;
  }
}

/// Runs --give-up beside a guard, which a shell plays: it waits for the order, leaves the trace, and executes `then`.
Ran give_up_beside_guard(const Folder& folder, bool confirmed, const std::string& details, const std::string& then) {
  const auto record = folder / "run.db";
  std::ofstream(record) << "SQLite format 3";
  std::ofstream(record + ".safe-state")
      << "schema = \"gyrotherm-safe-state/2\"\nrecord = \"" << record
      << "\"\nline = \"tcp://127.0.0.1:1\"\nlink = \"tcp\"\nlink_settings = {}\nword_order = \"of the map\"\n"
         "safe_set_point_c = 20\nswitch_off = false\nby_program = false\nobserve_s = 60\nsettings = {}\n"
         "pid = 999999999\nstarted = 1\nboot = \"another\"\nmap = []\n";
  std::ofstream(folder / "trace") << "schema = \"gyrotherm-made-safe/1\"\nat = \"2026-01-01T00:00:00Z\"\n"
                                     "utc_ns = 1767225600000000000\nbecause = \"the program that drove it hung\"\n"
                                     "set_point_c = 20\nconfirmed = "
                                  << (confirmed ? "true" : "false") << "\ndetails = \"" << details << "\"\n";
  return shell("cd " + (folder / "") + " && (while [ ! -e run.db.give-up ]; do sleep 0.05; done; " +
               "cp trace run.db.made-safe; " + then + ") & " + GYROTHERM_PROGRAM + "-make-safe --give-up " + record +
               " 'chamber switched off'");
}

TEST(MakeSafe, ReportsChamberSafeIfGuardConfirmsItMeanwhile) {
  for (const char* then : {"rm run.db.safe-state run.db.give-up", "rm run.db.safe-state"}) {
    const Folder folder;
    const auto ran = give_up_beside_guard(folder, true, "air near 20 °C", then);
    EXPECT_EQ(ran.exit_code, 0) << ran.err;
    EXPECT_NE(ran.err.find("made safe by the guard at 2026-01-01T00:00:00Z"), std::string::npos) << ran.err;
    EXPECT_EQ(ran.err.find("NOT confirmed"), std::string::npos) << ran.err;
    EXPECT_FALSE(std::filesystem::exists(folder / "run.db.give-up")) << then;
  }
}

TEST(MakeSafe, ReportsLaterRunThatHasTakenChamberOver) {
  const Folder folder;
  const auto ran = give_up_beside_guard(folder, false,
                                        "process 7 of ada (uid 1000), record /d/run.db has taken the chamber over "
                                        "and has a guard of its own",
                                        "rm run.db.safe-state run.db.give-up");
  EXPECT_EQ(ran.exit_code, 5) << ran.err;
  EXPECT_NE(ran.err.find("process 7 of ada"), std::string::npos) << ran.err;
  EXPECT_EQ(ran.err.find("nothing guards it"), std::string::npos) << ran.err;
}

TEST(MakeSafe, WarnsIfGuardGivesUpUnconfirmedChamber) {
  const Folder folder;
  const auto ran = give_up_beside_guard(folder, false, "mode NOT shown: holding",
                                        "printf 'given_up = \"ada: done\"\\n' >>run.db.made-safe; "
                                        "rm run.db.safe-state run.db.give-up");
  EXPECT_EQ(ran.exit_code, 3) << ran.err;
  EXPECT_NE(ran.err.find("GIVEN UP by the guard"), std::string::npos) << ran.err;
  EXPECT_NE(ran.err.find("nothing guards it"), std::string::npos) << ran.err;
}

TEST(MakeSafe, RefusesUnknownOptionAndEmptyPath) {
  const auto misspelt = shell(std::string(GYROTHERM_PROGRAM) + "-make-safe --kil run.db");
  EXPECT_EQ(misspelt.exit_code, 2);
  EXPECT_NE(misspelt.err.find("--kil is not an option; did you mean --kill?"), std::string::npos) << misspelt.err;
  EXPECT_EQ(shell(std::string(GYROTHERM_PROGRAM) + "-make-safe ''").exit_code, 2);
}

TEST(Tell, NamesPathThatIsNotARecord) {
  const Folder folder;
  std::ofstream(folder / "other.txt") << "text";
  for (const char* name : {"none.db", "other.txt", ""}) {
    const auto ran = gyrotherm_with("tell " + (folder / name) + " pause");
    EXPECT_EQ(ran.exit_code, 4) << name << ran.err;
    EXPECT_NE(ran.err.find("record"), std::string::npos) << ran.err;
  }
}

TEST(Check, PrintsTimelineOfRampProgram) {
  const auto ran = gyrotherm_with("check profiles/qualification.toml --rig profiles/rigs/virtual.toml");
  EXPECT_EQ(ran.exit_code, 0) << ran.err;
  for (const auto* figure : {"672", "552", "512", "480", "2216"})
    EXPECT_NE(ran.out.find(figure), std::string::npos) << figure;
}

TEST(Check, RefusesProfileOutsideChamberLimitsWithPosition) {
  const Folder folder;
  std::ofstream(folder / "hot.toml") << "schema = \"gyrotherm-profile/1\"\nname = \"hot\"\n\n[[segment]]\nkind = "
                                        "\"hold\"\nat = \"150 °C\"\ntime = \"1 h\"\n";
  const auto ran = gyrotherm_with("check " + (folder / "hot.toml") + " --rig profiles/rigs/virtual.toml");
  EXPECT_EQ(ran.exit_code, 4);
  EXPECT_NE(ran.err.find("hot.toml:4:1"), std::string::npos) << ran.err;
}

TEST(Check, WarnsOfSetPointAtLimitThatEndsRun) {
  const Folder folder;
  const auto rig = folder / "rig.toml";
  const auto warnings_with = [&](const std::string& limits) {
    const auto ran = shell("sed 's|\"\\.\\./|\"'$PWD'/profiles/|; s/^thermometers_highest.*/" + limits +
                           "/' profiles/rigs/virtual-reference.toml > " + rig +
                           "; gyrotherm check qualification --json --rig " + rig);
    EXPECT_EQ(ran.exit_code, 0) << ran.err;
    return nlohmann::json::parse(ran.out)["profile"]["reached_limits"];
  };
  EXPECT_EQ(warnings_with("thermometers_highest = 85").size(), 0u);
  const auto common = warnings_with("thermometers_highest = 60");
  ASSERT_EQ(common.size(), 1u);
  EXPECT_EQ(common[0], "the set point of 60 °C reaches a limit of the thermometers: a run ends above 60 °C");
  const auto own = warnings_with("channel.shell = { lowest = -30, highest = 90 }");
  ASSERT_EQ(own.size(), 1u) << own;
  EXPECT_NE(own[0].get<std::string>().find("of thermometer shell: a run ends below -30 °C"), std::string::npos) << own;
}

TEST(Check, WarnsOfGyroAndThermometerOnOneConnection) {
  const Folder folder;
  const auto rig = folder / "rig.toml";
  const auto shared_with = [&](const std::string& port) {
    const auto ran = shell(
        "sed 's|\"\\.\\./|\"'$PWD'/profiles/|; s#serial:/dev/serial/by-id/usb-Moxa[^\"]*#tcp://10.0.0.5:4001#; "
        "s#serial:/dev/serial/by-id/usb-FTDI_USB-RS232_Cable_FT123456[^\"]*#tcp://10.0.0.5:" +
        port + "#' profiles/rigs/example-f4t-lakeshore-kvh.toml > " + rig + "; gyrotherm check --json --rig " + rig);
    EXPECT_EQ(ran.exit_code, 0) << ran.err;
    return nlohmann::json::parse(ran.out)["rig"]["shared_connections"];
  };
  EXPECT_EQ(shared_with("4002").size(), 0u);
  const auto shared = shared_with("4001");
  ASSERT_EQ(shared.size(), 1u);
  EXPECT_EQ(shared[0],
            "tcp://10.0.0.5:4001 is the line of 2 gyros or thermometers; each needs a connection of its own");
}

TEST(Check, RefusesVirtualRigLikeRun) {
  const Folder folder;
  const auto rig = folder / "rig.toml";
  const auto ran =
      shell("sed 's/\"shell\"/\"outside\"/g; s|\"\\.\\./|\"'$PWD'/profiles/|' profiles/rigs/virtual.toml > " + rig +
            "; gyrotherm check --rig " + rig);
  EXPECT_EQ(ran.exit_code, 4) << ran.out;
  EXPECT_NE(ran.err.find("channel \"outside\" is not one of A, B"), std::string::npos) << ran.err;
}

TEST(Check, RefusesSoakOnUnknownSensor) {
  const Folder folder;
  std::ofstream(folder / "soak.toml")
      << "schema = \"gyrotherm-profile/1\"\nname = \"soak\"\n\n[[segment]]\nkind = "
         "\"hold\"\nat = \"20 °C\"\ntime = \"1 min\"\n\n[[segment]]\nkind = \"hold\"\n"
         "at = \"150 °C\"\ntime = \"1 min\"\nguaranteed_soak = true\nsoak_sensor = \"Z\"\n";
  const auto profile = folder / "soak.toml", record = folder / "soak.db";
  EXPECT_EQ(gyrotherm_with("check " + profile).exit_code, 0) << "it is valid by itself";
  for (const auto& command : {"check " + profile, "run " + profile + " --out " + record}) {
    const auto ran = gyrotherm_with(command + " --rig profiles/rigs/virtual.toml");
    EXPECT_EQ(ran.exit_code, 4) << command;
    EXPECT_NE(ran.err.find("soak.toml:9:1: soak_sensor is \"Z\", expected \"air\" or a channel"), std::string::npos)
        << ran.err;
    EXPECT_NE(ran.err.find("150 °C is outside the chamber"), std::string::npos) << "and the other error: " << ran.err;
  }
  EXPECT_FALSE(std::filesystem::exists(record));
}

TEST(Check, ReportsAllErrorsOfFile) {
  const Folder folder;
  std::ofstream(folder / "bad.toml") << "schema = \"gyrotherm-profile/1\"\nnaem = \"x\"\n\n[[segment]]\nkind = "
                                        "\"hold\"\nat = 20\ntime = \"1 fortnight\"\n";
  const auto ran = gyrotherm_with("check " + (folder / "bad.toml"));
  EXPECT_EQ(ran.exit_code, 4);
  EXPECT_NE(ran.err.find("bad.toml:2:1"), std::string::npos) << ran.err;
  EXPECT_NE(ran.err.find("bad.toml:7:8"), std::string::npos) << ran.err;
}

TEST(Check, ConnectQueriesEveryInstrument) {
  const auto ran = gyrotherm_with("check --rig profiles/rigs/virtual.toml --connect");
  EXPECT_EQ(ran.exit_code, 0) << ran.err;
  for (const auto* word : {"chamber:", "LSCI,MODEL218", "gyro:"})
    EXPECT_NE(ran.out.find(word), std::string::npos) << ran.out;
}

TEST(Check, ConnectTimesEveryInstrumentOfMixedRig) {
  const auto ran = gyrotherm_with("check --rig profiles/rigs/virtual-mixed.toml --connect");
  EXPECT_EQ(ran.exit_code, 0) << ran.err;
  for (const auto* word : {"word order cdab", "USB-TEMP", "10 reads: ", "2 frames seen, 0 lost, 0 bad"})
    EXPECT_NE(ran.out.find(word), std::string::npos) << ran.out;
}

TEST(Check, ReportsConfidenceOfFilesAndDueCalibrations) {
  const Folder folder;
  const auto ran = shell("sed -e 's#\\.\\./#" GYROTHERM_SOURCE_DIR
                         "/profiles/#; s#2027-01-18#2020-01-18#' profiles/rigs/example-f4t-lakeshore-kvh.toml > " +
                         (folder / "rig.toml") + " && gyrotherm check --rig " + (folder / "rig.toml"));
  EXPECT_EQ(ran.exit_code, 0) << ran.err;
  for (const auto* word :
       {"description: verified, from DSP-3000 manual", "WARNING: calibration of B", "from the manual",
        "polynomial 0.0031, 0.99987, 1.2e-06, certificate K-2026-0118, due 2020-01-18"})
    EXPECT_NE(ran.out.find(word), std::string::npos) << ran.out;
}

/// Returns the path of a copy of the virtual rig with these [limits] in its chamber map. `link` holds lines of
/// [chamber].
std::string write_rig_with_chamber_limits(const Folder& folder, const std::string& limits,
                                          const std::string& link = "") {
  const auto made = shell("printf '[limits]\\n" + limits + "\\n' | cat profiles/chambers/virtual.toml - > '" +
                          (folder / "map.toml") + "'; sed -e 's#\\.\\./chambers/virtual.toml#map.toml#; s#\\.\\./#" +
                          GYROTHERM_SOURCE_DIR "/profiles/#; s#^safe_set_point#" + link +
                          "safe_set_point#' profiles/rigs/virtual.toml > '" + (folder / "rig.toml") + "'");
  EXPECT_EQ(made.exit_code, 0) << made.err;
  return "'" + (folder / "rig.toml") + "'";
}

TEST(Check, CountsSetPointsOfRun) {
  const Folder folder;
  const auto counted = [&](const std::string& limits) {
    const auto ran = gyrotherm_with("check profiles/qualification.toml --json --rig " +
                                    write_rig_with_chamber_limits(folder, limits));
    EXPECT_EQ(ran.exit_code, 0) << ran.err;
    return nlohmann::json::parse(ran.out).at("profile").at("set_points").get<long>();
  };
  const auto each_second = counted("");
  EXPECT_GT(each_second, 30'000);
  EXPECT_NEAR(static_cast<double>(counted("every = \"10 s\"")), static_cast<double>(each_second) / 10, 100);
  EXPECT_NE(
      gyrotherm_with("check profiles/qualification.toml").out.find(fmt::format("sends {} set points", each_second)),
      std::string::npos);
}

TEST(Check, WarnsWhenControllerStoresEachSetPoint) {
  const Folder folder;
  const auto ran = gyrotherm_with("check profiles/qualification.toml --rig " +
                                  write_rig_with_chamber_limits(folder, "nonvolatile_set_point = 100000"));
  EXPECT_EQ(ran.exit_code, 0) << ran.err;
  for (const auto* word : {"stores each of them in memory that is rated for 100000 writes", "% of its life", "`every`"})
    EXPECT_NE(ran.out.find(word), std::string::npos) << ran.out;
  EXPECT_EQ(gyrotherm_with("check profiles/qualification.toml --rig virtual").out.find("is rated for"),
            std::string::npos);
  for (const auto* wrong : {"0", "-5", "1.5", "\"many\""})
    EXPECT_EQ(gyrotherm_with("check --rig " +
                             write_rig_with_chamber_limits(folder, "nonvolatile_set_point = " + std::string(wrong)))
                  .exit_code,
              4)
        << wrong;
}

TEST(Check, WarnsWhenDeviceNameMayChange) {
  const Folder folder;
  const auto edited = shell(
      "sed 's#serial:/dev/serial/by-id/usb-Moxa[^\"]*#serial:/dev/ttyUSB3#' "
      "profiles/rigs/example-f4t-lakeshore-kvh.toml > '" +
      (folder / "rig.toml") + "'; gyrotherm check --rig '" + (folder / "rig.toml") + "'");
  EXPECT_EQ(edited.exit_code, 0) << edited.err;
  EXPECT_NE(edited.out.find("WARNING: gyro: /dev/ttyUSB3 depends on the order in which adapters are plugged in"),
            std::string::npos)
      << edited.out;
}

TEST(Check, ConnectUsesLinkSettingsOfRig) {
  const Folder folder;
  for (const auto* link : {"link = { unit = 1 }", "link = { returns_other_transaction = true, read_at_most = 9 }",
                           "link = { timeout = \"1 s\", returns_other_unit = true }"}) {
    const auto ran =
        gyrotherm_with("check --connect --rig " + write_rig_with_chamber_limits(folder, "", std::string(link) + "\\n"));
    EXPECT_EQ(ran.exit_code, 0) << link << ": " << ran.err;
    EXPECT_NE(ran.out.find("chamber: "), std::string::npos);
  }
}

TEST(Check, PrintsFindingsAsOneJsonDocument) {
  const auto ran =
      gyrotherm_with("check profiles/qualification.toml --rig profiles/rigs/virtual.toml --connect --json");
  ASSERT_EQ(ran.exit_code, 0) << ran.err;
  const auto found = nlohmann::json::parse(ran.out);
  EXPECT_EQ(found["rig"]["simulated"], true);
  EXPECT_EQ(found["instruments"].size(), 4u);
  EXPECT_EQ(found["profile"]["all"]["seconds"], 221600);
  EXPECT_EQ(found["profile"]["all"]["clusters"], 2216);
}

TEST(Run, FailsWithInstrumentFaultWhenRigIsMissing) {
  const Folder folder;
  auto rig =
      shell(
          "sed -e 's#\"virtual\"$#\"tcp://127.0.0.1:9\"#; s#= \"virtual\" .*#= \"tcp://127.0.0.1:9\"#; "
          "s#\\.\\./chambers#" GYROTHERM_SOURCE_DIR "/profiles/chambers#; /^\\[virtual/,$d' profiles/rigs/virtual.toml")
          .out;
  std::ofstream(folder / "rig.toml") << rig;
  const auto ran = gyrotherm_with("run tests/profiles/short-rate.toml --unit 0042 --rig " + (folder / "rig.toml") +
                                  " --out " + (folder / "run.db"));
  EXPECT_EQ(ran.exit_code, 3) << ran.err;
  EXPECT_FALSE(std::filesystem::exists(folder / "run.db"));
}

TEST(Run, IgnoresFilesOfEarlierRecordWithSameName) {
  const Folder folder;
  const auto record = folder / "run.db";
  std::ofstream(record + ".made-safe")
      << "schema = \"gyrotherm-made-safe/1\"\nat = \"2026-03-01T00:00:00Z\"\nutc_ns = 1772323200000000000\n"
         "because = \"the program that drove it has ended\"\nset_point_c = 23\nconfirmed = false\n"
         "details = \"no reply\"\n";
  std::ofstream(record + ".sha256") << std::string(64, '0') << "  run.db\n";
  const auto run = gyrotherm_with("run tests/profiles/ten-seconds.toml --rig virtual --out " + record);
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_FALSE(std::filesystem::exists(record + ".made-safe"));
  const auto status = gyrotherm_with("status --verify " + record);
  EXPECT_EQ(status.exit_code, 0) << status.err;
  EXPECT_EQ(status.out.find("by the guard"), std::string::npos) << status.out;
}

TEST(Run, NeverOverwritesRecord) {
  const Folder folder;
  std::ofstream(folder / "run.db") << "precious";
  const auto ran = gyrotherm_with("run tests/profiles/short-rate.toml --rig profiles/rigs/virtual.toml --out " +
                                  (folder / "run.db"));
  EXPECT_EQ(ran.exit_code, 4) << ran.err;
  EXPECT_EQ(shell("cat " + (folder / "run.db")).out, "precious");
}

/// Record and its model, which no command may overwrite.
class Force : public testing::Test {
 protected:
  void SetUp() override { make_small_model(folder_); }
  void expect_refused(const std::string& command, const std::string& out) const {
    const auto before = read_text_file(folder_ / "record.db", kLargestTable);
    ASSERT_TRUE(before);
    const auto ran = shell("cd " + (folder_ / ".") + " && gyrotherm " + command + " --force " + out);
    EXPECT_EQ(ran.exit_code, 2) << command << " " << out << "\n" << ran.err;
    EXPECT_NE(ran.err.find("a record is never overwritten"), std::string::npos) << command << " " << out << ran.err;
    const auto after = read_text_file(folder_ / "record.db", kLargestTable);
    EXPECT_TRUE(after && *after == *before) << command << " " << out;
  }
  const Folder folder_;
};

TEST(Train, LimitsThreadsToThoseOfMachine) {
  const Folder folder;
  make_small_model(folder);
  const auto train = "train " + (folder / "record.db") + " --inputs A --method linear --threads ";
  const auto one = gyrotherm_with(train + "1 --out " + (folder / "one.json"));
  for (const auto* threads : {"100", "2147483647"}) {
    const auto many = gyrotherm_with(train + threads + " --force --out " + (folder / "many.json"));
    EXPECT_EQ(many.exit_code, 0) << threads;
    EXPECT_EQ(many.err, one.err) << threads;
    EXPECT_EQ(read_text_file(folder / "many.json").value(), read_text_file(folder / "one.json").value()) << threads;
  }
}

TEST(Export, TakesFormatFromEnding) {
  const Folder folder;
  make_small_model(folder);
  const auto begins_with = [&](const std::string& file, std::string_view beginning) {
    return read_text_file(folder / file, std::size_t{1} << 24).value().starts_with(beginning);
  };
  const auto exported = [&](const std::string& arguments) {
    return gyrotherm_with("export " + (folder / "record.db") + " --out " + (folder / arguments));
  };
  for (const auto* file : {"a.nc", "a.nc4", "A.NC", "a.Nc4"}) {
    EXPECT_EQ(exported(file).exit_code, 0);
    EXPECT_TRUE(begins_with(file, "\x89HDF")) << file;
  }
  for (const auto* arguments : {"b.csv", "b.txt", "b.dat --as csv", "b"}) {
    EXPECT_EQ(exported(arguments).exit_code, 0) << arguments;
    EXPECT_TRUE(begins_with(std::string(arguments).substr(0, std::string(arguments).find(' ')), "#")) << arguments;
  }
  EXPECT_EQ(exported("c.gp").exit_code, 0);
  EXPECT_EQ(exported("d.any --as netcdf").exit_code, 0);
  EXPECT_TRUE(begins_with("d.any", "\x89HDF"));
  for (const auto* other : {"e.svg", "e.mat", "e.json", "e.PDF", "e.Svg", "e.XLSX", "e.ods"})
    EXPECT_NE(exported(other).err.find("file can be written; "), std::string::npos) << other;
  EXPECT_NE(exported("e.db").err.find("ends in .db, as a record does"), std::string::npos);
  for (const auto* arguments :
       {"e.nc --as csv", "e.NC --as csv", "e.csv --as netcdf", "e.csv --as gnuplot", "e.gp --as netcdf"}) {
    const auto refused = exported(arguments);
    EXPECT_EQ(refused.exit_code, 2) << arguments;
    EXPECT_NE(refused.err.find("has the ending of --as "), std::string::npos) << refused.err;
  }
  EXPECT_FALSE(std::filesystem::exists(folder / "e.nc"));
}

TEST_F(Force, NeverOverwritesRecord) {
  for (const auto* command :
       {"export record.db", "export record.db --as netcdf", "export record.db --compensated --model model.json",
        "train record.db --inputs A --method linear", "reduce model.json record.db --keep 3", "type-prior record.db",
        "export-model model.json --as libsvm", "export-model model.json --as libsvm --data record.db",
        "fuse record.db --models ."})
    expect_refused(command, "--out record.db");
  expect_refused("fuse record.db --models .", "--export-c record.db");
}

TEST_F(Force, NeverOverwritesFilesOfRecord) {
  ASSERT_EQ(shell("cd " + (folder_ / ".") +
                  " && cp record.db record.2.db && ln -s record.db link.csv"
                  " && touch record.db-wal record.db.status record.db.sha256"
                  " run.csv.socket soak.csv.safe-state && ln -s record.live.db.1 record.live.db")
                .exit_code,
            0);
  for (const auto* out : {"record.2.db", "link.csv", "record.db-wal", "record.db.status", "record.db.sha256", "run.csv",
                          "soak.csv", "record.live.db"})
    expect_refused("export record.db", std::string("--out ") + out);
  const auto other = gyrotherm_with("export-model " + (folder_ / "model.json") + " --as libsvm --force --out " +
                                    (folder_ / "map.toml"));
  EXPECT_EQ(other.exit_code, 0) << "a file that is not a record is overwritten: " << other.err;
}

}  // namespace
}  // namespace gyrotherm::app
