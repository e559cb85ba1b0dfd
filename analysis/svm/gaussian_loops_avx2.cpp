// SPDX-License-Identifier: Apache-2.0
// Compiled for AVX2 (see CMakeLists.txt). Must not include code that other object files of the program also compile.
#include "analysis/svm/gaussian_loops.hpp"

namespace gyrotherm::svm {

#ifdef __AVX2__
namespace {

GYROTHERM_GAUSSIAN_LOOPS(PlainLanes<32>);

}  // namespace

const GaussianLoops* gaussian_loops_avx2() { return &kLoops; }
#else
const GaussianLoops* gaussian_loops_avx2() { return nullptr; }
#endif

}  // namespace gyrotherm::svm
