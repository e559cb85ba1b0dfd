/// One training from its kernel to a certified solution, with memory handed on from training to training.
#pragma once

#include "analysis/svm/kernel_source.hpp"
#include "analysis/svm/svr.hpp"

namespace gyrotherm {

/// As solve_svr does (svr.hpp); n = source.size() targets.
[[nodiscard]] Result<SvrSolution> solve_svr_from(const KernelSource& source, KernelMemory& memory,
                                                 const Eigen::Ref<const Eigen::VectorXd>& y, double C, double epsilon,
                                                 const SvrOptions& options);

}  // namespace gyrotherm
