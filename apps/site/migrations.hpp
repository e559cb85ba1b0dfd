// SPDX-License-Identifier: Apache-2.0
/// The schema of the store as SQL: the files of apps/site/migrations, embedded, one for each step. A step that was
/// released is not edited; a change is a step of its own.
#pragma once

#include <string_view>

namespace gyrotherm::site {

[[nodiscard]] std::string_view store_schema();

}  // namespace gyrotherm::site
