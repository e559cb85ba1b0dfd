#include "bench/thermal/calculix_peer.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>

#include "thermal/calculix_input.hpp"

namespace gyrotherm {
namespace {

constexpr const char* kWhere = "ccx";

/// Becomes `ccx bench`, its words into a file.
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
  if (child < 0) return failure(FaultKind::numeric, kWhere, "could not be started");
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
  return failure(FaultKind::numeric, path, "does not hold every node");
}

}  // namespace

Result<CalculixRun> run_calculix(const GyroModel& model, const GyroMesh& mesh, const ThermalCoefficients& coefficients,
                                 const std::string& solver, const std::string& scratch) {
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

}  // namespace gyrotherm
