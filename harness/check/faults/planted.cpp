#include "harness/check/faults/planted.hpp"

#include "harness/check/faults/elastic_faults.hpp"
#include "harness/check/faults/fused_backend.hpp"
#include "harness/check/faults/session_faults.hpp"
#include "harness/check/faults/solution_faults.hpp"

#ifdef HDMBENCH_WITH_GL
#include "harness/check/faults/device_faults.hpp"
#endif

namespace hdmbench::faults {

namespace {

bool is_on_cpu(const Backend& backend) {
  return backend.threads({}) > 0;
}

Planted in_session(const Backend& carrier, const Fault& fault, Expected expected = Expected::disagree) {
  return {.name = fault.name,
          .what = fault.what,
          .backend = std::string(carrier.name()),
          .layer = Layer::session,
          .on_cpu = is_on_cpu(carrier),
          .expected = expected,
          .method = fault.method,
          .make = [&carrier, fault](const Scene& scene) {
            return std::make_unique<FaultyBackend>(carrier, fault, &scene);
          }};
}

std::vector<Planted> session_controls(const Backend& carrier) {
  const auto control = [&](const Fault& fault) { return in_session(carrier, fault, Expected::let_through); };
  return {control({.name = "sound", .what = "no mistake", .method = ""}),
          control(elastic_sums_in_double()),
          control({.name = "negative-zero",
                   .what = "-0 where 0 belongs, which it equals",
                   .method = "",
                   .in_read =
                       [](VectorField& field) {
                         for (auto* const values : {&field.x, &field.y}) {
                           for (float& value : *values) {
                             value = value == 0.0F ? -0.0F : value;
                           }
                         }
                       }}),
          {.name = "fused",
           .what = "fused multiply-adds wherever there can be one",
           .backend = "fused C++",
           .layer = Layer::session,
           .on_cpu = true,
           .expected = Expected::let_through,
           .method = "",
           .make = [](const Scene&) { return make_fused(); }}};
}

} // namespace

std::vector<Planted> all_planted(const Backend& carrier) {
  std::vector<Planted> list = session_controls(carrier);
  for (const Fault& fault : session_faults()) {
    const bool possible = (fault.name != "in-place" || carrier.supports(Update::sequential)) &&
                          (fault.name != "denormals-flushed" || is_on_cpu(carrier));
    if (possible) {
      list.push_back(in_session(carrier, fault));
    }
  }
  for (const auto& faults : {one_piece_faults(), active_faults(), elastic_faults()}) {
    for (const Fault& fault : faults) {
      list.push_back(in_session(carrier, fault));
    }
  }
#ifdef HDMBENCH_WITH_GL
  for (const Pipeline pipeline : pipelines()) {
    for (const auto& faults :
         {device_controls(pipeline), text_faults(pipeline), text_faults_between_sweeps(pipeline),
          text_faults_of_elastic(pipeline), call_faults(pipeline)}) {
      for (const DeviceFault& fault : faults) {
        list.push_back(plant(pipeline, fault));
      }
    }
  }
#endif
  return list;
}

} // namespace hdmbench::faults
