// SPDX-License-Identifier: Apache-2.0
/// The schema of the store as SQL, in the steps in which it came to be: the files of apps/site/migrations, embedded. A
/// step that was ever released is not edited; what changes is a step of its own.
#pragma once

#include <string_view>

namespace gyrotherm::site {

[[nodiscard]] std::string_view store_schema();
[[nodiscard]] std::string_view fleet_questions();
[[nodiscard]] std::string_view document_owners();
[[nodiscard]] std::string_view simulated_apart();
[[nodiscard]] std::string_view bounds_of_rigs();
[[nodiscard]] std::string_view rigs_apart();
[[nodiscard]] std::string_view alarm_rows();
[[nodiscard]] std::string_view zeros_in_conditions();

}  // namespace gyrotherm::site
