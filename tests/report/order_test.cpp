// SPDX-License-Identifier: Apache-2.0
#include "report/order.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "analysis/data/dataset.hpp"
#include "tests/support/sample_calibration.hpp"

namespace gyrotherm::report {
namespace {

constexpr const char* kLaboratory = R"(schema = "gyrotherm-laboratory/1"
name = "House of Gyros"
city = "Berlin"
country = "DE"
traceability = { en = "To the SI.", de = "Auf das SI." }
[[person]]
name = "B. Berg"
role = "authorising"
)";

constexpr const char* kOrder = R"(schema = "gyrotherm-order/1"
number = "C-1"
received = "2026-11-02"
issued = "2026-11-25"
method = "Ramps and soaks"
decision_rule = "guard_band"
[customer]
name = "Navigation <script>alert(1)</script> \"Works\" 航海"
city = "Hamburg"
[[unit]]
model = "RLG-1"
serial_number = "0042"
condition = "no damage"
[[person]]
name = "K. Kurz"
role = "operator"
[[limit]]
quantity = "compensated_mean.compensated_bias"
stage = "as_left"
at_most = 0.01
)";

CalibrationReport report_without_order() {
  CalibrationReport report = sample_calibration();
  report.state = ReportState::draft;
  report.item.name = "gyro";
  report.people.clear();
  report.conformity.clear();
  report.traceability = {};
  report.missing.clear();
  return report;
}

TEST(Order, CompletesReport) {
  const auto laboratory = parse_laboratory(kLaboratory, "laboratory.toml");
  const auto order = parse_order(kOrder, "order.toml");
  ASSERT_TRUE(laboratory) << text(laboratory.error());
  ASSERT_TRUE(order) << text(order.error());
  CalibrationReport report = report_without_order();
  add_order(report, *laboratory, *order);
  EXPECT_TRUE(report.missing.empty()) << report.missing.front();
  EXPECT_EQ(report.number, "C-1");
  EXPECT_EQ(report.customer.name, "Navigation <script>alert(1)</script> \"Works\" 航海");
  EXPECT_EQ(report.traceability.de, "Auf das SI.");
  EXPECT_EQ(report.method.de, "Ramps and soaks");
  ASSERT_EQ(report.conformity.size(), 2u) << "one statement per axis as left";
  EXPECT_EQ(report.conformity[0].verdict, Verdict::pass);
}

TEST(Order, ListsEachMissingField) {
  std::string without = kOrder;
  without.erase(without.find("issued = \"2026-11-25\"\n"), 22);
  const auto order = parse_order(without, "order.toml");
  ASSERT_TRUE(order);
  CalibrationReport report = report_without_order();
  report.begun.clear();
  report.ended.clear();
  add_order(report, std::nullopt, *order);
  const auto lacks = [&](const char* what) {
    return std::ranges::any_of(report.missing, [&](const std::string& one) { return one.starts_with(what); });
  };
  EXPECT_TRUE(lacks("order.toml: issued"));
  EXPECT_TRUE(lacks("records: start times")) << "an imported record may have no start time";
  EXPECT_TRUE(lacks("laboratory.toml: traceability"));
  EXPECT_FALSE(lacks("order.toml: customer.name"));
}

TEST(Order, RequiresDateAndVerifiedChainOfEachRecord) {
  const auto order = parse_order(kOrder, "order.toml");
  const auto laboratory = parse_laboratory(kLaboratory, "laboratory.toml");
  ASSERT_TRUE(order && laboratory);
  const auto missing = [&](std::vector<UsedFile> files) {
    CalibrationReport report = report_without_order();
    report.files = std::move(files);
    add_order(report, *laboratory, *order);
    return report.missing;
  };
  const UsedFile good{
      .role = "record", .name = "A.db", .started_utc = "2026-03-01 10:00:00 UTC", .chain_verified = true};
  auto undated = good, changed = good;
  undated.name = "B.db";
  undated.started_utc.clear();
  changed.name = "C.db";
  changed.chain_verified = false;
  const UsedFile model{.role = "model_left", .name = "m.json"};
  EXPECT_TRUE(missing({good, model}).empty());
  ASSERT_EQ(missing({good, undated}).size(), 1U);
  EXPECT_TRUE(missing({good, undated}).front().starts_with("records: start time of B.db; "));
  EXPECT_EQ(missing({changed, good}), std::vector<std::string>{"records: verified hash chain of C.db"});
}

TEST(Order, RequiresCertificateOfThermometer) {
  const auto order = parse_order(kOrder, "order.toml");
  ASSERT_TRUE(order);
  const auto missing = [&](const std::string& more, bool simulated, const char* certificate) {
    const auto laboratory = parse_laboratory(std::string(kLaboratory) + more, "laboratory.toml");
    EXPECT_TRUE(laboratory) << text(laboratory.error());
    CalibrationReport report = report_without_order();
    report.simulated = simulated;
    report.equipment.front().certificate = certificate;
    add_order(report, *laboratory, *order);
    return report.missing;
  };
  EXPECT_TRUE(missing("", false, "2026-0123").empty());
  EXPECT_TRUE(missing("", true, "").empty());
  ASSERT_EQ(missing("", false, "").size(), 1U);
  EXPECT_TRUE(missing("", false, "").front().starts_with("records: certificate of a thermometer"));
  const std::string table = "[[equipment]]\nname = \"Granite table\"\ncertificate = \"L-17\"\n";
  EXPECT_EQ(missing(table, false, "").size(), 1U) << "a certificate of another instrument";
  EXPECT_TRUE(missing(table + "role = \"thermometer\"\n", false, "").empty());
  EXPECT_FALSE(parse_laboratory(std::string(kLaboratory) + table + "role = \"chamber\"\n", "laboratory.toml"));
}

TEST(Order, RequiresCertificateOfEachThermometerOfResults) {
  const auto order = parse_order(kOrder, "order.toml");
  const auto laboratory = parse_laboratory(kLaboratory, "laboratory.toml");
  ASSERT_TRUE(order && laboratory);
  const auto missing = [&](std::vector<std::string> block, std::string channel) {
    CalibrationReport report = report_without_order();
    report.simulated = false;
    report.block_thermometers = std::move(block);
    auto other = report.equipment.front();
    report.equipment = {other};
    report.equipment.front().channel = std::move(channel);
    other.channel = "H";
    other.certificate.clear();
    report.equipment.push_back(other);
    add_order(report, *laboratory, *order);
    return report.missing;
  };
  EXPECT_TRUE(missing({"A"}, "A").empty()) << "H is not used";
  EXPECT_TRUE(missing({"A", "H"}, "").empty()) << "covers all channels";
  ASSERT_EQ(missing({"A", "H", "C"}, "A").size(), 1U);
  EXPECT_TRUE(missing({"A", "H", "C"}, "A").front().starts_with("records: certificate of a thermometer: H, C; "));
  EXPECT_EQ(missing({}, "A").size(), 1U) << "all channels may have been used";
}

TEST(Order, ListsPersonsWithoutConfirmedRole) {
  const auto missing = [](const std::string& laboratory_people, const std::string& order_people) {
    const std::string head = std::string(kLaboratory).substr(0, std::string(kLaboratory).find("[[person]]"));
    const std::string order_head = std::string(kOrder).substr(0, std::string(kOrder).find("[[person]]"));
    const auto laboratory = parse_laboratory(head + laboratory_people, "laboratory.toml");
    const auto order = parse_order(order_head + order_people, "order.toml");
    CalibrationReport report = report_without_order();
    add_order(report, laboratory.value(), order.value());
    return report.missing;
  };
  const auto person = [](const std::string& name, const std::string& role) {
    return "[[person]]\nname = \"" + name + "\"\nrole = \"" + role + "\"\n";
  };
  const auto refused = [](const std::string& name, const std::string& role) {
    return std::vector<std::string>{"laboratory.toml: person \"" + name + "\" with role \"" + role +
                                    "\", whom order.toml names"};
  };
  const std::string berg = person("B. Berg", "authorising"), kurz = person("K. Kurz", "operator");
  EXPECT_TRUE(missing(berg, kurz).empty());
  EXPECT_TRUE(missing(berg + kurz, kurz + berg).empty());
  EXPECT_EQ(missing(berg, kurz + person("M. Mouse", "authorising")), refused("M. Mouse", "authorising"));
  EXPECT_EQ(missing("", kurz + berg), refused("B. Berg", "authorising"));
  EXPECT_EQ(missing(berg, person("B. Berg", "operator") + person("K. Kurz", "authorising")),
            refused("K. Kurz", "authorising"));
  EXPECT_EQ(missing(berg + kurz, person("M. Mouse", "operator")), refused("M. Mouse", "operator"));
  EXPECT_EQ(missing(berg + person("R. Roth", "reviewer"), kurz + person("K. Kurz", "reviewer")),
            refused("K. Kurz", "reviewer"));
  EXPECT_EQ(missing("", kurz), std::vector<std::string>{"laboratory.toml: person with role \"authorising\""});
}

/// The persons of a role in the order replace those of the laboratory; nobody is listed twice.
TEST(Order, ReplacesPersonsOfLaboratoryByRole) {
  const auto people = [](const std::string& laboratory_people, const std::string& order_people) {
    const auto head = [](const std::string& text) { return text.substr(0, text.find("[[person]]")); };
    const auto laboratory = parse_laboratory(head(kLaboratory) + laboratory_people, "laboratory.toml");
    const auto order = parse_order(head(kOrder) + order_people, "order.toml");
    CalibrationReport report = report_without_order();
    add_order(report, laboratory.value(), order.value());
    std::vector<std::string> all;
    for (const Person& person : report.people)
      all.push_back(person.name + ", " + person.role + (person.email.empty() ? "" : ", " + person.email));
    return all;
  };
  const auto person = [](const std::string& name, const std::string& role, const std::string& email = "") {
    return "[[person]]\nname = \"" + name + "\"\nrole = \"" + role + "\"\nemail = \"" + email + "\"\n";
  };
  using Names = std::vector<std::string>;
  const std::string berg = person("Berg", "authorising"), kurz = person("Kurz", "operator"),
                    roth = person("Roth", "reviewer"), zorn = person("Zorn", "operator");
  EXPECT_EQ(people(berg + roth + kurz, kurz + roth), (Names{"Berg, authorising", "Roth, reviewer", "Kurz, operator"}));
  EXPECT_EQ(people(berg + roth + kurz + zorn, kurz), (Names{"Berg, authorising", "Roth, reviewer", "Kurz, operator"}));
  EXPECT_EQ(people(berg + kurz + zorn, ""), (Names{"Berg, authorising", "Kurz, operator", "Zorn, operator"}));
  EXPECT_EQ(people(berg, kurz + kurz), (Names{"Berg, authorising", "Kurz, operator"}));
  EXPECT_EQ(people(berg + person("Dill", "authorising"), berg + kurz),
            (Names{"Berg, authorising", "Dill, authorising", "Kurz, operator"}));
  EXPECT_EQ(people(berg + person("Kurz", "operator", "k@lab.de"), kurz),
            (Names{"Berg, authorising", "Kurz, operator, k@lab.de"}));
  EXPECT_EQ(people(berg + kurz, person("Kurz", "reviewer")),
            (Names{"Berg, authorising", "Kurz, operator", "Kurz, reviewer"}));
}

TEST(Order, ReadsDeviationAndEquipmentInBothLanguages) {
  const auto laboratory = parse_laboratory(
      std::string(kLaboratory) + "[[equipment]]\nname = { en = \"Granite table\", de = \"Granittisch\" }\n", "l.toml");
  const auto order = parse_order(std::string(kOrder) +
                                     "[[deviation]]\ntext = { de = \"Tür offen\" }\n"
                                     "[[deviation]]\ntext = \"door open\"\n",
                                 "o.toml");
  ASSERT_TRUE(laboratory && order);
  EXPECT_EQ(laboratory->equipment.front().name, "Granite table");
  EXPECT_EQ(laboratory->equipment.front().names.de, "Granittisch");
  EXPECT_EQ(order->deviations[0].text, "Tür offen");
  EXPECT_EQ(order->deviations[0].kind, "stated");
  EXPECT_TRUE(order->deviations[1].translations.empty());
  for (const char* wrong : {"text = {}\n", "text = 3\n", ""})
    EXPECT_FALSE(parse_order(std::string(kOrder) + "[[deviation]]\nutc = \"\"\n" + wrong, "o.toml")) << wrong;
}

/// A simulated report has the same contradictions, which are printed and are not missing.
TEST(Order, FindsWrongDaysOfSimulatedReport) {
  CalibrationReport report;
  report.received = "2026-01-03";
  report.begun = "2026-01-01";
  report.ended = "2026-01-04";
  report.issued = "2026-01-02";
  for (const bool simulated : {false, true}) {
    report.simulated = simulated;
    EXPECT_EQ(find_wrong_days(report).size(), 3U);
  }
  report.issued = report.received = "";
  EXPECT_TRUE(find_wrong_days(report).empty());
}

TEST(Order, FindsDaysThatContradictAuthorisation) {
  CalibrationReport report;
  report.ended = "2026-11-20";
  report.issued = "2026-11-25";
  const auto count = [&](const char* now_utc) { return find_days_against_authorisation(report, now_utc).size(); };
  EXPECT_EQ(count("2026-11-19T23:59:59Z"), 1U) << "the calibration has not ended";
  EXPECT_EQ(count("2026-11-20T00:00:00Z"), 0U);
  EXPECT_EQ(count("2026-11-26T23:59:59Z"), 0U) << "the day of issue is in local time";
  EXPECT_EQ(count("2026-11-27T00:00:00Z"), 1U) << "after the day of issue";
  report.issued = "2026-12-21";
  EXPECT_EQ(count("2026-11-20T12:00:00Z"), 0U) << "31 days ahead";
  report.issued = "2026-12-22";
  EXPECT_EQ(count("2026-11-20T12:00:00Z"), 1U);
  report.ended = "2027-01-05";
  EXPECT_EQ(count("2026-11-20T12:00:00Z"), 2U);
  report.ended = report.issued = "";
  EXPECT_EQ(count("2026-11-20T12:00:00Z"), 0U) << "missing days are reported by add_order()";
}

TEST(Order, PermitsOnlyAuthorisingPersons) {
  CalibrationReport report = report_without_order();
  report.people = {{"B. Berg", "authorising", ""}, {"K. Kurz", "operator", ""}, {"R. Roth", "reviewer", ""}};
  EXPECT_TRUE(check_may_authorise(report.people, "B. Berg"));
  for (const char* other : {"Mickey Mouse", "K. Kurz", "R. Roth", "b. berg", "B. Berg ", "authorising", ""}) {
    const auto refused = check_may_authorise(report.people, other);
    ASSERT_FALSE(refused) << other;
    EXPECT_EQ(refused.error().kind, FaultKind::usage);
    EXPECT_EQ(refused.error().where, "--by");
  }
  report.people.push_back({"K. Kurz", "authorising", ""});
  EXPECT_TRUE(check_may_authorise(report.people, "K. Kurz"));
}

TEST(Order, IsRefusedWithEachErrorAndItsPosition) {
  std::string wrong = kOrder;
  wrong.replace(wrong.find("2026-11-02"), 10, "2026-13-02");
  wrong.replace(wrong.find("at_most = 0.01"), 14, "at_most = -1.0");
  for (const char* utc : {"2026-11-20T10:00:00+01:00", "2026-11-20", "2026-02-30T10:00:00Z"})
    wrong += fmt::format("[[deviation]]\nutc = \"{}\"\ntext = \"door opened\"\n", utc);
  const auto order = parse_order(wrong, "order.toml");
  ASSERT_FALSE(order);
  const std::string said = text(order.error());
  EXPECT_NE(said.find("order.toml:3:"), std::string::npos) << said;
  EXPECT_NE(said.find("is not a date"), std::string::npos) << said;
  EXPECT_NE(said.find("above 0"), std::string::npos) << said;
  for (const char* utc : {"order.toml:22:7: \"2026-11-20T10:00:00+01:00\"", "order.toml:25:7: \"2026-11-20\"",
                          "order.toml:28:7: \"2026-02-30T10:00:00Z\""})
    EXPECT_NE(said.find(fmt::format("{}, expected a UTC time", utc)), std::string::npos) << said;
}

TEST(Order, RefusesRepeatedLimitsAndInvalidTexts) {
  const std::string limit = "[[limit]]\nquantity = \"compensated_mean.compensated_bias\"\nat_most = 0.02\n";
  const auto error_of = [](const std::string& more, const std::string& customer = "") {
    std::string order = std::string(kOrder) + more;
    if (!customer.empty()) order.insert(order.find("city = \"Hamburg\""), customer);
    const auto parsed = parse_order(order, "order.toml");
    return parsed ? "" : parsed.error().what;
  };
  EXPECT_EQ(error_of(limit), "") << "another stage";
  EXPECT_EQ(error_of(limit + limit), "duplicate limit of \"compensated_mean.compensated_bias\"");
  EXPECT_EQ(error_of(limit + "stage = \"as_left\"\n"),
            "duplicate limit of \"compensated_mean.compensated_bias\" in this stage");
  const auto replacing = [&](const std::string& digest) {
    return error_of("[replaces]\nnumber = \"C-0\"\nreason = \"late\"\nsha256 = \"" + digest + "\"\n");
  };
  EXPECT_EQ(replacing(std::string(64, 'a')), "");
  for (const auto& digest : {std::string("abc"), std::string(63, '0') + "g", std::string(65, '0')})
    EXPECT_NE(replacing(digest).find("expected 64 hexadecimal digits"), std::string::npos) << digest;
  EXPECT_EQ(error_of("", "email = \"lab@example.org\"\n"), "");
  for (const char* address : {"lab", "@example.org", "lab@", "lab @example.org"})
    EXPECT_NE(error_of("", fmt::format("email = \"{}\"\n", address)).find("is not an e-mail address"),
              std::string::npos)
        << address;
}

TEST(Order, ReadsDigestOfReplacedReportInLowerCase) {
  const auto order = parse_order(std::string(kOrder) + "[replaces]\nnumber = \"C-0\"\nreason = \"late\"\nsha256 = \"" +
                                     std::string(60, 'A') + "0fE9\"\n",
                                 "order.toml");
  ASSERT_TRUE(order) << text(order.error());
  EXPECT_EQ(order->replaces->sha256, std::string(60, 'a') + "0fe9");
}

TEST(Laboratory, RefusesDueDayBeforeCalibration) {
  const auto error_of = [](const std::string& due) {
    const auto parsed = parse_laboratory(
        std::string(kLaboratory) + "[[equipment]]\nname = \"A\"\ncalibrated = \"2026-03-01\"\ndue = \"" + due + "\"\n",
        "laboratory.toml");
    return parsed ? "" : parsed.error().what;
  };
  EXPECT_EQ(error_of("2027-03-01"), "");
  EXPECT_EQ(error_of("2025-03-01"), "is before \"calibrated\", 2026-03-01");
}

TEST(Order, SkipsLimitsForInSampleResults) {
  CalibrationReport report = report_without_order();
  for (ResultTable& table : report.results) table.in_sample = table.stage == Stage::as_left;
  apply_limits(report, {{.quantity = "compensated_mean.compensated_bias", .stage = Stage::as_left, .at_most = 0.01}},
               DecisionRule::simple);
  ASSERT_EQ(report.conformity.size(), 1u);
  EXPECT_EQ(report.conformity[0].verdict, Verdict::not_known);
  add_order(report, std::nullopt, std::nullopt);
  EXPECT_NE(std::ranges::find(report.missing, "records: a record that the model was not trained on"),
            report.missing.end());
}

TEST(Order, RequiresUnseenRecordPerAxis) {
  CalibrationReport report = report_without_order();
  for (ResultTable& table : report.results) table.in_sample = table.axis == "u1.y" && table.stage == Stage::as_left;
  add_order(report, std::nullopt, std::nullopt);
  EXPECT_NE(std::ranges::find(report.missing, "records: a record that the model was not trained on"),
            report.missing.end());
}

TEST(Order, SuggestsResultForUnknownLimit) {
  const auto refused = [](const std::string& quantity) {
    std::string wrong = kOrder;
    wrong.replace(wrong.find("compensated_mean.compensated_bias"), 33, quantity);
    const auto order = parse_order(wrong, "order.toml");
    return order ? "" : text(order.error());
  };
  EXPECT_EQ(refused("stabilised_bias.bias"), "");
  EXPECT_EQ(refused("stabilised_bias.bais"),
            "order.toml:18:12: unknown result \"stabilised_bias.bais\", did you mean \"stabilised_bias.bias\"?");
  EXPECT_EQ(refused("coverage.seen_share"),
            "order.toml:18:12: \"coverage.seen_share\" cannot have a limit: limits are upper limits, and larger values "
            "of it are better");
  for (const char* quantity : {"nothing", "stabilised_bias", "bias.rmse", "heading.results", "."})
    EXPECT_NE(refused(quantity).find("unknown result"), std::string::npos) << quantity;
}

TEST(Order, IsRefusedWhenUnitDiffersFromRecord) {
  const auto order = parse_order(kOrder, "order.toml");
  ASSERT_TRUE(order);
  const auto refused = [&](const std::string& model, const std::string& serial_number) {
    const auto same =
        check_units(*order, {{.name = "gyro", .model = model, .serial_number = serial_number}}, "rate.db");
    return same ? "" : text(same.error());
  };
  EXPECT_EQ(refused("", ""), "");
  EXPECT_EQ(refused("RLG-1", "0042"), "");
  EXPECT_EQ(
      refused("RLG-1", "0043"),
      "order.toml:10:1: the unit's serial_number is \"0042\", but rate.db contains \"0043\"; remove it from the order");
  EXPECT_NE(refused("RLG-2", ""), "");
  CalibrationReport report = report_without_order();
  report.item.model = "RLG-2";
  report.item.serial_number = "";
  add_order(report, std::nullopt, *order);
  EXPECT_EQ(report.item.model, "RLG-2");
  EXPECT_EQ(report.item.serial_number, "0042");
}

TEST(Order, RequiresUnitNamesForSeveralUnits) {
  const auto order = parse_order(kOrder, "order.toml");
  ASSERT_TRUE(order);
  const auto refused = check_units(*order, {{.name = "u1"}, {.name = "u2"}}, "lot.db");
  ASSERT_FALSE(refused) << "both units would have the identity 0042";
  EXPECT_EQ(text(refused.error()),
            "order.toml:10:1: the unit has no name although lot.db has several units, expected one of u1, u2");
  std::string named = kOrder;
  named.insert(named.find("model = "), "name = \"u2\"\n");
  EXPECT_TRUE(check_units(*parse_order(named, "order.toml"), {{.name = "u1"}, {.name = "u2"}}, "lot.db"));
}

constexpr const char* kLot = R"(schema = "gyrotherm-order/1"
number = "2026-17"
serial_numbers = ["0042", " 0043 "]
[customer]
name = "Navigation Works"
[[unit]]
serial_number = "0050"
model = "RLG-2"
[[unit]]
name = "u7"
serial_number = "0057"
[[unit]]
name = "u8"
)";

TEST(Order, ListsUnitsBySerialNumber) {
  const auto order = parse_order(kLot, "order.toml");
  ASSERT_TRUE(order) << text(order.error());
  ASSERT_EQ(order->units.size(), 5u);
  EXPECT_EQ(order->units[3].item.serial_number, "0042");
  EXPECT_EQ(order->units[4].item.serial_number, "0043") << "without blanks around it";
  const auto checked = [&](std::vector<CalibratedItem> items) {
    const auto same = check_units(*order, items, "lot.db");
    return same ? "" : text(same.error());
  };
  EXPECT_EQ(checked({{.name = "u1", .serial_number = "0043"},
                     {.name = "u2", .model = "RLG-2", .serial_number = "0050"},
                     {.name = "u7", .serial_number = "0057"},
                     {.name = "u8", .serial_number = "0099"}}),
            "");
  EXPECT_EQ(checked({{.name = "u1", .serial_number = "0044"}}),
            "order.toml:6:1: the order does not contain the serial number \"0044\" of u1 in lot.db");
  EXPECT_EQ(checked({{.name = "u1", .serial_number = "43"}}),
            "order.toml:6:1: the order does not contain the serial number \"43\" of u1 in lot.db")
      << "leading zeros count";
  EXPECT_EQ(checked({{.name = "u1", .model = "RLG-1", .serial_number = "0050"}}),
            "order.toml:6:1: the unit's model is \"RLG-2\", but lot.db contains \"RLG-1\"; remove it from the order");
  EXPECT_EQ(checked({{.name = "u1", .serial_number = "0057"}}),
            "order.toml:9:1: the unit 0057 is \"u7\", but in lot.db it is \"u1\"; correct the name in the order");
  EXPECT_NE(checked({{.name = "u7", .serial_number = "0058"}}).find("\"0057\", but lot.db contains \"0058\""),
            std::string::npos);
}

TEST(Order, NumbersReportsOfLotBySerialNumber) {
  const auto order = parse_order(kLot, "order.toml");
  ASSERT_TRUE(order) << text(order.error());
  CalibrationReport report = report_without_order();
  report.item = {.name = "u1", .serial_number = "0050"};
  add_order(report, std::nullopt, *order);
  EXPECT_EQ(report.number, "2026-17-0050") << "the next run has another unit at u1";
  EXPECT_EQ(report.item.model, "RLG-2");
  report.item = {.name = "u7", .serial_number = "0057"};
  add_order(report, std::nullopt, *order);
  EXPECT_EQ(report.number, "2026-17-0057") << "a unit with a name and a serial number";
  report.item = {.name = "u7"};
  add_order(report, std::nullopt, *order);
  EXPECT_EQ(report.number, "2026-17-0057") << "the serial number of the order";
  report.item = {.name = "u8"};
  add_order(report, std::nullopt, *order);
  EXPECT_EQ(report.number, "2026-17-u8");
}

/// The record has the units x, y and z; the order lists no unit, or one of them.
TEST(Order, NumbersEachReportOfRecordWithSeveralUnits) {
  const auto number = [](const std::string& unit, const CalibratedItem& item, std::size_t units) {
    const auto order =
        parse_order("schema = \"gyrotherm-order/1\"\nnumber = \"C-44\"\n[customer]\n" + unit, "order.toml");
    EXPECT_TRUE(order) << text(order.error());
    CalibrationReport report = report_without_order();
    report.item = item;
    add_order(report, std::nullopt, *order, units);
    return report.number;
  };
  EXPECT_EQ(number("", {.name = "x", .serial_number = "V1"}, 3), "C-44-V1");
  EXPECT_EQ(number("", {.name = "y", .serial_number = "V2"}, 3), "C-44-V2");
  EXPECT_EQ(number("", {.name = "z"}, 3), "C-44-z");
  EXPECT_EQ(number("", {.name = "gyro", .serial_number = "V1"}, 1), "C-44") << "one unit";
  const std::string only_x = "[[unit]]\nname = \"x\"\n", only_v1 = "[[unit]]\nserial_number = \"V1\"\n";
  EXPECT_EQ(number(only_x, {.name = "x"}, 3), "C-44") << "the order is for this unit only";
  EXPECT_EQ(number(only_v1, {.name = "x", .serial_number = "V1"}, 3), "C-44");
  EXPECT_EQ(number(only_x, {.name = "y"}, 3), "C-44-y");
}

TEST(Order, RefusesInvalidAndDuplicateSerialNumbers) {
  const auto refused = [](const std::string& list, const std::string& unit) {
    const auto order = parse_order("schema = \"gyrotherm-order/1\"\n" + list +
                                       "[customer]\nname = \"N\"\n[[unit]]\nserial_number = \"" + unit + "\"\n",
                                   "order.toml");
    return order ? "" : text(order.error());
  };
  EXPECT_EQ(refused("serial_numbers = [\"1\", \"2\"]\n", "3"), "");
  EXPECT_EQ(refused("serial_numbers = [\"1\", \"1\"]\n", "3"), "order.toml:2:18: duplicate serial number 1");
  EXPECT_EQ(refused("serial_numbers = [\"3\"]\n", "3"), "order.toml:2:18: duplicate serial number 3");
  EXPECT_NE(refused("serial_numbers = [\"\"]\n", "3").find("order.toml:2:18: a serial number is empty"),
            std::string::npos);
  EXPECT_NE(refused("", "3\\u001d4").find("order.toml:5:17: a serial number \"3\\x1d4\" contains"), std::string::npos)
      << refused("", "3\\u001d4");
  EXPECT_NE(refused("", std::string(65, '3')).find("has 65 bytes, expected at most 64"), std::string::npos);
}

TEST(Order, ComparesEachRowWithLimit) {
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  const auto worst = [](std::vector<ReportedValue> values, DecisionRule rule) {
    CalibrationReport report;
    report.results = {{.key = "stabilised_bias", .columns = {{"bias", "°/h", std::move(values)}}}};
    apply_limits(report, {{.quantity = "stabilised_bias.bias", .at_most = 1}}, rule);
    return report.conformity.at(0);
  };
  const ReportedValue greatest = value_with_uncertainty(-0.9, 0.01, kInfinite),
                      blurred = value_with_uncertainty(0.8, 0.2, kInfinite),
                      more_blurred = value_with_uncertainty(0.7, 0.4, kInfinite), unknown{.value = 0.1},
                      beyond = value_with_uncertainty(2, 0.1, kInfinite);
  using enum DecisionRule;
  const Conformity conditional = worst({greatest, blurred}, guard_band);
  EXPECT_EQ(conditional.verdict, Verdict::conditional_pass);
  EXPECT_EQ(conditional.value.value, 0.8);
  EXPECT_EQ(worst({blurred, more_blurred, greatest}, guard_band).value.value, 0.7)
      << "the least probable value is the worst";
  EXPECT_EQ(worst({greatest, blurred}, simple).value.value, 0.8) << "both pass";
  EXPECT_EQ(worst({greatest, unknown}, guard_band).verdict, Verdict::not_known);
  EXPECT_EQ(worst({unknown, beyond}, guard_band).verdict, Verdict::fail);
  // A row without a value is a hold that failed: the limit must not pass because of the other rows.
  const Conformity failed_row = worst({{}, {.value = -0.2}, greatest}, simple);
  EXPECT_TRUE(std::isnan(failed_row.value.value));
  EXPECT_EQ(failed_row.verdict, Verdict::not_known);
  EXPECT_TRUE(std::isnan(worst({unknown, {}, greatest}, guard_band).value.value));
  EXPECT_EQ(worst({{}, beyond, greatest}, simple).verdict, Verdict::fail) << "a failing row is worse";
}

/// No limit applies to an unknown constant, by either rule; a STD is not affected.
TEST(Order, GivesNoVerdictOnResultWithUnknownZero) {
  const CalibrationReport sample = sample_calibration();
  const auto verdicts = [&](const char* quantity, double at_most, DecisionRule rule, bool only_last_record) {
    CalibrationReport report = sample;
    report.conformity.clear();
    if (only_last_record) {
      report.bias_zeros = {{report.results.back().axis, report.results.back().run, std::string(data::kOwnReference)}};
    } else {
      report.bias_zero = data::kOwnReference;
    }
    apply_limits(report, {{.quantity = quantity, .at_most = at_most}}, rule);
    EXPECT_FALSE(report.conformity.empty());
    std::set<Verdict> found;
    for (const Conformity& one : report.conformity) {
      found.insert(one.verdict);
      EXPECT_TRUE(std::isfinite(one.value.value));
      if (one.verdict == Verdict::not_known) {
        EXPECT_TRUE(std::isnan(one.probability));
        EXPECT_TRUE(std::isnan(one.value.expanded()));
      }
    }
    return found;
  };
  for (const DecisionRule rule : {DecisionRule::simple, DecisionRule::guard_band}) {
    for (const char* quantity : {"compensated_mean.compensated_bias", "whole_run.rmse", "stabilised_bias.bias"})
      for (const double at_most : {1e-9, 1e9})
        EXPECT_EQ(verdicts(quantity, at_most, rule, false), std::set{Verdict::not_known}) << quantity;
    EXPECT_EQ(verdicts("whole_run.std", 1e9, rule, false), std::set{Verdict::pass});
    const auto failed = verdicts("whole_run.std", 1e-9, rule, false);
    EXPECT_TRUE(failed.contains(Verdict::fail));
    EXPECT_FALSE(failed.contains(Verdict::pass) || failed.contains(Verdict::not_known));
    EXPECT_TRUE(verdicts("whole_run.rmse", 1e9, rule, true).contains(Verdict::pass)) << "records with a known zero";
  }
}

/// The units are those of the results of the sample report.
TEST(Order, GivesLimitWithoutResultItsUnit) {
  const auto unit_of = [](const CalibrationReport& results, const std::string& quantity) {
    CalibrationReport report = results;
    report.conformity.clear();
    apply_limits(report, {{.quantity = quantity, .at_most = 1}}, DecisionRule::simple);
    return report.conformity.at(0).unit;
  };
  const CalibrationReport sample = sample_calibration();
  for (const char* quantity :
       {"stabilised_bias.bias", "warm_up.duration", "temperature_sensitivity.temperature_sensitivity",
        "gradient_sensitivity.gradient_sensitivity", "angle_random_walk.angle_random_walk", "whole_run.rmse"})
    EXPECT_EQ(unit_of({}, quantity), unit_of(sample, quantity)) << quantity;
  EXPECT_EQ(unit_of({}, "ramp_sensitivity.ramp_sensitivity"), "°/h/(K/min)");
  EXPECT_EQ(unit_of({}, "quantisation.quantisation"), "″");
}

TEST(Order, GivesLimitWithoutResultOneRowPerStage) {
  const auto stages_of = [](CalibrationReport report, std::optional<Stage> stage) {
    report.conformity.clear();
    apply_limits(report, {{.quantity = "ramp_sensitivity.ramp_sensitivity", .stage = stage, .at_most = 1}},
                 DecisionRule::simple);
    std::vector<Stage> stages;
    for (const Conformity& one : report.conformity) {
      EXPECT_EQ(one.verdict, Verdict::not_known);
      stages.push_back(one.stage);
    }
    return stages;
  };
  CalibrationReport report = sample_calibration();
  EXPECT_EQ(stages_of(report, {}), (std::vector{Stage::uncompensated, Stage::as_found, Stage::as_left}));
  EXPECT_EQ(stages_of(report, Stage::as_left), std::vector{Stage::as_left}) << "required by the order";
  std::erase_if(report.results, [](const ResultTable& table) { return table.stage != Stage::uncompensated; });
  EXPECT_EQ(stages_of(report, {}), std::vector{Stage::uncompensated});
}

/// A limit passes for an axis only if that axis has a result.
TEST(Order, GivesAxisWithoutResultOwnRow) {
  const auto rows_of = [](const CalibrationReport& results, const char* quantity, std::optional<Stage> stage) {
    CalibrationReport report = results;
    report.conformity.clear();
    apply_limits(report, {{.quantity = quantity, .stage = stage, .at_most = 1e9}}, DecisionRule::simple);
    std::set<std::string> rows;
    for (const Conformity& one : report.conformity)
      rows.insert(fmt::format("{} {} {} {}", one.axis, name(one.stage), name(one.verdict), one.unit));
    return rows;
  };
  using Rows = std::set<std::string>;
  const auto table = [](const char* axis, Stage stage, const char* key, const char* quantity, bool in_sample = false) {
    return ResultTable{.key = key,
                       .axis = axis,
                       .stage = stage,
                       .in_sample = in_sample,
                       .columns = {{quantity, "°/h", {value_with_uncertainty(1, 0.1, 9)}}}};
  };
  using enum Stage;
  CalibrationReport report;
  report.item.axes = {"u1.x", "u1.y"};
  report.results = {table("u1.x", uncompensated, "whole_run", "rmse"), table("u1.x", as_left, "whole_run", "rmse"),
                    table("u1.x", as_left, "compensated_mean", "compensated_bias"),
                    table("u1.y", uncompensated, "whole_run", "rmse")};
  const std::string y_left = "u1.y as_left not_known °/h";
  EXPECT_EQ(rows_of(report, "whole_run.rmse", as_left), (Rows{"u1.x as_left pass °/h", y_left}));
  EXPECT_EQ(rows_of(report, "whole_run.rmse", {}),
            (Rows{"u1.x uncompensated pass °/h", "u1.x as_left pass °/h", "u1.y uncompensated pass °/h", y_left}));
  EXPECT_EQ(rows_of(report, "compensated_mean.compensated_bias", {}), (Rows{"u1.x as_left pass °/h", y_left}))
      << "the uncompensated stage never has this result";
  report.results.push_back(table("u1.y", as_left, "whole_run", "rmse", true));
  EXPECT_EQ(rows_of(report, "whole_run.rmse", as_left), Rows{"u1.x as_left pass °/h"}) << "in-sample";
  report.results.push_back(table("u1.y", as_left, "whole_run", "std"));
  EXPECT_EQ(rows_of(report, "whole_run.std", as_left), (Rows{"u1.y as_left pass °/h", "u1.x as_left not_known °/h"}));
  report.results.push_back(table("u1.x", as_found, "whole_run", "std"));
  EXPECT_EQ(rows_of(report, "whole_run.std", as_found), (Rows{"u1.x as_found pass °/h"})) << "y has no earlier model";
}

TEST(Order, GivesNoRowToNoiseThatIsTooSmallToBeSeen) {
  CalibrationReport report;
  report.item.axes = {"x", "y", "z"};
  const auto add = [&](const char* axis, const char* key) {
    report.results.push_back({.group = Group::random_drift,
                              .key = key,
                              .axis = axis,
                              .stage = Stage::as_left,
                              .columns = {{key, "°/h", {value_with_uncertainty(1, 0.1, 9)}}}});
  };
  add("x", "rate_ramp");
  add("y", "bias_instability");
  apply_limits(report, {{.quantity = "rate_ramp.rate_ramp", .stage = Stage::as_left, .at_most = 9}},
               DecisionRule::simple);
  ASSERT_EQ(report.conformity.size(), 2u);
  EXPECT_EQ(report.conformity[0].axis, "x");
  EXPECT_EQ(report.conformity[0].verdict, Verdict::pass);
  EXPECT_EQ(report.conformity[1].axis, "z") << "its noise was not evaluated";
  EXPECT_EQ(report.conformity[1].verdict, Verdict::not_known);
}

TEST(Order, RequiresDaysInOrder) {
  const auto order = parse_order(kOrder, "order.toml");
  ASSERT_TRUE(order);
  const auto lacks = [&](const char* begun, const char* ended, bool simulated) {
    CalibrationReport report = report_without_order();
    report.simulated = simulated;
    report.begun = begun;
    report.ended = ended;
    add_order(report, std::nullopt, *order);
    std::vector<std::string> days;
    for (const std::string& one : report.missing)
      if (one.find("(UTC)") != std::string::npos) days.push_back(one);
    return days;
  };
  EXPECT_TRUE(lacks("2026-11-02", "2026-11-25", false).empty());
  EXPECT_TRUE(lacks("", "", false).empty());
  EXPECT_EQ(lacks("2026-11-01", "2026-11-26", false),
            (std::vector<std::string>{"order.toml: received, on or before 2026-11-01 (UTC) when the calibration began",
                                      "order.toml: issued, on or after 2026-11-26 (UTC) when the calibration ended"}));
  EXPECT_TRUE(lacks("2026-01-01", "2026-12-31", true).empty()) << "a virtual rig needs no calibration dates";
}

/// The certificate states for each instrument whether its calibration is valid.
TEST(Laboratory, MarksEquipmentOverdueOnDayOfRun) {
  std::string text = kLaboratory;
  for (const char* due : {"2026-11-19", "2026-11-20"})
    text += fmt::format("[[equipment]]\nname = \"until {0}\"\ncertificate = \"L-1\"\ndue = \"{0}\"\n", due);
  const auto laboratory = parse_laboratory(text, "laboratory.toml");
  ASSERT_TRUE(laboratory);
  CalibrationReport report = report_without_order();
  report.equipment.clear();
  report.ended = "2026-11-20";
  add_order(report, *laboratory, std::nullopt);
  ASSERT_EQ(report.equipment.size(), 2u);
  EXPECT_TRUE(report.equipment[0].overdue);
  EXPECT_FALSE(report.equipment[1].overdue);
}

TEST(Laboratory, RequiresCalibrationBeforeEndOfRun) {
  std::string text = kLaboratory;
  for (const char* day : {"2026-11-20", "2026-11-21", "2031-01-01"})
    text += fmt::format("[[equipment]]\nname = \"of {0}\"\ncertificate = \"L-1\"\ncalibrated = \"{0}\"\n", day);
  const auto laboratory = parse_laboratory(text, "laboratory.toml");
  ASSERT_TRUE(laboratory);
  const auto missing = [&](bool simulated) {
    CalibrationReport report = report_without_order();
    report.simulated = simulated;
    report.equipment = {{.role = "thermometer", .channel = "shell", .certificate = "T1", .calibrated = "2027-01-01"}};
    report.ended = "2026-11-20";
    add_order(report, *laboratory, std::nullopt);
    std::erase_if(report.missing,
                  [](const std::string& one) { return one.find("calibrated of") == std::string::npos; });
    return report.missing;
  };
  const std::string rule = ", on or before 2026-11-20 (UTC) when the calibration ended; it is ";
  EXPECT_EQ(missing(false),
            (std::vector<std::string>{"records: calibrated of \"shell\"" + rule + "2027-01-01",
                                      "laboratory.toml: calibrated of \"of 2026-11-21\"" + rule + "2026-11-21",
                                      "laboratory.toml: calibrated of \"of 2031-01-01\"" + rule + "2031-01-01"}));
  EXPECT_TRUE(missing(true).empty()) << "a virtual rig has a time of its own";
}

TEST(Laboratory, RefusesInvalidLogo) {
  const auto missing =
      parse_laboratory(std::string(kLaboratory).insert(34, "logo = \"none.svg\"\n"), "laboratory.toml");
  ASSERT_FALSE(missing);
  EXPECT_NE(text(missing.error()).find("none.svg"), std::string::npos);
}

}  // namespace
}  // namespace gyrotherm::report
