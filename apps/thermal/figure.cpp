// SPDX-License-Identifier: Apache-2.0
/// The command `figure` of gyrotherm-thermal: prints the thermal model of a gyro for a report, with the data of Tables
/// 1 and 2 and Figure 1 of the paper.
#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "apps/console/command.hpp"
#include "apps/console/interrupt.hpp"
#include "apps/thermal/thermal_views.hpp"
#include "core/file.hpp"
#include "core/json.hpp"
#include "core/sha256.hpp"
#include "core/shipped.hpp"
#include "report/thermal_model.hpp"
#include "simulator/thermal/gyro_model.hpp"
#include "simulator/thermal/mesh.hpp"
#include "simulator/thermal/steady_state.hpp"

namespace gyrotherm::app {
namespace {

/// Columns of the image, 0.5 mm each.
constexpr std::size_t kColumns = 228;
constexpr double kCubicMetres = 1e-9;  ///< m³ per mm³

struct FigureArguments {
  std::string gyro = "calibrated";
  double ambient_c = 20;
};

/// Returns the rows of Table 1 of the paper. The conductivity of air is NaN, because it depends on the gap.
std::vector<report::ReportedMaterial> material_rows(const thermal::GyroModel& model) {
  std::vector<report::ReportedMaterial> all;
  for (std::size_t k = 0; k < thermal::kGyroMaterials; ++k) {
    const thermal::MaterialProperties& one = model.materials[k];
    const double conductivity = one.conductivity_w_per_m_k;
    all.push_back(
        {.name = std::string(thermal::kGyroMaterialNames[k]),
         .density_kg_per_m3 = one.density_kg_per_m3,
         .specific_heat_j_per_kg_k = one.specific_heat_j_per_kg_k,
         .conductivity_w_per_m_k = conductivity > 0 ? conductivity : std::numeric_limits<double>::quiet_NaN()});
  }
  return all;
}

report::ReportedHeatSource make_heat_source(const char* name, double power_w, double volume_mm3) {
  const double volume_m3 = volume_mm3 * kCubicMetres;
  return {.name = name, .power_w = power_w, .volume_m3 = volume_m3, .rate_w_per_m3 = power_w / volume_m3};
}

/// Returns the rows of Table 2 of the paper: both gain arms together, the preamplifier, and one ballast.
std::vector<report::ReportedHeatSource> heat_source_rows(const thermal::GyroModel& model) {
  using thermal::ThermalInput;
  thermal::ThermalPowers powers = model.powers_w;
  const auto power = [&](ThermalInput input) { return input_power(powers, input); };
  const auto& [length, width, thickness] = model.geometry.preamplifier;
  return {make_heat_source("gain_area", power(ThermalInput::gain_left) + power(ThermalInput::gain_right),
                           model.geometry.gain_volume),
          make_heat_source("preamplifier", power(ThermalInput::preamplifier), length * width * thickness),
          make_heat_source("ballast", power(ThermalInput::ballast_left), model.geometry.ballast_volume)};
}

double round_to_millikelvin(double celsius) { return std::round(1000 * celsius) / 1000; }

/// Rounds the temperatures to 1 mK, so different machines print the same result.
void round_temperatures(plot::ThermalImage& image) {
  for (double& value : image.celsius.values) value = round_to_millikelvin(value);
  for (plot::ThermalMark& mark : image.marks) mark.celsius = round_to_millikelvin(mark.celsius);
}

/// Returns the image at steady state on the coarse mesh, with the mesh and the air temperature.
Result<report::ReportedThermalImage> compute_image(const thermal::GyroModel& model, double ambient_c) {
  const bool is_block = model.mode == thermal::GyroMode::block;
  const double film = is_block ? model.block_film_w_per_m2_k : model.still_film_w_per_m2_k;
  const auto mesh = make_mesh(model, thermal::MeshSize::coarse);
  const auto state = steady_state(model, mesh, {.ambient_c = ambient_c, .film_w_per_m2_k = film});
  if (!state) return failure(state.error());
  plot::ThermalImage image = make_top_face(model, mesh, *state, kColumns);
  round_temperatures(image);
  return report::ReportedThermalImage{
      .mesh = "coarse",
      .elements = static_cast<int>(mesh.element_count),
      .nodes = static_cast<int>(state->unknowns),
      .ambient_c = ambient_c,
      .film_w_per_m2_k = film,
      .difference_k = round_to_millikelvin(thermal::gain_difference_k(state->outputs_c)),
      .view = std::move(image)};
}

Result<Exit> print_figure(Console& console, const FigureArguments& options) {
  const auto path = resolve_path(options.gyro, kShippedGyro);
  if (!path) return failure(path.error());
  const auto text = read_text_file(*path);
  if (!text) return failure(text.error());
  const auto model = thermal::parse_gyro(*text, *path);
  if (!model) return failure(model.error());
  watch_for_interrupts(SecondInterrupt::ends);
  auto image = compute_image(*model, options.ambient_c);
  if (!image) return failure(image.error());
  const report::ReportedThermalModel reported{
      .gyro = model->name,
      .title = model->title,
      .gyro_sha256 = sha256(*text),
      .ballast_reading = std::string(thermal::kBallastReadingNames[static_cast<std::size_t>(model->ballast_reading)]),
      .materials = material_rows(*model),
      .sources = heat_source_rows(*model),
      .image = std::move(*image)};
  Json json{{"schema", report::kThermalFigureSchema}, {"simulated", true}};
  json.update(make_json(reported));
  console.print(json_text(json) + "\n");
  return Exit::done;
}

}  // namespace

void add_thermal_figure(Program& program) {
  auto [command, options] =
      add_command(program, "figure",
                  "Prints the data of a gyro's thermal model for a report as JSON: materials, heat sources, and "
                  "temperatures of the block at steady state on the coarse mesh.",
                  "gyrotherm-thermal figure --gyro calibrated", print_figure);
  command.add_option("--gyro", options.gyro, "the gyro file (default: calibrated)")->type_name(value::kGyro);
  command.add_option("--ambient", options.ambient_c, "temperature of the air around the cabinet, °C")
      ->check(CLI::Range(-100.0, 150.0));
}

}  // namespace gyrotherm::app
