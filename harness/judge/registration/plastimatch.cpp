#include "harness/judge/registration/plastimatch.hpp"

#include "backends/shared/subprocess.hpp"
#include "harness/scene/files.hpp"
#include "harness/scene/images/images.hpp"
#include "kernels/data/input_error.hpp"

#include <fmt/format.h>

#include <string>

namespace hdmbench {

namespace {

/// The parameters of the program: as many iterations as it needs, on every fourth voxel, every second, all.
std::string parameters(const std::filesystem::path& folder) {
  std::string text = fmt::format(
      "[GLOBAL]\nfixed={0}/target.nrrd\nmoving={0}/source.nrrd\nvf_out={0}/field.nrrd\n", folder.string());
  for (const auto& [grid, every] : {std::pair{40, 4}, {20, 2}, {10, 1}}) {
    text +=
        fmt::format("[STAGE]\nxform=bspline\nimpl=plastimatch\nthreading=openmp\nmetric=mse\nmax_its=100\n"
                    "grid_spac={0} {0} {0}\nres={1} {1} {1}\n",
                    grid, every);
  }
  return text;
}

} // namespace

bool have_plastimatch() {
  try {
    return have_images() && run_process({"plastimatch", "--version"}, "/dev/null", "/dev/null").good();
  } catch (const InputError&) {
    return false;
  }
}

PlastimatchRegistration register_by_plastimatch(const ScalarField& source, const ScalarField& target,
                                                double spacing) {
  const TemporaryDirectory folder;
  write_scalar(folder.path() / "source.nrrd", source, spacing);
  write_scalar(folder.path() / "target.nrrd", target, spacing);
  const std::filesystem::path command = folder.path() / "parameters.txt";
  write_text(command, parameters(folder.path()));
  const std::filesystem::path output = folder.path() / "output.txt";
  const ProcessEnd end = run_process({"plastimatch", "register", command.string()}, output, output);
  if (!end.good()) {
    throw InputError(fmt::format("plastimatch {}: {}", end.sentence({}), file_text(output)));
  }
  return {invert(read_displacement(folder.path() / "field.nrrd", true).pixels).displacement, end.seconds};
}

} // namespace hdmbench
