// SPDX-License-Identifier: Apache-2.0
/// Tests the files for ParaView and CalculiX.
#include <gtest/gtest.h>

#include <cstring>
#include <regex>
#include <sstream>

#include "simulator/thermal/assembly.hpp"
#include "simulator/thermal/mesh.hpp"
#include "tests/simulator/thermal/small_bodies.hpp"

namespace gyrotherm::thermal {
namespace {

GyroMesh two_bricks() { return box_of(GyroPart::gain_left, {0, 0.01, 0.03}, {0, 0.01}, {0, 0.02}, {0, 5}); }

/// Returns the values of an array by its name from the appended data.
template <class T>
std::vector<T> appended(const std::string& file, const std::string& name) {
  std::smatch match;
  const std::regex attribute("Name=\"" + name + "\"[^>]*offset=\"([0-9]+)\"");
  EXPECT_TRUE(std::regex_search(file, match, attribute)) << name;
  const char* data = file.data() + file.find("encoding=\"raw\">\n_") + 17 + std::stoul(match[1]);
  std::uint64_t bytes = 0;
  std::memcpy(&bytes, data, sizeof bytes);
  std::vector<T> values(bytes / sizeof(T));
  std::memcpy(values.data(), data + sizeof bytes, bytes);
  return values;
}

TEST(Vtu, ContainsPointsCellsAndTemperatures) {
  const auto mesh = two_bricks();
  ASSERT_EQ(mesh.node_count, 32U);
  const Eigen::VectorXd field = Eigen::VectorXd::LinSpaced(32, 20, 51);
  std::ostringstream out;
  write_vtu(out, mesh, field);
  const auto file = out.str();
  EXPECT_NE(file.find("NumberOfPoints=\"32\" NumberOfCells=\"2\""), std::string::npos);
  EXPECT_EQ(appended<float>(file, "points").size(), 96U);
  const auto temperatures = appended<float>(file, "T");
  ASSERT_EQ(temperatures.size(), 32U);
  EXPECT_EQ(temperatures[31], 51.0F);
  EXPECT_EQ(appended<std::int32_t>(file, "connectivity").size(), 40U);
  EXPECT_EQ(appended<std::int32_t>(file, "offsets"), (std::vector<std::int32_t>{20, 40}));
  EXPECT_EQ(appended<std::uint8_t>(file, "types"), (std::vector<std::uint8_t>{25, 25}));
  EXPECT_EQ(appended<std::uint8_t>(file, "part"),
            std::vector<std::uint8_t>(2, static_cast<std::uint8_t>(GyroPart::gain_left)));
}

TEST(CalculixInput, ContainsNodesElementsSourcesAndFilm) {
  auto model = uniform_model({2000, 500, 1.5});
  model.powers_w[0] = 0.3;
  const auto mesh = two_bricks();
  std::ostringstream out;
  write_calculix_input(out, model, mesh, {.ambient_c = 20, .coefficients = {0, 0, 0, 8}, .solver = ""});
  const auto file = out.str();
  EXPECT_NE(file.find("*NODE,NSET=NALL\n1,0,0,0\n"), std::string::npos);
  EXPECT_NE(file.find("\n32,0.03,0.01,0.02\n"), std::string::npos);
  EXPECT_NE(file.find("*ELEMENT,TYPE=DC3D20,ELSET=C1\n1,"), std::string::npos);
  EXPECT_NE(file.find("*CONDUCTIVITY\n1.5\n"), std::string::npos);
  EXPECT_NE(file.find("C1,BF,50000\n"), std::string::npos);
  EXPECT_NE(file.find("*FILM\n1,F6,20,8\n1,F2,20,8\n2,F2,20,8\n"), std::string::npos);
}

TEST(CalculixInput, WritesTensorOfCutBricks) {
  const auto model = shipped_gyro("calibrated");
  const auto mesh = make_mesh(model, 9.0);
  std::ostringstream out;
  write_calculix_input(out, model, mesh, {.ambient_c = 20, .coefficients = {0.03, 0.03, 0.03, 8}});
  EXPECT_NE(out.str().find("*CONDUCTIVITY,TYPE=ANISO\n"), std::string::npos);
}

}  // namespace
}  // namespace gyrotherm::thermal
