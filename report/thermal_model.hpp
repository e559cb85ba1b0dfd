// SPDX-License-Identifier: Apache-2.0
/// The finite-element model of a virtual gyro for the report: Tables 1 and 2 and Figure 1 of the paper. The program
/// gyrotherm-thermal, which contains the finite elements, computes it.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/form.hpp"
#include "core/result.hpp"
#include "report/plot/thermal_image.hpp"

namespace gyrotherm::report {

inline constexpr const char* kThermalFigureSchema = "gyrotherm-thermal-figure/1";

/// A row of Table 1.
struct ReportedMaterial {
  std::string name;  ///< key of the gyro file
  double density_kg_per_m3{}, specific_heat_j_per_kg_k{};
  double conductivity_w_per_m_k{};  ///< NaN for air
};

/// A row of Table 2.
struct ReportedHeatSource {
  /// "gain_area" (both arms), "preamplifier" or "ballast" (each).
  std::string name;
  double power_w{}, volume_m3{}, rate_w_per_m3{};
};

/// Figure 1 and the parameters of its computation.
struct ReportedThermalImage {
  std::string mesh;  ///< "coarse"
  int elements{}, nodes{};
  double ambient_c{}, film_w_per_m2_k{};
  double difference_k{};  ///< mean(A,B,C) − mean(F,G,H)
  plot::ThermalImage view;
};

struct ReportedThermalModel {
  std::string gyro, title;
  std::string gyro_sha256;      ///< hash of the gyro file
  std::string ballast_reading;  ///< such as "rate x volume"
  std::vector<ReportedMaterial> materials;
  std::vector<ReportedHeatSource> sources;
  ReportedThermalImage image;
};

/// The finite-element model, or the reason why it is missing.
struct ReportedThermal {
  std::string missing = "not applicable";  ///< or "not available"; empty with model
  std::string reason = "no finite-element model of this gyro exists";
  std::optional<ReportedThermalModel> model{};
};

/// Returns the entry for a virtual gyro whose finite-element model is not available.
[[nodiscard]] inline ReportedThermal not_available(std::string reason) {
  return {.missing = "not available", .reason = std::move(reason)};
}

void describe(auto& form, Like<ReportedMaterial> auto& material) {
  form("name", material.name);
  form("density_kg_per_m3", material.density_kg_per_m3);
  form("specific_heat_j_per_kg_k", material.specific_heat_j_per_kg_k);
  form("conductivity_w_per_m_k", material.conductivity_w_per_m_k);
}

void describe(auto& form, Like<ReportedHeatSource> auto& source) {
  form("name", source.name);
  form("power_w", source.power_w);
  form("volume_m3", source.volume_m3);
  form("rate_w_per_m3", source.rate_w_per_m3);
}

void describe(auto& form, Like<ReportedThermalImage> auto& image) {
  form("mesh", image.mesh);
  form("elements", image.elements);
  form("nodes", image.nodes);
  form("ambient_c", image.ambient_c);
  form("film_w_per_m2_k", image.film_w_per_m2_k);
  form("difference_k", image.difference_k);
  form("view", image.view);
}

void describe(auto& form, Like<ReportedThermalModel> auto& model) {
  form("gyro", model.gyro);
  form("title", model.title);
  form("gyro_sha256", model.gyro_sha256);
  form("materials", model.materials);
  form("sources", model.sources);
  form("ballast_reading", model.ballast_reading);
  form("image", model.image);
}

void describe(auto& form, Like<ReportedThermal> auto& thermal) {
  form("missing", thermal.missing);
  form("reason", thermal.reason);
  form("model", thermal.model);
  form.expect("model", thermal.model.has_value() == thermal.missing.empty(),
              "expected either a model, or \"missing\" with a reason");
}

/// Reads the output of `gyrotherm-thermal figure`. Fails with bad_file and lists every error with its position.
[[nodiscard]] Result<ReportedThermalModel> read_thermal_figure(std::string_view json, const std::string& from);

}  // namespace gyrotherm::report
