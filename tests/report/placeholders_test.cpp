// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>

#include "core/file.hpp"
#include "report/order.hpp"
#include "tests/support/sample_calibration.hpp"

namespace gyrotherm::report {
namespace {

/// Returns the example on a page that starts with the given schema line.
std::string make_example(const std::string& page, const std::string& schema) {
  const auto begins = page.find("schema = \"" + schema + "\"");
  return begins == std::string::npos ? "" : page.substr(begins, page.find("\n```", begins) - begins);
}

bool has(const std::vector<std::string>& found, const std::string& key) {
  return std::ranges::any_of(found, [&](const std::string& one) { return one.starts_with(key + ", which is"); });
}

TEST(Placeholders, RefusesTextsOfShippedExamples) {
  const auto page = read_text_file(GYROTHERM_SOURCE_DIR "/docs/calibration-report.md");
  ASSERT_TRUE(page);
  const auto laboratory = parse_laboratory(make_example(*page, kLaboratorySchema), "laboratory.toml");
  const auto order = parse_order(make_example(*page, kOrderSchema), "order.toml");
  ASSERT_TRUE(laboratory) << text(laboratory.error());
  ASSERT_TRUE(order) << text(order.error());
  CalibrationReport report;
  add_order(report, *laboratory, *order);
  for (const char* key : {"laboratory.toml: name", "laboratory.toml: address", "laboratory.toml: email",
                          "laboratory.toml: traceability.en", "laboratory.toml: traceability.de",
                          "laboratory.toml: statement[0].en", "laboratory.toml or order.toml: person[0].name",
                          "laboratory.toml or order.toml: person[1].name", "order.toml: customer.name"})
    EXPECT_TRUE(has(report.missing, key)) << key;
  EXPECT_FALSE(has(report.missing, "order.toml: unit.condition")) << "a text that applies to many units";
}

TEST(Placeholders, FindsUnfinishedTextInEachKey) {
  CalibrationReport report = sample_calibration();
  report.laboratory = {.name = "House of Gyros", .city = "Kiel", .country = "DE"};
  report.customer = {.name = "Harbour Pilots", .city = "Hamburg"};
  report.people = {{"B. Berg", "authorising", ""}, {"K. Kurz", "operator", ""}};
  ASSERT_TRUE(find_placeholders(report).empty()) << find_placeholders(report).front();
  report.remarks = {"see ...", "siehe Anhang"};
  report.item.serial_number = "TBD";
  report.people[1].name = "todo: who?";
  report.place = {"room …", "room …"};
  report.customer.email = "someone@example.com";
  report.replaces->reason = {"xxx", ""};
  const auto found = find_placeholders(report);
  for (const char* key : {"order.toml: remarks.en", "order.toml: unit.serial_number", "order.toml: place",
                          "laboratory.toml or order.toml: person[1].name", "order.toml: customer.email",
                          "order.toml: replaces.reason.en"})
    EXPECT_TRUE(has(found, key)) << key;
  EXPECT_EQ(found.size(), 6u);
}

TEST(Placeholders, AreFoundInEquipmentAndDeviations) {
  CalibrationReport report;
  report.equipment = {{.role = "thermometer", .name = "Logger 7", .serial_number = "xxx", .certificate = "TBD"},
                      {.role = "thermometer", .channel = "A", .name = "...", .certificate = "see tbd list"},
                      {.role = "chamber", .name = "TBD"},
                      {.role = "reference", .name = "Table", .certificate = "L-17", .names = {"Table", "Tisch …"}}};
  report.deviations = {{.kind = "note", .text = "TBD"},
                       {.kind = "stated", .text = "Door open.", .translations = {"Door open.", "todo"}},
                       {.kind = "stated", .text = "fixme"}};
  const auto found = find_placeholders(report);
  for (const char* key : {"laboratory.toml: equipment.serial_number", "laboratory.toml: equipment.certificate",
                          "laboratory.toml: equipment.name.de", "records: certificate of A",
                          "order.toml: deviation.text.de", "order.toml: deviation.text"})
    EXPECT_TRUE(has(found, key)) << key;
  EXPECT_EQ(found.size(), 6U) << "other texts are those of the records";
}

TEST(Placeholders, AcceptsOriginalTexts) {
  for (const char* text : {"", "Temperatures are traceable to the SI through certificate 2026-17 of PTB.", "M. Todorov",
                           "Todor-7", "No. 3.5.1", "lab@gyros.de", "Gyro Street 11"})
    EXPECT_FALSE(is_placeholder(text)) << text;
}

}  // namespace
}  // namespace gyrotherm::report
