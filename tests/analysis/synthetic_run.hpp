/// A small designed world for the tests of this room: eight thermometers on a thermal network, a bias that gradients
/// explain, and a program of a few hundred clusters. It tests code; it confirms nothing about gyros.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "analysis/data/dataset.hpp"

namespace gyrotherm {

struct SyntheticRun {
  std::string run_id = "synthetic-1";
  std::vector<double> cycle_rates_c_per_min = {2, 3, 4, 5};  ///< one cycle each: 20 → −20 → 50 → 20 °C
  double hold_s = 1500;
  double noise_deg_per_h = 0.02;        ///< of one second, white
  double absolute_deg_per_h_per_c = 0;  ///< a part of the bias that no gradient sees
  std::uint64_t seed = 1;
};

[[nodiscard]] Dataset make_synthetic_run(const SyntheticRun& run);

}  // namespace gyrotherm
