// SPDX-License-Identifier: Apache-2.0
/// A virtual gyro's finite-element model as the report shows it: the paper's Tables 1 and 2 and its Figure 1. The
/// program gyrotherm-thermal computes it, since the finite elements are there.
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
  std::string name;  ///< key of the gyro file: "zerodur"
  double density_kg_per_m3{}, specific_heat_j_per_kg_k{};
  double conductivity_w_per_m_k{};  ///< NaN for air
};

/// A row of Table 2.
struct ReportedHeatSource {
  std::string name;  ///< "gain_area" (both arms), "preamplifier", "ballast" (each)
  double power_w{}, volume_m3{}, rate_w_per_m3{};
};

/// Figure 1, and what it was computed of.
struct ReportedThermalImage {
  std::string mesh;  ///< "coarse"
  int elements{}, nodes{};
  double ambient_c{}, film_w_per_m2_k{};
  double difference_k{};  ///< mean A, B, C minus mean F, G, H
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

/// The model, or the reason for which there is none.
struct ReportedThermal {
  std::string missing = "not applicable";  ///< or "not available"; empty with a model
  std::string reason = "no finite-element model of this gyro exists";
  std::optional<ReportedThermalModel> model{};
};

/// Returns what is reported of a virtual gyro whose model cannot be shown.
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
              "expected a model, or a word under \"missing\" and a reason");
}

/// Reads what `gyrotherm-thermal figure` prints. Fails with bad_file, every mistake with its place.
[[nodiscard]] Result<ReportedThermalModel> read_thermal_figure(std::string_view json, const std::string& from);

}  // namespace gyrotherm::report
