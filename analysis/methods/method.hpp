// SPDX-License-Identifier: Apache-2.0
/// Common interface of all regression methods: name, choice of hyper-parameters on held-out folds, fit, and the
/// functions that a fit can return. The table of methods is in method.cpp. A new method needs one file and one row of
/// the table.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "analysis/data/clusters.hpp"
#include "analysis/data/features.hpp"
#include "analysis/svm/svr.hpp"
#include "analysis/svm/tuning.hpp"
#include "core/form.hpp"
#include "core/result.hpp"

namespace gyrotherm::methods {

/// Support vector function f(z) = Σ β_i exp(−‖z − v_i‖²/(2σ²)) + b. This and the next three structs are the functions
/// that a fit can return. They take scaled inputs z and return values relative to the target mean, in units of the
/// target STD.
struct SvrModel {
  data::SampleMatrix support_vectors;  ///< scaled
  Eigen::VectorXd beta;
  double b{};
  svm::SvrParameters parameters;
  double relative_gap{};
  double kkt_violation{};
};

/// Linear function f(z) = w·z + b.
struct LinearModel {
  Eigen::VectorXd weights;
  double b{};
};

/// Expansion f(z) = Σ_k w_k exp(−½ Σ_j ((z_j − c_kj)/(l_j s_k))²) + a·z + b.
struct ExpansionModel {
  data::SampleMatrix centres;  ///< k × inputs, scaled
  /// l > 0, one per input. Ones unless the method weights its inputs.
  Eigen::RowVectorXd lengths;
  Eigen::VectorXd widths;   ///< s > 0, one per centre
  Eigen::VectorXd weights;  ///< w, one per centre
  double b{};
  /// a, one per input. Empty if there is no plane.
  Eigen::VectorXd slope = {};
};

/// Variance of the prediction of a Gaussian process with a plane, in units of the target's variance: φ(z)ᵀSφ(z) + σ_f²
/// − |w(z)|², φ = (z, w(z)), w(z) = L⁻¹k(z), k_i(z) = σ_f² exp(−½ Σ_j ((z_j − c_ij)/l_j)²), LLᵀ = k between the c_i.
/// Only m samples c_i are stored. The other samples are modelled by these m samples, and the part that they do not
/// explain is treated as noise. This is the fully independent training conditional of Quiñonero-Candela and Rasmussen,
/// J. Mach. Learn. Res. 6 (2005) 1939; if all samples are stored, the variance is exact. The noise of a single target
/// is not included.
struct PredictiveVariance {
  data::SampleMatrix centres;   ///< c, m × inputs, scaled
  Eigen::RowVectorXd lengths;   ///< l > 0, one per input
  double signal{};              ///< σ_f > 0
  double noise{};               ///< σ_n ≥ 0 of one target
  Eigen::MatrixXd posterior{};  ///< S, (inputs + m) × (inputs + m)
  /// L, m × m, lower triangular with a positive diagonal.
  Eigen::MatrixXd root{};
};

/// Returns the variance of a plane z·w + b as a PredictiveVariance. `open` is the covariance of (w, b), and `noise` is
/// the noise of one target; both are in units of the target. The constant is represented by a single Gaussian so wide
/// that it is 1 everywhere.
[[nodiscard]] PredictiveVariance plane_variance(Eigen::MatrixXd open, double noise);

/// Computes φ at each row: rows × (inputs + m).
[[nodiscard]] Eigen::MatrixXd compute_features(const PredictiveVariance& variance, const data::SampleMatrix& scaled);

/// Computes the variance of f at each row. `scaled` must have one column per input of the function.
[[nodiscard]] Eigen::VectorXd evaluate_variance(const PredictiveVariance& variance, const data::SampleMatrix& scaled);

/// Network function f(z) = Σ_k v_k tanh(w_k·z + u_k) + b.
struct NetworkModel {
  data::SampleMatrix weights;  ///< w, hidden units × inputs
  Eigen::VectorXd offsets;     ///< u, one per hidden unit
  Eigen::VectorXd out;         ///< v, one per hidden unit
  double b{};
};

using Function = std::variant<SvrModel, LinearModel, ExpansionModel, NetworkModel>;

/// Evaluates the function at each row. `scaled` must have one column per input of the function.
[[nodiscard]] Eigen::VectorXd evaluate_function(const Function& function, const data::SampleMatrix& scaled);

/// Evaluates the plane of the function at each row of `scaled`, and the other parts of the function (Gaussians, hidden
/// units) at the same row of `bounded`. A linear function has no other parts. Both must have one column per input of
/// the function.
[[nodiscard]] Eigen::VectorXd evaluate_function(const Function& function, const data::SampleMatrix& scaled,
                                                const data::SampleMatrix& bounded);

/// Counts the parameters that the function stores, a measure of its size in a navigation computer.
[[nodiscard]] int count_stored_numbers(const Function& function);

/// Named value chosen by a method: "lambda", "hidden units".
struct HyperParameter {
  std::string name;
  double value{};
};
using HyperParameters = std::vector<HyperParameter>;

void describe(auto& form, Like<HyperParameter> auto& parameter) {
  form("name", parameter.name);
  form("value", parameter.value);
}

/// Returns the value with the given name, which must exist.
[[nodiscard]] double parameter_value(const HyperParameters& parameters, std::string_view name);

/// One held-out fold, and the terms in its columns.
struct Fold : svm::TuningFold {
  std::vector<data::Term> terms;
  Eigen::MatrixXd input_covariance = {};  ///< FitInput::input_covariance of the training rows
};

struct MethodOptions {
  /// Options of the support vector methods.
  svm::TuningOptions tuning{};
  /// Seed of methods with a random start.
  std::uint64_t seed = 1;
  /// Smaller relative gap that the support vector methods try to reach first, if > 0.
  double tight_gap = 0;
  /// Shortens long searches, for trial runs.
  bool quick = false;
  /// Standard uncertainties of the thermometers of the clusters, K. Used only by methods with Method::uses_uncertainty.
  std::vector<double> thermometer_uncertainty_k = {};
};

/// Chosen hyper-parameters, with the record of the choice.
struct Choice {
  HyperParameters parameters;
  std::optional<svm::TuningSummary> tuning;  ///< support vector methods only
  std::vector<std::string> warnings;
};

/// Training set of one fit. Inputs are scaled; targets are relative to their training mean, in units of their training
/// STD.
struct FitInput {
  const data::SampleMatrix& x;
  const Eigen::VectorXd& y;
  const std::vector<data::Term>& terms;  ///< columns of x
  /// Mean covariance of the errors of x caused by the uncertainty of the thermometers (data::input_covariance, scaled).
  /// Empty if x is taken as exact.
  Eigen::MatrixXd input_covariance = {};
};

struct Fit {
  Function function;
  /// Trace of the matrix from targets to fitted values, or the closest equivalent of the method.
  double effective_parameters{};
  /// Further information as text. May be empty.
  std::string particulars = {};
  /// Predictive variance, if the method computes it: all except the SVRs, the networks and methods based on them. The
  /// variance of a plane assumes independent residuals.
  std::optional<PredictiveVariance> variance = {};
};

/// Chooses hyper-parameters by held-out error only. Fails with usage or interrupted. An empty `folds` is a usage fault
/// for methods with hyper-parameters.
using ChooseFunction = Result<Choice>(std::span<const Fold> folds, const MethodOptions& options,
                                      const ProgressSink& progress);
/// Fits with the given hyper-parameters. Fails with usage (too few samples, values that are not finite) or with
/// numeric.
using FitFunction = Result<Fit>(const FitInput& set, const HyperParameters& parameters, const MethodOptions& options);

struct Method {
  /// Value of --method.
  std::string_view name;
  /// Title in the report.
  std::string_view title;
  /// Citation of the published form.
  std::string_view citation;
  /// Default inputs, as a value of --inputs.
  std::string_view inputs;
  /// Further values of --inputs on which the qualification compares the method. "" for none.
  std::array<std::string_view, 5> compared_on = {};
  ChooseFunction* choose;
  FitFunction* fit;
  /// Filter for the bias of the training clusters before training, or null. Never applied to held-out clusters.
  Eigen::VectorXd (*filter)(const data::Clusters& training) = nullptr;
  /// Set if the method chooses C, sigma and epsilon by tune_svr.
  bool tunes_svr = false;
  /// Set if the fits receive an input_covariance from the uncertainty of the thermometers.
  bool uses_uncertainty = false;
};

/// Returns all methods, the method of the paper first.
[[nodiscard]] std::span<const Method> methods();

/// Finds a method by name. Fails with usage and suggests the nearest name.
[[nodiscard]] Result<const Method*> find_method(std::string_view name);

}  // namespace gyrotherm::methods
