#include "backends/opencl/program_text.hpp"

#include "backends/shared/energy_programs.hpp"
#include "kernels/shaders/elastic_steps.h"
#include "kernels/shaders/law_steps.h"

#include <fmt/format.h>
#include <shaders/elastic_opencl.hpp>
#include <shaders/laws_opencl.hpp>
#include <shaders/levels_opencl.hpp>
#include <shaders/loops_opencl.hpp>
#include <shaders/sweep_opencl.hpp>

#include <map>

namespace hdmbench::opencl {

Source source_of(Kernel kernel) {
  using namespace binding;
  static const std::map<Kernel, Source> all{
      // the others are for devices with shared memory
      {Kernel::sweep,
       {"sweep",
        {displacement, improved, material, observation, inverse_curvature, inputs, tiles, flags},
        sources::sweep_opencl}},
      {Kernel::levels,
       {"level_pass",
        {displacement, improved, material, observation, sampled_material, sampled_observation, entries,
         counter},
        sources::levels_opencl}},
      {Kernel::elastic,
       {"elastic_step",
        {ELASTIC_FROM, ELASTIC_SECOND, ELASTIC_THIRD, ELASTIC_STORED, ELASTIC_MOMENTS, ELASTIC_RESPONSE,
         ELASTIC_MATRICES, ELASTIC_INVERSE, ELASTIC_TOUCHED},
        sources::elastic_opencl,
        sizeof(Dispatch::words)}},
      {Kernel::laws,
       {"law_step",
        {LAW_STORED, LAW_SITE_BITS, LAW_SHARES, LAW_LEAST_OF_ITEMS, LAW_DISPLACEMENT, LAW_TISSUE, LAW_FORCES,
         LAW_FIBRES},
        sources::laws_opencl,
        sizeof(Dispatch::words)}},
      {Kernel::loops, {"loop", {source, target}, sources::loops_opencl}}};
  return all.at(kernel);
}

ProgramText program_text(const ProgramKind& kind, std::string_view language, std::string_view of_kernel) {
  const Source source = source_of(kind.kernel);
  ProgramText made{.entry = source.name, .arguments = source.arguments, .told_bytes = source.told_bytes};
  std::string& text = made.bytes;
  text = fmt::format("#define HDM_INPUTS {}\n#define HDM_AXES {}\n", kind.energy->inputs, kind.axes);
  for (const ProgramKind::Constant& constant : kind.constants) {
    text += fmt::format("#define {} {}\n", constant.name, constant.value);
    if (constant.name == "LANES") {
      made.lanes = static_cast<std::size_t>(constant.value);
    }
  }
  text += language;
  text += with_own_texts(of_kernel, *kind.energy, kind.law);
  return made;
}

ProgramText program_text(const ProgramKind& kind) {
  ProgramText made = program_text(kind, "", source_of(kind.kernel).text);
  made.ending = "cl";
  made.options = {std::string(build_options)};
  return made;
}

} // namespace hdmbench::opencl
