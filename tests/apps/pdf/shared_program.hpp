// SPDX-License-Identifier: Apache-2.0
/// The one PdfProgram that a process may have.
#pragma once

#include "apps/pdf/pdf.hpp"

namespace gyrotherm::report {

inline const PdfProgram& shared_program() {
  static const PdfProgram one;
  return one;
}

}  // namespace gyrotherm::report
