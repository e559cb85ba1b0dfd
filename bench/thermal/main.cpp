/// gyrotherm-thermal-bench: one section of the benchmark per call. bench/thermal/compare calls them all.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <functional>
#include <map>

#include "bench/thermal/sections.hpp"

namespace gyrotherm {
namespace {

int run(int argc, char** argv) {
  CLI::App app{"The finite-element gyro and its twin beside CalculiX: one section per call."};
  ThermalBench bench;
  bool direct = false;
  std::function<Result<void>()> chosen;
  const std::map<std::string, MeshSize> sizes{
      {"coarse", MeshSize::coarse}, {"medium", MeshSize::medium}, {"fine", MeshSize::fine}};
  app.add_option("--gyro", bench.gyro, "gyro file")->required();
  app.add_option("--reduced", bench.reduced, "its reduced model");
  app.add_option("--scratch", bench.scratch, "folder for CalculiX's files");
  app.add_option("--mesh", bench.mesh, "coarse, medium or fine")->transform(CLI::CheckedTransformer(sizes));
  app.require_subcommand(1);
  const auto add = [&](const char* name, const char* what, std::function<Result<void>()> section) {
    auto* const command = app.add_subcommand(name, what)->fallthrough();
    command->callback([&chosen, section = std::move(section)] { chosen = section; });
    return command;
  };
  add("steady", "one steady state", [&] { return measure_steady(bench); });
  add("calculix", "the same beside CalculiX", [&] {
    return measure_beside_calculix(bench, direct);
  })->add_flag("--direct", direct, "its direct solver too");
  add("mesh-step", "what a finer mesh changes", [&] { return measure_mesh_step(bench); });
  add("twin", "the reduced twin over the whole programme", [&] { return measure_reduced(bench); });
  CLI11_PARSE(app, argc, argv);
  if (const auto done = chosen(); !done) {
    fmt::print(stderr, "{}\n", text(done.error()));
    return 1;
  }
  return 0;
}

}  // namespace
}  // namespace gyrotherm

int main(int argc, char** argv) { return gyrotherm::run(argc, argv); }
