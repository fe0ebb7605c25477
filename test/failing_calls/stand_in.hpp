#pragma once

#include "test/failing_calls/faults.hpp"

#include <dlfcn.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <iterator>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <vector>

#define EXPORTED extern "C" __attribute__((visibility("default")))

/// One stand-in for the functions of every API: it counts a call, lets it fail where it is its turn, forwards
/// it otherwise, and keeps the books on what is made and ended. What a function does besides is an overload
/// for the type of its name, NameXyz:
///   special(NameXyz, real, arguments...)  in place of forwarding it
///   answered(NameXyz, arguments...)       after it was forwarded and succeeded: the answer may be made worse
namespace hdmbench::failing_calls {

/// The library whose name a stand-in bears. Never closed.
class RealLibrary {
public:
  explicit RealLibrary(const char* path) : handle_(dlopen(path, RTLD_NOW | RTLD_LOCAL)) {
    if (handle_ == nullptr) {
      std::fprintf(stderr, "stand-in: %s\n", dlerror());
      std::abort();
    }
  }

  /// Null where it has no such function.
  template <typename Function>
  [[nodiscard]] Function function(const char* name) const {
    return reinterpret_cast<Function>(dlsym(handle_, name));
  }

private:
  void* handle_;
};

/// What a function does to objects, by its name.
struct Objects {
  bool made = false;
  bool ended = false;
  std::string_view type{}; ///< "Texture" of glGenTextures and of glDeleteTextures
};

constexpr Objects objects_of(std::string_view name) {
  for (const std::string_view verb : {"glGen", "glCreate", "vkCreate", "vkAllocate", "clCreate", "glDelete",
                                      "vkDestroy", "vkFree", "clRelease"}) {
    if (name.starts_with(verb)) {
      const bool ended = verb == "glDelete" || verb == "vkDestroy" || verb == "vkFree" || verb == "clRelease";
      std::string_view type = name.substr(verb.size());
      type.remove_suffix(type.ends_with("s") ? 1 : 0); // several at once
      type = name == "clCreateBuffer"      ? "MemObject"
             : type == "ProgramWithSource" ? "Program"
             : type == "ComputePipeline"   ? "Pipeline"
                                           : type;
      return {!ended, ended, type};
    }
  }
  return {};
}

template <typename Handle>
std::uint64_t number(Handle handle) {
  if constexpr (std::is_pointer_v<Handle>) {
    return reinterpret_cast<std::uint64_t>(handle);
  } else {
    return static_cast<std::uint64_t>(handle);
  }
}

/// How many handles a function writes behind its last argument.
template <typename... Arguments>
std::size_t count_of(Arguments... arguments) {
  std::size_t count = 1;
  const auto look = [&](auto argument) {
    if constexpr (requires { argument->commandBufferCount; }) {
      count = argument->commandBufferCount;
    } else if constexpr (requires { argument->descriptorSetCount; }) {
      count = argument->descriptorSetCount;
    } else if constexpr (std::is_integral_v<decltype(argument)>) {
      count = static_cast<std::size_t>(argument);
    }
  };
  (look(arguments), ...);
  return count;
}

/// The handles that a function ends: its only argument, (..., count, handles), or the last argument but one
/// before Vulkan's allocator.
template <typename... Arguments>
std::vector<std::uint64_t> ended_by(Arguments... arguments) {
  const std::tuple all(arguments...);
  constexpr std::size_t count = sizeof...(Arguments);
  if constexpr (count == 1) {
    return {number(std::get<0>(all))};
  } else if constexpr (std::is_integral_v<std::tuple_element_t<count - 2, std::tuple<Arguments...>>>) {
    std::vector<std::uint64_t> handles;
    std::transform(std::get<count - 1>(all), std::get<count - 1>(all) + std::get<count - 2>(all),
                   std::back_inserter(handles), [](auto handle) { return number(handle); });
    return handles;
  } else {
    return {number(std::get<count - 2>(all))};
  }
}

/// `Api` says how calls fail:
///   owner()                          what the names of objects belong to
///   proceeds<Result>(name)           false: the call fails
///   failure<Result>(name, real, arguments...)  what it returns then
///   makes_nothing(name)              an object's name is 0, without an error
///   succeeded(result)
/// `Name` has the function's name as `text`. `real` is to be set before the first call.
template <typename Api, typename Name, typename Pointer>
struct StandIn;

template <typename Api, typename Name, typename Result, typename... Arguments>
struct StandIn<Api, Name, Result (*)(Arguments...)> {
  static inline Result (*real)(Arguments...) = nullptr;

  static Result call(Arguments... arguments) {
    constexpr std::string_view name = Name::text;
    constexpr Objects objects = objects_of(name);
    note_call(name);
    if constexpr (objects.ended) {
      for (const std::uint64_t handle : ended_by(arguments...)) {
        if (handle != 0) {
          gone(objects.type, Api::owner(), handle);
        }
      }
    }
    if (!Api::template proceeds<Result>(name)) {
      return Api::template failure<Result>(name, real, arguments...);
    }
    if constexpr (requires { special(Name{}, real, arguments...); }) {
      return special(Name{}, real, arguments...);
    } else if constexpr (std::is_void_v<Result>) {
      if (objects.made && Api::makes_nothing(name)) {
        if constexpr (objects.made) {
          std::fill_n(last(arguments...), count_of(arguments...), 0U);
        }
        return;
      }
      real(arguments...);
      note_success(arguments...);
    } else {
      if (objects.made && Api::makes_nothing(name)) {
        return Result();
      }
      const Result result = real(arguments...);
      if constexpr (objects.made && !Api::template returns_status<Result>) {
        if (result != Result()) {
          made(objects.type, Api::owner(), number(result));
        }
      } else if (Api::succeeded(result)) {
        note_success(arguments...);
      }
      return result;
    }
  }

private:
  static auto last(Arguments... arguments) {
    return std::get<sizeof...(Arguments) - 1>(std::tuple(arguments...));
  }

  static void note_success([[maybe_unused]] Arguments... arguments) {
    constexpr Objects objects = objects_of(Name::text);
    if constexpr (objects.made) {
      for (std::size_t i = 0; i < count_of(arguments...); ++i) {
        made(objects.type, Api::owner(), number(last(arguments...)[i]));
      }
    }
    if constexpr (requires { answered(Name{}, arguments...); }) {
      answered(Name{}, arguments...);
    }
  }
};

// Of OpenGL, whose functions libEGL and libOSMesa give out (gl_calls.cpp).

using Address = void (*)();

/// The stand-in for the function of OpenGL of this name, which forwards to `real`; null where the armed fault
/// is that it is missing. A name that backends/gl/api.hpp does not have, which would escape the test, is
/// complained about.
[[nodiscard]] Address gl_stand_in(const char* name, Address real);

/// A context is no more; another one may get its address.
void gl_context_gone(const void* context);

} // namespace hdmbench::failing_calls

// A type per function, for its name; to be redefined for other lists.
#define FAILING_CALLS_NAME(function)                                                                         \
  struct Name##function {                                                                                    \
    static constexpr std::string_view text = #function;                                                      \
  };
