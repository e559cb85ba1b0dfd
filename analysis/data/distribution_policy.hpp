// SPDX-License-Identifier: Apache-2.0
/// The error policy of Boost.Math's distributions here: a result that does not exist is NaN or infinite, and nothing
/// throws. For .cpp files alone.
#pragma once

#include <boost/math/policies/policy.hpp>

namespace gyrotherm::data {

using DistributionPolicy =
    boost::math::policies::policy<boost::math::policies::domain_error<boost::math::policies::ignore_error>,
                                  boost::math::policies::pole_error<boost::math::policies::ignore_error>,
                                  boost::math::policies::overflow_error<boost::math::policies::ignore_error>,
                                  boost::math::policies::evaluation_error<boost::math::policies::ignore_error>>;

}  // namespace gyrotherm::data
