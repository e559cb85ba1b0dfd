// SPDX-License-Identifier: Apache-2.0
#include "apps/gyrotherm/qualify/accept.hpp"

#include <fmt/format.h>

#include "report/report.hpp"

namespace gyrotherm::app {

Result<void> check_accept(const profile::Profile& profile, const std::string& file) {
  for (const profile::AcceptLimit& limit : profile.accept)
    if (const auto checked = report::check_limit(limit.key); !checked)
      return failure(FaultKind::bad_file, file,
                     fmt::format("[accept] names \"{}\", {}", limit.key, checked.error().what));
  return {};
}

}  // namespace gyrotherm::app
