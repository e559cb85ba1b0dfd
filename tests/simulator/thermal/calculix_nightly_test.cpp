// SPDX-License-Identifier: Apache-2.0
/// Compares the solver with CalculiX on the identical mesh, and compares the meshes with each other. Takes minutes.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "simulator/thermal/mesh.hpp"
#include "simulator/thermal/steady_state.hpp"
#include "tests/simulator/thermal/small_bodies.hpp"

namespace gyrotherm::thermal {
namespace {

namespace fs = std::filesystem;

bool has_program(const char* name) {
  return std::system((std::string("command -v ") + name + " > /dev/null 2>&1").c_str()) == 0;
}

/// Temporary folder that is removed with the object.
class Folder {
 public:
  Folder() : path_(fs::temp_directory_path() / "gyrotherm_calculix_XXXXXX") {
    auto name = path_.string();
    path_ = mkdtemp(name.data());
  }
  ~Folder() { fs::remove_all(path_); }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  [[nodiscard]] const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

/// Returns the largest difference in K between the result of CalculiX and the field. The result must list every node.
double largest_difference(const fs::path& dat, const Eigen::VectorXd& field_c) {
  std::ifstream file(dat);
  double largest = 0;
  Eigen::Index nodes = 0;
  for (std::string line; std::getline(file, line);) {
    long node = 0;
    double celsius = 0;
    if (std::sscanf(line.c_str(), "%ld %lf", &node, &celsius) != 2 || node < 1 || node > field_c.size()) continue;
    largest = std::max(largest, std::abs(celsius - field_c[node - 1]));
    ++nodes;
  }
  EXPECT_EQ(nodes, field_c.size());
  return largest;
}

void expect_agreement_with_calculix(const GyroModel& model, MeshSize size) {
  if (!has_program("ccx")) GTEST_SKIP() << "ccx is not installed (Debian: calculix-ccx)";
  const auto mesh = make_mesh(model, size);
  const auto state = steady_state(model, mesh);
  ASSERT_TRUE(state) << text(state.error());
  const Folder folder;
  {
    std::ofstream input(folder.path() / "gyro.inp");
    write_calculix_input(input, model, mesh, {.ambient_c = 20, .coefficients = state->coefficients});
  }
  const auto command = "cd '" + folder.path().string() + "' && ccx gyro > gyro.log 2>&1";
  ASSERT_EQ(std::system(command.c_str()), 0);
  EXPECT_LE(largest_difference(folder.path() / "gyro.dat", state->field_c), 1e-4);
}

TEST(Calculix, MatchesFieldOnSameMesh) { expect_agreement_with_calculix(shipped_gyro("calibrated"), MeshSize::coarse); }

TEST(Calculix, MatchesFieldOfBlock) {
  auto model = shipped_gyro("calibrated");
  model.mode = GyroMode::block;
  expect_agreement_with_calculix(model, MeshSize::medium);
}

TEST(MeshStep, ChangesLessThanFiftyMillikelvinFromMediumToFine) {
  const auto model = shipped_gyro("calibrated");
  const auto medium = steady_state(model, make_mesh(model, MeshSize::medium));
  const auto fine = steady_state(model, make_mesh(model, MeshSize::fine));
  ASSERT_TRUE(medium && fine);
  for (std::size_t t = 0; t < 8; ++t)
    EXPECT_NEAR(medium->outputs_c[t], fine->outputs_c[t], 0.05) << kThermalOutputNames[t];
  EXPECT_NEAR(gain_difference_k(medium->outputs_c) / gain_difference_k(fine->outputs_c), 1, 0.003);
}

TEST(Calibration, GivesDifferenceOfPaper) {
  const auto model = shipped_gyro("calibrated");
  const auto medium = steady_state(model, make_mesh(model, MeshSize::medium));
  ASSERT_TRUE(medium);
  EXPECT_NEAR(gain_difference_k(medium->outputs_c), 3.5, 0.02);
}

}  // namespace
}  // namespace gyrotherm::thermal
