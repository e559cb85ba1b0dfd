/// Gaussian process regression (Rasmussen and Williams 2006): squared-exponential covariance with one length per input,
/// which says which inputs matter, and a noise, all by marginal likelihood. One of the two modern methods beside the
/// paper's; the only one here that gives a standard deviation with each prediction.
#pragma once

#include "analysis/methods/method.hpp"

namespace gyrotherm {

/// Choose with choose_nothing: each fit finds its own covariance by the marginal likelihood of its training samples,
/// and held-out samples choose nothing. The likelihood is climbed from three starts, one in the middle and two at
/// random (quick: from the middle alone), on every k-th sample such that at most 400 remain; the function is then made
/// from all. The prediction falls back to the training mean far from what was seen. Effective parameters: the trace.
/// particulars: lengths, and the predictive standard deviation. Fails with numeric if no start has a positive definite
/// covariance.
[[nodiscard]] Result<Fit> fit_gaussian_process(const FitInput& set, const HyperParameters& parameters,
                                               const MethodOptions& options);

}  // namespace gyrotherm
