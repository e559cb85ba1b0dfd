// SPDX-License-Identifier: Apache-2.0
/// Languages of figures and documents.
#pragma once

namespace gyrotherm::plot {

enum class Language { english, german };

}  // namespace gyrotherm::plot
