// SPDX-License-Identifier: Apache-2.0
/// The calibration report as a page: one file that needs no network, for a screen of any width and for paper.
#pragma once

#include <string>

#include "report/document.hpp"

namespace gyrotherm::report {

/// The document as HTML. Figures can be enlarged and have a cursor where scripts run, by dygraphs; without them, on
/// paper, and where an axis is logarithmic, they are the document's SVGs. The mark of the document stands above the
/// page and on every sheet. Equal documents give equal bytes.
[[nodiscard]] std::string html_of(const Document& document);

}  // namespace gyrotherm::report
