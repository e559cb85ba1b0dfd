#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "bench/figure.hpp"
#include "bench/thermal/sections.hpp"
#include "thermal/steady_state.hpp"

namespace gyrotherm {

Result<void> measure_mesh_step(const ThermalBench& bench) {
  const auto model = read_gyro(bench);
  if (!model) return failure(model.error());
  const bool coarse = bench.mesh == MeshSize::coarse;
  const auto one = steady_state(*model, make_mesh(*model, coarse ? MeshSize::coarse : MeshSize::medium));
  if (!one) return failure(one.error());
  const auto finer = steady_state(*model, make_mesh(*model, coarse ? MeshSize::medium : MeshSize::fine));
  if (!finer) return failure(finer.error());
  double most_k = 0;
  for (std::size_t k = 0; k < 8; ++k) most_k = std::max(most_k, std::abs(one->outputs_c[k] - finer->outputs_c[k]));
  const double from_k = gain_difference_k(one->outputs_c), to_k = gain_difference_k(finer->outputs_c);
  const auto step = fmt::format("from {} to {} nodes", one->unknowns, finer->unknowns);
  print_figure(step + ": change of gain less non-gain areas, %", 100 * std::abs(from_k - to_k) / to_k, at_most(0.3));
  print_figure(step + ": most that one of A to H moves, K", most_k, at_most(0.05));
  return {};
}

}  // namespace gyrotherm
