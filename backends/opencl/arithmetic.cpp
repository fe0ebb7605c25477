#include "backends/opencl/arithmetic.hpp"

#include "backends/opencl/programs.hpp"

#include <shaders/language_opencl.hpp>
#include <shaders/probe.hpp>
#include <shaders/probe_opencl.hpp>

namespace hdmbench::opencl {

std::vector<float> evaluate(const Queue& queue, std::span<const ArithmeticCase> cases) {
  std::string text(sources::language_opencl);
  text += sources::probe;
  text += sources::probe_opencl;
  const Kernel kernel = queue.make_kernel(text, build_options, "probe");
  const Buffer source = queue.make_buffer(cases.size_bytes());
  const Buffer target = queue.make_buffer(cases.size_bytes() / 2);
  queue.write_bytes(source, cases.size_bytes(), cases.data());
  kernel.set(0, source);
  kernel.set(1, target);
  queue.run(kernel, cases.size(), 1);
  std::vector<float> texels(4 * cases.size());
  queue.read(target, 0, texels);
  std::vector<float> results;
  for (std::size_t i = 0; i < cases.size(); ++i) {
    results.push_back(texels[4 * i]);
  }
  return results;
}

} // namespace hdmbench::opencl
