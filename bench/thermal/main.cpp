// SPDX-License-Identifier: Apache-2.0
/// gyrotherm-thermal-bench: runs one section of the benchmark per call. bench/thermal/compare calls all of them. The
/// peer is CalculiX, run as a child process on the identical mesh.
#include <fcntl.h>
#include <fmt/format.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>
#include <map>
#include <string>

#include "bench/measurement.hpp"
#include "core/file.hpp"
#include "core/result.hpp"
#include "simulator/thermal/gyro_model.hpp"
#include "simulator/thermal/mesh.hpp"
#include "simulator/thermal/reduced/reduced_model.hpp"
#include "simulator/thermal/reduced/reduced_transient.hpp"
#include "simulator/thermal/reduced/thermal_system.hpp"
#include "simulator/thermal/steady_state.hpp"

namespace gyrotherm::bench {
namespace {

struct ThermalBench {
  std::string gyro;
  std::string reduced;
  std::string scratch = ".";
  thermal::MeshSize mesh = thermal::MeshSize::medium;
};

struct CalculixRun {
  Eigen::VectorXd field_c;  ///< per node of the mesh
  /// Processor time of the child, one thread.
  double user_s{};
  double peak_bytes{};
};

constexpr const char* kWhere = "ccx";

/// Executes `ccx bench` in place of this process, with its output redirected to a file.
[[noreturn]] void become_calculix(const std::string& scratch) {
  const int log = open((scratch + "/bench.log").c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
  if (log >= 0 && dup2(log, 1) >= 0 && dup2(log, 2) >= 0 && chdir(scratch.c_str()) == 0) {
    setenv("OMP_NUM_THREADS", "1", 1);
    setenv("CCX_NPROC_EQUATION_SOLVER", "1", 1);
    execlp("ccx", "ccx", "bench", nullptr);
  }
  _exit(127);
}

Result<rusage> run_child(const std::string& scratch) {
  const pid_t child = fork();
  if (child < 0) return failure(FaultKind::numeric, kWhere, "cannot be started");
  if (child == 0) become_calculix(scratch);
  int status = 0;
  rusage usage{};
  wait4(child, &status, 0, &usage);
  if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return usage;
  return failure(FaultKind::numeric, kWhere, "is not installed, or failed: see " + scratch + "/bench.log");
}

Result<Eigen::VectorXd> read_field(const std::string& path, Eigen::Index nodes) {
  Eigen::VectorXd field = Eigen::VectorXd::Constant(nodes, std::numeric_limits<double>::quiet_NaN());
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) {
    long node = 0;
    double celsius = 0;
    if (std::sscanf(line.c_str(), "%ld %lf", &node, &celsius) == 2 && node >= 1 && node <= nodes)
      field[node - 1] = celsius;
  }
  if (field.allFinite()) return field;
  return failure(FaultKind::numeric, path, "does not contain every node");
}

/// Runs `ccx` with one thread in `scratch`, which receives large files. Fails with storage, and with numeric if the
/// program is missing, fails or omits nodes.
Result<CalculixRun> run_calculix(const thermal::GyroModel& model, const thermal::GyroMesh& mesh,
                                 const thermal::ThermalCoefficients& coefficients, const std::string& solver,
                                 const std::string& scratch) {
  std::filesystem::create_directories(scratch);
  {
    std::ofstream input(scratch + "/bench.inp");
    write_calculix_input(input, model, mesh, {.ambient_c = 20, .coefficients = coefficients, .solver = solver});
    if (!input.flush()) return failure(FaultKind::storage, scratch + "/bench.inp", "could not be written");
  }
  const auto usage = run_child(scratch);
  if (!usage) return failure(usage.error());
  auto field = read_field(scratch + "/bench.dat", static_cast<Eigen::Index>(mesh.node_count));
  if (!field) return failure(field.error());
  const double user_s =
      static_cast<double>(usage->ru_utime.tv_sec) + 1e-6 * static_cast<double>(usage->ru_utime.tv_usec);
  return CalculixRun{std::move(*field), user_s, 1024.0 * static_cast<double>(usage->ru_maxrss)};
}

/// Linear steady state on a mesh, with air properties at 25 °C.
struct TimedState {
  thermal::GyroMesh mesh;
  thermal::SteadyState state;
  thermal::ThermalCoefficients coefficients{};
  double seconds{};
};

Result<TimedState> solve(const thermal::GyroModel& model, thermal::MeshSize size) {
  const auto coefficients = coefficients_at(model.air, 25, model.still_film_w_per_m2_k);
  const double start = thread_seconds();
  TimedState timed{make_mesh(model, size), {}, coefficients, 0};
  auto state = steady_state(model, timed.mesh, {.coefficients = coefficients});
  if (!state) return failure(state.error());
  timed.state = std::move(*state);
  timed.seconds = thread_seconds() - start;
  return timed;
}

std::string nodes(const TimedState& timed) { return fmt::format("{} nodes", timed.state.unknowns); }

Result<thermal::GyroModel> read_gyro(const ThermalBench& bench) {
  const auto text = read_text_file(bench.gyro);
  if (!text) return failure(text.error());
  return thermal::parse_gyro(*text, bench.gyro);
}

/// Measures time, memory, energy balance and the temperature difference between gain and non-gain areas for one linear
/// steady state. Must run in a separate process, because the peak memory is that of the whole process.
Result<void> measure_steady(const ThermalBench& bench) {
  const auto model = read_gyro(bench);
  if (!model) return failure(model.error());
  const auto timed = solve(*model, bench.mesh);
  if (!timed) return failure(timed.error());
  const bool fine = bench.mesh == thermal::MeshSize::fine;
  const double imbalance_w = std::abs(timed->state.power_in_w - timed->state.power_out_w);
  print_figure(nodes(*timed) + ": steady state, mesh included, s", timed->seconds, at_most(fine ? 3.5 : 1.5));
  print_figure(nodes(*timed) + ": steady state, peak memory, GB", peak_memory() / 1e9, at_most(fine ? 0.4 : 0.2));
  print_figure(nodes(*timed) + ": energy balance, W", imbalance_w, at_most(1e-6));
  auto whole = steady_state(*model, timed->mesh);
  if (!whole) return failure(whole.error());
  const double difference_k = thermal::gain_difference_k(whole->outputs_c);
  print_progress(fmt::format("{}: gain less non-gain areas {:.4f} K", nodes(*timed), difference_k));
  print_figure(nodes(*timed) + ": gain less non-gain areas, difference from 3.5 K", std::abs(difference_k - 3.5),
               at_most(bench.mesh == thermal::MeshSize::coarse ? 0.1 : 0.02));
  return {};
}

/// Compares with CalculiX's iterative solver; with `direct`, also with its direct one.
Result<void> compare_with_calculix(const ThermalBench& bench, bool direct) {
  const auto model = read_gyro(bench);
  if (!model) return failure(model.error());
  const auto ours = solve(*model, bench.mesh);
  if (!ours) return failure(ours.error());
  const bool coarse = bench.mesh == thermal::MeshSize::coarse;
  struct Peer {
    const char* name;
    const char* solver;
    double goal;
  };
  for (const Peer& peer : {Peer{"iterative", "ITERATIVE CHOLESKY", coarse ? 12.0 : 20.0}, Peer{"direct", "", 50}}) {
    if (peer.solver[0] == '\0' && !direct) continue;
    const auto name = fmt::format("{}: gain over CalculiX's {} solver", nodes(*ours), peer.name);
    const auto theirs = run_calculix(*model, ours->mesh, ours->coefficients, peer.solver, bench.scratch);
    if (!theirs) {
      print_progress(name + ": " + text(theirs.error()));
      print_figure(name, {}, at_least(peer.goal));
      continue;
    }
    const double apart_k = (theirs->field_c - ours->state.field_c).cwiseAbs().maxCoeff();
    print_progress(fmt::format("{}: ours {:.2f} s, CalculiX {} {:.2f} s, {:.2f} GB", nodes(*ours), ours->seconds,
                               peer.name, theirs->user_s, theirs->peak_bytes / 1e9));
    print_figure(fmt::format("{}: greatest difference from CalculiX ({}), K", nodes(*ours), peer.name), apart_k,
                 at_most(1e-4));
    print_figure(name, theirs->user_s / ours->seconds, at_least(peer.goal), apart_k <= 1e-4);
  }
  return {};
}

/// Measures the effect of a finer mesh: from medium to fine, or from coarse to medium if `bench.mesh` is coarse.
Result<void> measure_mesh_step(const ThermalBench& bench) {
  const auto model = read_gyro(bench);
  if (!model) return failure(model.error());
  const bool coarse = bench.mesh == thermal::MeshSize::coarse;
  const auto one =
      steady_state(*model, make_mesh(*model, coarse ? thermal::MeshSize::coarse : thermal::MeshSize::medium));
  if (!one) return failure(one.error());
  const auto finer =
      steady_state(*model, make_mesh(*model, coarse ? thermal::MeshSize::medium : thermal::MeshSize::fine));
  if (!finer) return failure(finer.error());
  double most_k = 0;
  for (std::size_t k = 0; k < 8; ++k) most_k = std::max(most_k, std::abs(one->outputs_c[k] - finer->outputs_c[k]));
  const double from_k = thermal::gain_difference_k(one->outputs_c), to_k = thermal::gain_difference_k(finer->outputs_c);
  const auto step = fmt::format("from {} to {} nodes", one->unknowns, finer->unknowns);
  print_figure(step + ": change of gain less non-gain areas, %", 100 * std::abs(from_k - to_k) / to_k, at_most(0.3));
  print_figure(step + ": greatest change of A to H, K", most_k, at_most(0.05));
  return {};
}

/// Compares the bare block, with its passive bore filled with glass, with a body-fitted tetrahedral mesh of 601,341
/// nodes (bench/thermal/tetrahedra). The temperature difference on that mesh agrees within 0.01 % with the one on a
/// mesh of 188,058 nodes.
Result<void> measure_block(const ThermalBench& bench) {
  constexpr std::array<double, 8> kTetrahedra_c{27.6570, 28.0568, 28.0569, 26.5442, 26.5444, 24.4020, 23.6679, 24.4017};
  constexpr double kDifference_k = 3.7664;
  auto model = read_gyro(bench);
  if (!model) return failure(model.error());
  model->mode = thermal::GyroMode::block;
  model->materials[static_cast<std::size_t>(thermal::GyroMaterial::passive_bore)] =
      model->materials[static_cast<std::size_t>(thermal::GyroMaterial::zerodur)];
  const auto state = steady_state(*model, make_mesh(*model, bench.mesh));
  if (!state) return failure(state.error());
  double most_k = 0;
  for (std::size_t k = 0; k < kTetrahedra_c.size(); ++k)
    most_k = std::max(most_k, std::abs(state->outputs_c[k] - kTetrahedra_c[k]));
  const double difference_k = thermal::gain_difference_k(state->outputs_c);
  const auto block = fmt::format("block alone, {} nodes", state->unknowns);
  print_progress(
      fmt::format("{}: gain less non-gain areas {:.4f} K, tetrahedra {:.4f} K", block, difference_k, kDifference_k));
  print_figure(block + ": gain less non-gain areas, difference from body-fitted tetrahedra, %",
               100 * std::abs(difference_k / kDifference_k - 1), at_most(0.5));
  print_figure(block + ": greatest difference of A to H from them, K", most_k, at_most(0.02));
  return {};
}

constexpr int kProgramSeconds = 221'600;  // four cycles at 1, 2, 3 and 5 °C/min

/// Returns the air temperatures of the paper's program, °C per second: holds of two hours at 20, −40, 60, −40, 60 and
/// 20 °C, once for each ramp rate.
std::vector<double> program_c() {
  std::vector<double> air_c;
  double now_c = 20;
  for (const double rate_per_min : {1.0, 2.0, 3.0, 5.0}) {
    for (const double target_c : {20.0, -40.0, 60.0, -40.0, 60.0, 20.0}) {
      while (now_c != target_c) {
        const double step = rate_per_min / 60;
        now_c = now_c < target_c ? std::min(target_c, now_c + step) : std::max(target_c, now_c - step);
        air_c.push_back(now_c);
      }
      air_c.insert(air_c.end(), 7200, target_c);
    }
  }
  return air_c;
}

double measure_simulation(const thermal::ReducedModel& model, const std::vector<double>& air_c, bool linear,
                          double& coldest_c) {
  const double start = thread_seconds();
  thermal::ReducedTransient reduced(model, {.start = {20}, .linear = linear});
  coldest_c = 1e9;
  for (const double air : air_c) {
    reduced.step({air});
    coldest_c = std::min(coldest_c, reduced.outputs_c()[0]);
  }
  return thread_seconds() - start;
}

/// Measures the reduced model over the whole program of 61.56 h.
Result<void> measure_reduced(const ThermalBench& bench) {
  const auto text = read_text_file(bench.reduced);
  if (!text) return failure(text.error());
  const auto model = thermal::parse_reduced_model(*text, bench.reduced);
  if (!model) return failure(model.error());
  const auto air_c = program_c();
  print_progress(fmt::format("the program lasts {} s, the program of the paper {} s", air_c.size(), kProgramSeconds));
  double coldest_c = 0;
  const auto states = fmt::format("twin of {} states", model->conduction.rows());
  print_figure(states + ": whole program, linear, s", measure_simulation(*model, air_c, true, coldest_c), at_most(0.1));
  print_figure(states + ": whole program, air properties at its temperature, s",
               measure_simulation(*model, air_c, false, coldest_c), at_most(5));
  print_progress(fmt::format("lowest temperature of thermometer A: {:.2f} °C", coldest_c));
  print_figure(states + ": greatest difference from the full model on ramps, K", model->error.ramp_k, at_most(1e-3));
  print_figure(states + ": greatest difference from the full model when switched on, K", model->error.switch_on_k,
               at_most(1e-2));
  return {};
}

int run(int argc, char** argv) {
  CLI::App app{"The finite-element gyro and its twin beside CalculiX: one section per call."};
  ThermalBench bench;
  bool direct = false;
  std::function<Result<void>()> chosen;
  const std::map<std::string, thermal::MeshSize> sizes{
      {"coarse", thermal::MeshSize::coarse}, {"medium", thermal::MeshSize::medium}, {"fine", thermal::MeshSize::fine}};
  app.add_option("--gyro", bench.gyro, "gyro file")->required();
  app.add_option("--reduced", bench.reduced, "reduced model of the gyro");
  app.add_option("--scratch", bench.scratch, "folder for CalculiX's files");
  app.add_option("--mesh", bench.mesh, "coarse, medium or fine")->transform(CLI::CheckedTransformer(sizes));
  app.require_subcommand(1);
  const auto add = [&](const char* name, const char* what, std::function<Result<void>()> section) {
    auto* const command = app.add_subcommand(name, what)->fallthrough();
    command->callback([&chosen, section = std::move(section)] { chosen = section; });
    return command;
  };
  add("steady", "measure one steady state", [&] { return measure_steady(bench); });
  add("calculix", "compare the steady state with CalculiX", [&] {
    return compare_with_calculix(bench, direct);
  })->add_flag("--direct", direct, "also compare with its direct solver");
  add("mesh-step", "measure the effect of a finer mesh", [&] { return measure_mesh_step(bench); });
  add("block", "compare the block with body-fitted tetrahedra", [&] { return measure_block(bench); });
  add("twin", "measure the reduced twin over the whole program", [&] { return measure_reduced(bench); });
  CLI11_PARSE(app, argc, argv);
  if (const auto done = chosen(); !done) {
    fmt::print(stderr, "{}\n", text(done.error()));
    return 1;
  }
  return 0;
}

}  // namespace
}  // namespace gyrotherm::bench

int main(int argc, char** argv) { return gyrotherm::bench::run(argc, argv); }
