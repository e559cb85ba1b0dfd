/// gyrotherm-reduce-gyro: writes GYRO.reduced.toml beside GYRO.toml. Run where a gyro file has changed.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <string>
#include <vector>

#include "acquisition/sha256.hpp"
#include "core/text_file.hpp"
#include "simulator/thermal/gyro_file.hpp"
#include "simulator/thermal/gyro_reduction.hpp"

namespace gyrotherm {
namespace {

struct Options {
  std::string gyro;
  std::string mesh = "medium";
  ReductionOptions reduction;
};

std::string reduced_path(const std::string& gyro) {
  constexpr std::string_view kSuffix = ".toml";
  return (gyro.ends_with(kSuffix) ? gyro.substr(0, gyro.size() - kSuffix.size()) : gyro) + ".reduced.toml";
}

Result<void> reduce_and_write(const Options& options) {
  const auto text = read_text_file(options.gyro);
  if (!text) return failure(text.error());
  const auto gyro = parse_gyro(*text, options.gyro);
  if (!gyro) return failure(gyro.error());
  const auto size = std::ranges::find(kMeshSizeNames, options.mesh) - kMeshSizeNames.begin();
  int shown = -1;
  std::string shown_stage;
  const auto model = reduce_gyro(*gyro, sha256(*text), static_cast<MeshSize>(size), options.reduction,
                                 [&](std::string_view stage, double fraction) {
                                   const int tenths = static_cast<int>(fraction * 10);
                                   if (tenths == shown && stage == shown_stage) return true;
                                   shown = tenths;
                                   shown_stage = stage;
                                   fmt::print(stderr, "{} {} %\n", stage, 10 * tenths);
                                   return true;
                                 });
  if (!model) return failure(model.error());
  const auto path = reduced_path(options.gyro);
  if (const auto written = replace_text_file(path, reduced_model_text(*model)); !written) return written;
  fmt::print("{}: {} states of {}; errors over A…H: {:.1e} K by points, {:.1e} K on ramps, {:.1e} K at switch-on\n",
             path, model->conduction.rows(), model->mesh, model->error.transfer_k, model->error.ramp_k,
             model->error.switch_on_k);
  return {};
}

}  // namespace
}  // namespace gyrotherm

int main(int argc, char** argv) {
  gyrotherm::Options options;
  CLI::App app{
      "Example: gyrotherm-reduce-gyro profiles/gyros/calibrated.toml\n\n"
      "Reduces the finite-element model of a gyro file to the few states that the virtual rig steps."};
  app.add_option("GYRO", options.gyro, "gyro file")->required();
  app.add_option("--mesh", options.mesh, "coarse, medium or fine")
      ->check(CLI::IsMember({"coarse", "medium", "fine"}))
      ->capture_default_str();
  app.add_option("--states", options.reduction.states, "at most")->check(CLI::Range(8, 200))->capture_default_str();
  app.add_option("--goal", options.reduction.goal_k, "largest error, K")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  const auto done = gyrotherm::reduce_and_write(options);
  if (done) return 0;
  fmt::print(stderr, "{}\n", text(done.error()));
  return done.error().kind == gyrotherm::FaultKind::bad_file ? 4 : 3;
}
