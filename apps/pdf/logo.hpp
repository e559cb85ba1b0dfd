// SPDX-License-Identifier: Apache-2.0
/// The laboratory's own picture. It comes from outside and is not trusted; only for the sources of this folder.
#pragma once

#include <QImage>

#include "core/result.hpp"
#include "report/calibration.hpp"

namespace gyrotherm::report {

/// The picture on white, no more than `most` pixels large, in its own shape: paper has no transparency, and whatever an
/// SVG may hold ends here. Fails with bad_file where it is no base64, no picture, larger than a logo ever is, or an SVG
/// that refers to something outside itself, or holds what can make a small file much work: entities, scripts, copies
/// (use), dashes, pictures in it that are not part of it.
[[nodiscard]] Result<QImage> picture_of(const Logo& logo, QSize most);

}  // namespace gyrotherm::report
