// SPDX-License-Identifier: Apache-2.0
/// One small face for every regression method: what it is called, how it chooses its hyper-parameters on held-out
/// folds, how it fits, and what every fit ends in. The table of methods is in method.cpp; a new method is one file and
/// one row.
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

/// What every method ends in is one of four functions of the scaled inputs z, in units of the target's STD from the
/// target's mean. The first is f(z) = Σ β_i exp(−‖z − v_i‖²/(2σ²)) + b.
struct SvrModel {
  data::SampleMatrix support_vectors;  ///< scaled
  Eigen::VectorXd beta;
  double b{};
  svm::SvrParameters parameters;
  double relative_gap{};
  double kkt_violation{};
};

/// f(z) = w·z + b.
struct LinearModel {
  Eigen::VectorXd weights;
  double b{};
};

/// f(z) = Σ_k w_k exp(−½ Σ_j ((z_j − c_kj)/(l_j s_k))²) + a·z + b.
struct ExpansionModel {
  data::SampleMatrix centres;  ///< k × inputs, scaled
  Eigen::RowVectorXd lengths;  ///< l, > 0, one per input; ones unless the method weighs its inputs
  Eigen::VectorXd widths;      ///< s, > 0, one per centre
  Eigen::VectorXd weights;     ///< w, one per centre
  double b{};
  Eigen::VectorXd slope = {};  ///< a, one per input; empty: there is no plane
};

/// The variance of what a Gaussian process predicts, in units of the target's variance: of its plane and of what m of
/// its samples say of the rest, φ(z)ᵀSφ(z) + σ_f² − |w(z)|², φ = (z, w(z)), w(z) = L⁻¹k(z),
/// k_i(z) = σ_f² exp(−½ Σ_j ((z_j − c_ij)/l_j)²), LLᵀ = k at the c. What the m samples do not say of the others counts
/// as their noise (the fully independent training conditional of Quiñonero-Candela and Rasmussen, J. Mach. Learn. Res.
/// 6 (2005) 1939: with all samples as c it is the exact one). Noise of one target is not in it.
struct PredictiveVariance {
  data::SampleMatrix centres;   ///< c, m × inputs, scaled
  Eigen::RowVectorXd lengths;   ///< l, > 0, one per input
  double signal{};              ///< σ_f, > 0
  double noise{};               ///< σ_n, of one target, ≥ 0
  Eigen::MatrixXd posterior{};  ///< S, (inputs + m) × (inputs + m)
  Eigen::MatrixXd root{};       ///< L, m × m, lower triangular, its diagonal above 0
};

/// Returns the variance of a plane z·w + b as a PredictiveVariance: `open` is the covariance of (w, b), `noise` that of
/// one target, both in units of the target's. The constant is a single Gaussian so wide that it is 1 everywhere.
[[nodiscard]] PredictiveVariance variance_of_plane(Eigen::MatrixXd open, double noise);

/// φ at each row, rows × (inputs + m).
[[nodiscard]] Eigen::MatrixXd features_of(const PredictiveVariance& variance, const data::SampleMatrix& scaled);

/// The variance of f at each row. `scaled` has the function's number of inputs.
[[nodiscard]] Eigen::VectorXd variance_of(const PredictiveVariance& variance, const data::SampleMatrix& scaled);

/// f(z) = Σ_k v_k tanh(w_k·z + u_k) + b.
struct NetworkModel {
  data::SampleMatrix weights;  ///< w, hidden units × inputs
  Eigen::VectorXd offsets;     ///< u, one per hidden unit
  Eigen::VectorXd out;         ///< v, one per hidden unit
  double b{};
};

using Function = std::variant<SvrModel, LinearModel, ExpansionModel, NetworkModel>;

/// The value of the function at each row. `scaled` has the function's number of inputs.
[[nodiscard]] Eigen::VectorXd value_of(const Function& function, const data::SampleMatrix& scaled);

/// Returns the value at each row with the plane taken at `scaled` and everything else, Gaussians and hidden units, at
/// the same row of `bounded`. A linear function is all plane. Both have the function's number of inputs.
[[nodiscard]] Eigen::VectorXd value_of(const Function& function, const data::SampleMatrix& scaled,
                                       const data::SampleMatrix& bounded);

/// How many numbers the function stores: its size in a navigation computer.
[[nodiscard]] int numbers_in(const Function& function);

/// A named number that a method chose: "lambda", "hidden units".
struct HyperParameter {
  std::string name;
  double value{};
};
using HyperParameters = std::vector<HyperParameter>;

void describe(auto& form, Like<HyperParameter> auto& parameter) {
  form("name", parameter.name);
  form("value", parameter.value);
}

/// The value of that name, which must be among them.
[[nodiscard]] double value_of(const HyperParameters& parameters, std::string_view name);

/// One held-out fold as methods see it: what there is to learn and to predict, and of what its columns are.
struct Fold : svm::TuningFold {
  std::vector<data::Term> terms;
  Eigen::MatrixXd input_covariance = {};  ///< as in FitInput, of the training rows
};

struct MethodOptions {
  svm::TuningOptions tuning{};  ///< of the support vector methods
  std::uint64_t seed = 1;       ///< of methods that start at random
  double tight_gap = 0;         ///< > 0: the support vector methods try for this relative gap first
  bool quick = false;           ///< a try: methods that search long search less
  /// Standard uncertainties, K, of the clusters' thermometers. Only for methods that weigh them.
  std::vector<double> thermometer_uncertainty_k = {};
};

/// Hyper-parameters and how they were come by.
struct Choice {
  HyperParameters parameters;
  std::optional<svm::TuningSummary> tuning;  ///< support vector methods only
  std::vector<std::string> warnings;
};

/// What one fit learns from. Inputs are scaled; targets are in units of their training STD from their training mean.
struct FitInput {
  const data::SampleMatrix& x;
  const Eigen::VectorXd& y;
  const std::vector<data::Term>& terms;  ///< of the columns of x
  /// What the thermometers' uncertainty makes of x, on average over the set (data::input_covariance, scaled); empty
  /// where x is to be taken as exact.
  Eigen::MatrixXd input_covariance = {};
};

struct Fit {
  Function function;
  double effective_parameters{};  ///< trace of the matrix from targets to fitted values, or the method's nearest to it
  std::string particulars = {};   ///< in words, what else is worth knowing; may be empty
  /// Of a method that knows it: all but the SVRs, the networks and what is made of them. A plane's takes residuals as
  /// independent.
  std::optional<PredictiveVariance> variance = {};
};

/// Chooses hyper-parameters by held-out error alone. Fails with usage or interrupted. No folds, no choice: an empty
/// span is an error for a method that has something to choose.
using ChooseFunction = Result<Choice>(std::span<const Fold> folds, const MethodOptions& options,
                                      const ProgressSink& progress);
/// Fits with these hyper-parameters. Fails with usage (too few samples, values that are not finite) or numeric.
using FitFunction = Result<Fit>(const FitInput& set, const HyperParameters& parameters, const MethodOptions& options);

struct Method {
  std::string_view name;      ///< what --method takes
  std::string_view title;     ///< for the report
  std::string_view citation;  ///< of its published form
  std::string_view inputs;    ///< what it takes in where the user does not say: a word of --inputs
  std::array<std::string_view, 5> compared_on = {};  ///< what else it is compared on in the qualification; "": nothing
  ChooseFunction* choose;
  FitFunction* fit;
  /// A filter of the bias of the training clusters before anything is learnt, or null. Never applied to what is held
  /// out.
  Eigen::VectorXd (*filter)(const data::Clusters& training) = nullptr;
  bool tunes_svr = false;           ///< its choice is of C, sigma and epsilon, by tune_svr
  bool weighs_uncertainty = false;  ///< of the thermometers: its fits are given an input_covariance
};

/// All of them, the paper's own first.
[[nodiscard]] std::span<const Method> methods();

/// Fails with usage, naming the nearest.
[[nodiscard]] Result<const Method*> find_method(std::string_view name);

}  // namespace gyrotherm::methods
