// SPDX-License-Identifier: Apache-2.0
#define GYROTHERM_DENSE
#include "analysis/dense/dense.hpp"
