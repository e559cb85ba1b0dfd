#include <fmt/format.h>

#include <cmath>

#include "bench/figure.hpp"
#include "bench/stopwatch.hpp"
#include "bench/thermal/calculix_peer.hpp"
#include "bench/thermal/sections.hpp"
#include "core/file.hpp"
#include "thermal/gyro_file.hpp"
#include "thermal/steady_state.hpp"

namespace gyrotherm {
namespace {

/// A mesh and its linear steady state, the air as at 25 °C.
struct Timed {
  GyroMesh mesh;
  SteadyState state;
  ThermalCoefficients coefficients{};
  double seconds{};
};

Result<Timed> solve(const GyroModel& model, MeshSize size) {
  const auto coefficients = coefficients_at(model.air, 25, model.still_film_w_per_m2_k);
  const double start = thread_seconds();
  Timed timed{make_mesh(model, size), {}, coefficients, 0};
  auto state = steady_state(model, timed.mesh, {.coefficients = coefficients});
  if (!state) return failure(state.error());
  timed.state = std::move(*state);
  timed.seconds = thread_seconds() - start;
  return timed;
}

std::string nodes(const Timed& timed) { return fmt::format("{} nodes", timed.state.unknowns); }

}  // namespace

Result<GyroModel> read_gyro(const ThermalBench& bench) {
  const auto words = read_text_file(bench.gyro);
  if (!words) return failure(words.error());
  return parse_gyro(*words, bench.gyro);
}

Result<void> measure_steady(const ThermalBench& bench) {
  const auto model = read_gyro(bench);
  if (!model) return failure(model.error());
  const auto timed = solve(*model, bench.mesh);
  if (!timed) return failure(timed.error());
  const bool fine = bench.mesh == MeshSize::fine;
  const double imbalance_w = std::abs(timed->state.power_in_w - timed->state.power_out_w);
  print_figure(nodes(*timed) + ": steady state, mesh included, s", timed->seconds, at_most(fine ? 12 : 5));
  print_figure(nodes(*timed) + ": steady state, most memory, GB", peak_memory() / 1e9, at_most(fine ? 2 : 0.8));
  print_figure(nodes(*timed) + ": energy balance, W", imbalance_w, at_most(1e-6));
  auto whole = steady_state(*model, timed->mesh);
  if (!whole) return failure(whole.error());
  const double difference_k = gain_difference_k(whole->outputs_c);
  say_progress(fmt::format("{}: gain less non-gain areas {:.4f} K", nodes(*timed), difference_k));
  print_figure(nodes(*timed) + ": gain less non-gain areas, from 3.5 K", std::abs(difference_k - 3.5),
               at_most(bench.mesh == MeshSize::coarse ? 0.1 : 0.02));
  return {};
}

Result<void> measure_beside_calculix(const ThermalBench& bench, bool direct) {
  const auto model = read_gyro(bench);
  if (!model) return failure(model.error());
  const auto ours = solve(*model, bench.mesh);
  if (!ours) return failure(ours.error());
  struct Peer {
    const char* name;
    const char* solver;
    double goal;
  };
  for (const Peer& peer : {Peer{"iterative", "ITERATIVE CHOLESKY", 5}, Peer{"direct", "", 50}}) {
    if (peer.solver[0] == '\0' && !direct) continue;
    const auto name = fmt::format("{}: gain over CalculiX's {} solver", nodes(*ours), peer.name);
    const auto theirs = run_calculix(*model, ours->mesh, ours->coefficients, peer.solver, bench.scratch);
    if (!theirs) {
      say_progress(name + ": " + text(theirs.error()));
      print_figure(name, {}, at_least(peer.goal));
      continue;
    }
    const double apart_k = (theirs->field_c - ours->state.field_c).cwiseAbs().maxCoeff();
    say_progress(fmt::format("{}: ours {:.2f} s, CalculiX {} {:.2f} s, {:.2f} GB", nodes(*ours), ours->seconds,
                             peer.name, theirs->user_s, theirs->peak_bytes / 1e9));
    print_figure(fmt::format("{}: most apart from CalculiX ({}), K", nodes(*ours), peer.name), apart_k, at_most(1e-4));
    print_figure(name, theirs->user_s / ours->seconds, at_least(peer.goal), apart_k <= 1e-4);
  }
  return {};
}

}  // namespace gyrotherm
