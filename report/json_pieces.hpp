/// Small pieces of JSON that several files write alike. `Json` is the includer's JSON type, nlohmann's in its own order
/// of keys; this header does not bring it along.
#pragma once

#include <string>

#include "analysis/data/allan.hpp"
#include "analysis/data/hold_noise.hpp"
#include "analysis/data/statistics.hpp"
#include "analysis/model/verification.hpp"

namespace gyrotherm {

/// NaN becomes null, and text that is not UTF-8 is mended.
template <class Json>
std::string text_of(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

template <class Json, class Vector>
Json json_list(const Vector& values) {
  Json array = Json::array();
  for (const double value : values) array.push_back(value);
  return array;
}

/// A number that is 0 where it is not known, as null then.
template <class Json>
Json json_if_known(double value) {
  return value > 0 ? Json(value) : Json(nullptr);
}

/// With standard errors, null where the effective number is not known.
template <class Json>
Json json_of(const Figures& f) {
  return {{"std_deg_per_h", f.std},
          {"mean_deg_per_h", f.mean},
          {"rmse_deg_per_h", f.rmse},
          {"max_abs_deg_per_h", f.max_abs},
          {"count", f.count},
          {"effective_count", json_if_known<Json>(f.effective.of_std)},
          {"effective_count_of_mean", json_if_known<Json>(f.effective.of_mean)},
          {"std_error_deg_per_h", std_error(f)},
          {"mean_error_deg_per_h", mean_error(f)}};
}

template <class Json>
Json json_of(const OutsideTheRange& outside) {
  return {{"policy", name(outside.policy)},
          {"clusters", outside.clusters},
          {"farthest_term", outside.farthest_term},
          {"farthest", outside.farthest}};
}

template <class Json>
Json json_of(const AllanCurve& curve) {
  Json array = Json::array();
  for (const AllanPoint& point : curve) {
    array.push_back({{"tau_s", point.tau_s},
                     {"deviation_deg_per_h", point.deviation_deg_per_h},
                     {"error_deg_per_h", point.error_deg_per_h},
                     {"differences", point.differences}});
  }
  return array;
}

template <class Json>
Json json_of(const AllanFit& fit) {
  Json json = Json::object();
  for (const NoiseCoefficient& coefficient : fit.coefficients) {
    const NoiseTermInfo& about = info(coefficient.term);
    json[about.symbol] = {{"name", about.name},
                          {"unit", about.unit},
                          {"formula", about.formula},
                          {"read_off_s", about.read_off_s},
                          {"seen", coefficient.seen},
                          {"value", coefficient.seen ? Json(coefficient.value) : Json(nullptr)},
                          {"error", coefficient.seen ? Json(coefficient.error) : Json(nullptr)},
                          {"at_most", coefficient.at_most}};
  }
  return json;
}

template <class Json>
Json json_of(const HoldNoise& noise) {
  Json json = {{"statement", noise.statement},
               {"interval_s", noise.interval_s},
               {"holds", noise.holds},
               {"stretches", noise.stretches},
               {"seconds", noise.seconds},
               {"curve", json_of<Json>(noise.curve)},
               {"coefficients", json_of<Json>(noise.fit)}};
  Json fitted = Json::array();
  for (const AllanPoint& point : noise.curve) fitted.push_back(deviation_of(noise.fit, point.tau_s));
  json["fitted_deg_per_h"] = std::move(fitted);
  json["lowest_tau_s"] = noise.fit.lowest_tau_s;
  json["misfit"] = noise.fit.misfit;
  return json;
}

}  // namespace gyrotherm
