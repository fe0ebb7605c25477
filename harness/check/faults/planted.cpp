#include "harness/check/faults/planted.hpp"

#include "harness/check/faults/fused_backend.hpp"
#include "harness/check/faults/session_faults.hpp"

#ifdef HDMBENCH_WITH_GL
#include "harness/check/faults/device_faults.hpp"
#endif

namespace hdmbench::faults {

std::vector<Planted> all_planted(const Backend& carrier) {
  std::vector<Planted> list;
  const bool on_cpu = carrier.threads({}) > 0;
  const auto add = [&](const std::vector<Fault>& faults, Expected expected) {
    for (const Fault& fault : faults) {
      const bool possible = (fault.name != "in-place" || carrier.supports(Update::sequential)) &&
                            (fault.name != "denormals-flushed" || on_cpu);
      if (possible) {
        list.push_back(
            {.name = fault.name,
             .what = fault.what,
             .backend = std::string(carrier.name()),
             .layer = Layer::session,
             .on_cpu = on_cpu,
             .expected = expected,
             .method = fault.method,
             .make = [&carrier, fault] { return std::make_unique<FaultyBackend>(carrier, fault); }});
      }
    }
  };
  add(session_controls(), Expected::let_through);
  list.push_back({.name = "fused",
                  .what = "fused multiply-adds wherever there can be one",
                  .backend = "fused C++",
                  .layer = Layer::session,
                  .on_cpu = true,
                  .expected = Expected::let_through,
                  .method = "",
                  .make = make_fused});
  for (const auto& faults : {session_faults(), one_piece_faults(), active_faults(), elastic_faults()}) {
    add(faults, Expected::disagree);
  }
#ifdef HDMBENCH_WITH_GL
  for (const Pipeline pipeline : pipelines()) {
    for (const auto& faults : {text_faults(pipeline), call_faults(pipeline)}) {
      for (const DeviceFault& fault : faults) {
        list.push_back(plant(pipeline, fault));
      }
    }
  }
#endif
  return list;
}

} // namespace hdmbench::faults
