// SPDX-License-Identifier: Apache-2.0
/// The identities that the drivers receive from marked virtual instruments.
#include "simulator/identity_marks.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <set>
#include <string>
#include <utility>

#include "core/file.hpp"
#include "drivers/virtual_identity.hpp"
#include "tests/simulator/chamber_on_a_line.hpp"

namespace gyrotherm::simulator {
namespace {

constexpr const char* kProfiles = GYROTHERM_SOURCE_DIR "/profiles/";

/// Returns the names of the files in a folder below `profiles` for which `holds(name)` is true, and the number of
/// files.
template <class Holds>
std::pair<std::set<std::string>, int> find_files(const std::string& folder, const Holds& holds) {
  std::pair<std::set<std::string>, int> found;
  for (const auto& entry : std::filesystem::directory_iterator(kProfiles + folder)) {
    if (entry.path().extension() != ".toml") continue;
    ++found.second;
    const auto name = entry.path().stem().string();
    if (holds(name)) found.first.insert(name);
  }
  return found;
}

/// The other maps describe no identity, or only numbers and patterns that exclude a mark.
TEST(IdentityMarks, AreReportedByChambersWhoseIdentityHasRoom) {
  const auto [marked, maps] = find_files("chambers", [](const std::string& name) {
    ChamberOnALine line(chamber_map(name), true);
    const auto identity = line.chamber->identify();
    EXPECT_TRUE(identity) << name << ": " << text(identity.error());
    return identity && drivers::is_virtual_identity(*identity);
  });
  EXPECT_EQ(maps, 30);
  EXPECT_EQ(marked, (std::set<std::string>{"espec_p300", "espec_scp220", "huber", "julabo", "lauda", "thermotron_3800",
                                           "thermotron_8800", "virtual", "virtual_climate", "virtual_limiter",
                                           "watlow_ez_zone_pm", "watlow_f4", "watlow_f4t", "watlow_f4t_cascade",
                                           "watlow_f4t_scpi", "weiss_ascii2", "weiss_simserv"}));
}

TEST(IdentityMarks, AreReportedByEveryShippedThermometerAndSupply) {
  const auto thermometers = find_files("thermometers", [](const std::string& name) {
    const auto file = kProfiles + ("thermometers/" + name + ".toml");
    VirtualInstrumentsOptions options{.chamber = chamber_map("virtual"), .thermometers = {{}}, .gyros = {}};
    options.thermometers[0].description =
        drivers::parse_thermometer_description(read_text_file(file).value_or(""), file).value();
    mark_identities(options);
    return drivers::is_virtual_identity(options.thermometers[0].description->simulated.identity);
  });
  EXPECT_EQ(thermometers.second, 7);
  EXPECT_EQ(thermometers.first.size(), 7u);
  const auto supplies = find_files("supplies", [](const std::string& name) {
    const auto file = kProfiles + ("supplies/" + name + ".toml");
    VirtualInstrumentsOptions options{.chamber = chamber_map("virtual"), .thermometers = {}, .gyros = {}};
    options.supplies = {
        {.description = drivers::parse_supply_description(read_text_file(file).value_or(""), file).value(),
         .outputs = {}}};
    mark_identities(options);
    return drivers::is_virtual_identity(options.supplies[0].description.simulated.identity);
  });
  EXPECT_EQ(supplies.second, 6);
  EXPECT_EQ(supplies.first.size(), 6u);
}

TEST(IdentityMarks, LeaveIdentityWhosePatternExcludesThem) {
  VirtualInstrumentsOptions options{.chamber = chamber_map("virtual"), .thermometers = {{}}, .gyros = {}};
  const auto file = std::string(kProfiles) + "thermometers/keithley_2700.toml";
  options.thermometers[0].description =
      drivers::parse_thermometer_description(read_text_file(file).value_or(""), file).value();
  auto& described = *options.thermometers[0].description;
  described.unit.identity->pattern = "B09  /A02  $";
  const auto before = described.simulated.identity;
  mark_identities(options);
  EXPECT_EQ(described.simulated.identity, before);
}

TEST(IdentityMarks, AreAnsweredByGyroWithIdentity) {
  VirtualInstrumentsOptions options{.chamber = chamber_map("virtual"), .thermometers = {}, .gyros = {{}, {}}};
  options.gyros[1].identity = drivers::IdentityQuery{
      .send = "$VNRRG,03*XX\r\n", .wait = std::chrono::milliseconds(200), .begins = "$VNRRG,03,", .ends = "*"};
  mark_identities(options);
  EXPECT_TRUE(options.gyros[0].commands.empty());
  ASSERT_EQ(options.gyros[1].commands.size(), 1u);
  EXPECT_EQ(options.gyros[1].commands[0].send, "$VNRRG,03*XX\r\n");
  EXPECT_EQ(options.gyros[1].commands[0].reply, "$VNRRG,03,VIRTUAL1*");
}

TEST(IdentityMarks, NameDconModulesWithinSixCharacters) {
  VirtualInstrumentsOptions options{.chamber = chamber_map("virtual"), .thermometers = {{}}, .gyros = {}};
  mark_identities(options);
  EXPECT_LE(options.thermometers[0].module_name.size(), 6u);
  EXPECT_TRUE(drivers::is_virtual_identity(options.thermometers[0].module_name + " at 01, type 0F"));
}

}  // namespace
}  // namespace gyrotherm::simulator
