#pragma once

#include "harness/python/result.hpp"
#include "harness/python/scene_arguments.hpp"

/// Two pictures of one person, in Python.
namespace hdmbench::python {

/// What Python gives: arrays of one shape. None is what is not said.
struct PictureArguments {
  py::object source, target, region;
};

/// Registers the pictures as `hdmbench register` does, by Algorithm 6 where `is_iterated`, else by 5: the
/// displacement of the source to the target. Result::met says whether Algorithm 6 converged. `asked` says
/// nothing of accuracy. Called with the GIL, which it gives away meanwhile. Throws InputError, DeviceError,
/// and what Python raises.
[[nodiscard]] std::unique_ptr<Result> register_pictures(const PictureArguments& pictures, SceneToLoad scene,
                                                        Asked asked, bool is_iterated);

} // namespace hdmbench::python
