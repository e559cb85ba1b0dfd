// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <string>

#include "apps/console/command.hpp"
#include "apps/console/interrupt.hpp"
#include "core/file.hpp"
#include "core/sha256.hpp"
#include "simulator/thermal/gyro_model.hpp"
#include "simulator/thermal/model_order_reduction.hpp"

namespace gyrotherm::app {
namespace {

struct ReduceArguments {
  std::string gyro;
  std::string mesh = "medium";
  thermal::ReductionOptions reduction;
};

std::string reduced_path(const std::string& gyro) {
  constexpr std::string_view kSuffix = ".toml";
  return (gyro.ends_with(kSuffix) ? gyro.substr(0, gyro.size() - kSuffix.size()) : gyro) + ".reduced.toml";
}

Result<Exit> reduce_and_write(Console& console, const ReduceArguments& options) {
  const auto text = read_text_file(options.gyro);
  if (!text) return failure(text.error());
  const auto gyro = thermal::parse_gyro(*text, options.gyro);
  if (!gyro) return failure(gyro.error());
  const auto size = std::ranges::find(thermal::kMeshSizeNames, options.mesh) - thermal::kMeshSizeNames.begin();
  watch_for_interrupts(SecondInterrupt::ends);
  const auto model =
      reduce_gyro(*gyro, sha256(*text), static_cast<thermal::MeshSize>(size), options.reduction, console.sink());
  if (!model) return failure(model.error());
  const auto path = reduced_path(options.gyro);
  if (auto written = replace_text_file(path, thermal::reduced_model_text(*model)); !written)
    return failure(written.error());
  console.print(fmt::format(
      "{}: {} states of {}; errors over A…H: {:.1e} K by points, {:.1e} K on ramps, {:.1e} K at switch-on\n", path,
      model->conduction.rows(), model->mesh, model->error.transfer_k, model->error.ramp_k, model->error.switch_on_k));
  return Exit::done;
}

}  // namespace

void add_thermal_reduce(Program& program) {
  auto [command, options] =
      add_command(program, "reduce",
                  "Reduces the finite-element model of a gyro file to the few states that the virtual rig simulates, "
                  "and writes GYRO.reduced.toml next to GYRO.toml. Required after a change of a gyro file.",
                  "gyrotherm-thermal reduce profiles/gyros/calibrated.toml", reduce_and_write);
  command.add_option("GYRO", options.gyro, "gyro file")->type_name(value::kToml)->required();
  command.add_option("--mesh", options.mesh, "coarse, medium or fine")
      ->check(CLI::IsMember({"coarse", "medium", "fine"}));
  command.add_option("--states", options.reduction.states, "largest number of states")->check(CLI::Range(8.0, 200.0));
  command.add_option("--goal", options.reduction.goal_k, "largest error, K")->check(CLI::Range(1e-6, 10.0));
}

}  // namespace gyrotherm::app
