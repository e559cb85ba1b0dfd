/// What one second does to a reduced model, as a function of the temperature of the air in its gaps.
///
/// The step's matrices depend smoothly on that temperature (entire functions of coefficients that are analytic above
/// 0 K), so that a polynomial through the Chebyshev points of −80 … 130 °C gives them to rounding (L. N. Trefethen,
/// Approximation Theory and Approximation Practice, ch. 5 and 8). An update then costs one product, and the state never
/// leaves the basis of the reduced model: no change of modes has to be carried along.
#pragma once

#include <Eigen/Core>

#include "thermal/reduced/reduced_model.hpp"

namespace gyrotherm {

class StepTable final {
 public:
  StepTable(const ReducedModel& model, GyroFilm film);

  /// The step in force from now on; temperatures beyond the table count as its ends.
  void update(double air_c);
  /// One second while the air outside goes from one temperature to the other; update() must have been called.
  void step(Eigen::VectorXd& states, double from_c, double to_c);

 private:
  Eigen::VectorXd nodes_c_;
  Eigen::VectorXd weights_;  ///< barycentric
  Eigen::MatrixXd table_;    ///< one column per node: carry, before, after, powers
  Eigen::VectorXd now_;      ///< likewise, at the temperature of the update
  Eigen::VectorXd next_;
};

}  // namespace gyrotherm
