// SPDX-License-Identifier: Apache-2.0
/// The uncertainty that a program is expected to give a unit, before the unit has run: from the record of a unit of the
/// type, which may be the same one.
#pragma once

#include "analysis/data/clusters.hpp"
#include "analysis/model/model.hpp"
#include "analysis/planning/program_path.hpp"
#include "analysis/planning/thermal_response.hpp"
#include "analysis/population/type_prior.hpp"
#include "core/result.hpp"

namespace gyrotherm::planning {

/// Forecasts of programs that are used on one mission. The model starts without knowledge of the unit: each coefficient
/// has the prior N(0, 1) in units of the scaled inputs and the scaled target, or the distribution of a type prior. A
/// program then gives it the covariance, the trained range and the power-ons of its predicted clusters; see assess().
/// Noise, sensitivities and the other rows of the budget are those of the reference record. The model form of a program
/// is that of the reference record times √(½ + ½ V/V₀), V and V₀ the mean variance on the mission after the program and
/// after the program of the reference record.
class Forecast {
 public:
  /// Trains the recommended model on the reference record. Fails like train() or fit_response().
  [[nodiscard]] static Result<Forecast> make(const data::RecordedRun& reference, const ProgramPath& mission,
                                             const ProgressSink& progress = {});

  /// Trains on the reference record with a type prior, for units that will be trained with it. The range of the type
  /// counts as trained. Fails like train_with_prior() or fit_response().
  [[nodiscard]] static Result<Forecast> make_with_prior(const population::TypePrior& prior,
                                                        const data::RecordedRun& reference, const ProgramPath& mission);

  /// Returns the expanded uncertainty of a mean over 1 h that is expected on the mission after a program, °/h. The
  /// program must have a cluster with the unit on.
  [[nodiscard]] Result<double> expanded_after(const ProgramPath& program) const;

  /// Returns the expanded uncertainty of the model of the reference record on the mission, °/h.
  [[nodiscard]] double reference_deg_per_h() const { return reference_deg_per_h_; }
  [[nodiscard]] const model::Model& reference() const { return reference_; }
  [[nodiscard]] const ThermalResponse& response() const { return response_; }

 private:
  /// Knowledge of a unit before its first run: the covariance of the coefficients (slopes, then the constant), and the
  /// range that counts as trained.
  struct Start {
    Eigen::MatrixXd covariance;
    Eigen::RowVectorXd input_min, input_max;
  };

  Forecast(model::Model reference, Start start, ThermalResponse response, data::Clusters mission)
      : reference_(std::move(reference)),
        start_(std::move(start)),
        response_(std::move(response)),
        mission_(std::move(mission)) {}

  /// Fits the response of the reference record and computes its uncertainties, which the forecasts are relative to.
  [[nodiscard]] static Result<Forecast> assemble(model::Model trained, Start start, const data::RecordedRun& reference,
                                                 const ProgramPath& mission);

  /// The model that starts without the reference record, after a program, and its mean variance on the mission, (°/h)².
  struct Learnt {
    model::Model model;
    double on_mission{};
    double in_training{};
  };
  [[nodiscard]] Result<Learnt> learn(const ProgramPath& program) const;

  model::Model reference_;
  Start start_;
  ThermalResponse response_;
  data::Clusters mission_;
  double reference_variance_{};
  double reference_deg_per_h_{};
};

}  // namespace gyrotherm::planning
