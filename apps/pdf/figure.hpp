// SPDX-License-Identifier: Apache-2.0
/// A figure of plot/ on paper: its SVG text painted as lines and as letters of an embedded font; only for the sources
/// of this folder.
///
/// QSvgRenderer of Qt 6.4 paints letters as outlines with a border, which nobody can select, knows no clipping, and
/// keeps opacity, which PDF/A-1 forbids. So the letters, the regions that clip and the opacity of an SVG as plot/
/// writes it are done here, and the shapes alone are left to it.
#pragma once

#include <QRectF>
#include <QSizeF>
#include <string>

#include "apps/pdf/typesetter.hpp"
#include "core/result.hpp"

namespace gyrotherm::report {

/// In its own pixels. Fails with bad_file where the text is no SVG, or has no size.
[[nodiscard]] Result<QSizeF> size_of_figure(const std::string& svg);

/// Paints the figure over a rectangle of its shape. Colours that let something shine through are mixed with white
/// beforehand. Fails as size_of_figure() does, or where the SVG breaks off.
[[nodiscard]] Result<void> paint_figure(QPainter& painter, const std::string& svg, const QRectF& target,
                                        Typesetter& typesetter);

}  // namespace gyrotherm::report
