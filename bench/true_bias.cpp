// SPDX-License-Identifier: Apache-2.0
#include "bench/true_bias.hpp"

#include <fmt/format.h>

#include <cmath>

#include "acquisition/record/record.hpp"
#include "sequencer/run/resume.hpp"
#include "simulator/laboratory_parameters.hpp"
#include "simulator/virtual_laboratory.hpp"

namespace gyrotherm::bench {

Result<Eigen::VectorXd> true_bias(const record::Record& record, const std::string& path) {
  const auto parameters = simulator::parse_laboratory(record.info.rig_text, path, record.info.gyro_model_text);
  if (!parameters) return failure(parameters.error());
  simulator::VirtualLaboratory laboratory(*parameters,
                                          {.gyro = record.info.seed, .run = run::run_number(record.info.profile_text)});
  laboratory.switch_on(true);
  laboratory.change_set_point({record.chamber_set_point_c.front()});
  laboratory.step();  // preparation took one second
  Eigen::VectorXd bias(static_cast<Eigen::Index>(record.slot.size()));
  for (std::size_t i = 0; i < record.slot.size(); ++i) {
    // Drift of the next second, including turn-on.
    const double wander = laboratory.drift()[0].value;
    const auto before = laboratory.pulses()[0];
    laboratory.change_set_point({record.chamber_set_point_c[i]});
    laboratory.step();
    bias(static_cast<Eigen::Index>(i)) = laboratory.true_bias()[0].value + wander;
    if (laboratory.pulses()[0] - before == std::llround(record.units[0].rotation[0][i])) continue;
    return failure(FaultKind::numeric, path,
                   fmt::format("the simulation does not reproduce the pulses of second {}", record.slot[i]));
  }
  return bias;
}

}  // namespace gyrotherm::bench
