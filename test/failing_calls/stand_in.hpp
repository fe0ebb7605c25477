#pragma once

#include "test/failing_calls/faults.hpp"

#include <dlfcn.h>

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <vector>

/// One stand-in for the functions of every API: it counts a call, lets it fail where it is its turn, forwards
/// it otherwise, and keeps the books on what is made and ended.
namespace hdmbench::failing_calls {

/// A function of the library whose name a stand-in bears; null where it has none. The library is never
/// closed.
template <typename Pointer>
Pointer real_function(const char* library, const char* name) {
  static void* const handle = dlopen(library, RTLD_NOW | RTLD_LOCAL);
  if (handle == nullptr) {
    std::fprintf(stderr, "stand-in: %s\n", dlerror());
    std::abort();
  }
  return reinterpret_cast<Pointer>(dlsym(handle, name));
}

/// What a function does to objects, by its name.
struct Objects {
  bool made = false;
  bool ended = false;
  std::string_view type{}; ///< "Texture" of glGenTextures and of glDeleteTextures
};

constexpr Objects objects_of(std::string_view name) {
  for (const std::string_view verb :
       {"glDelete", "vkDestroy", "vkFree", "clRelease", "eglDestroy", "OSMesaDestroy", "glGen", "glCreate",
        "vkCreate", "vkAllocate", "clCreate", "eglCreate", "OSMesaCreate"}) {
    if (name.starts_with(verb)) {
      const bool ended = verb.ends_with("Delete") || verb.ends_with("Destroy") || verb.ends_with("Free") ||
                         verb.ends_with("Release");
      std::string_view type = name.substr(verb.size());
      type.remove_suffix(type == "ContextAttribs" ? 7 : type.ends_with("s") ? 1 : 0); // several at once
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

/// Calls visit(handle) for those that a function ends: (..., count, handles), (..., handle, allocator) of
/// Vulkan, or (..., handle).
template <typename Visit, typename... Arguments>
void for_each_ended(std::string_view name, const Visit& visit, Arguments... arguments) {
  const std::tuple all(arguments...);
  constexpr std::size_t count = sizeof...(Arguments);
  if constexpr (count > 1) {
    const auto before = std::get<count - 2>(all);
    if constexpr (std::is_integral_v<decltype(before)>) {
      for (std::size_t i = 0; i < static_cast<std::size_t>(before); ++i) {
        visit(number(std::get<count - 1>(all)[i]));
      }
      return;
    } else if (name.starts_with("vk")) {
      visit(number(before));
      return;
    }
  }
  visit(number(std::get<count - 1>(all)));
}

/// What most APIs have in common.
struct AnyApi {
  template <typename>
  static constexpr bool returns_status = false;
  template <typename>
  static constexpr bool can_fail = true;
  /// What the names of objects belong to.
  static const void* owner() { return nullptr; }
  /// One of them is in the message, where the name is not.
  static std::vector<std::string> words(std::string_view) { return {}; }
  /// False: the call does nothing.
  static bool proceeds(std::string_view) { return true; }
};

/// `Api` is an AnyApi with a name and failure<Result>(name, real, arguments...), which says so as the API
/// does and what the call returns then. `Name` has the function's name as `text`. Overloads for it,
/// before(Name, arguments...) and after(Name, result, arguments...), do what is special; before() says
/// whether the call cleans up. `real` is to be set before the first call.
template <typename Api, typename Name, typename Pointer>
struct StandIn;

template <typename Api, typename Name, typename Result, typename... Arguments>
struct StandIn<Api, Name, Result (*)(Arguments...)> {
  static inline Result (*real)(Arguments...) = nullptr;

  static Result call(Arguments... arguments) {
    constexpr std::string_view name = Name::text;
    constexpr Objects objects = objects_of(name);
    note_call(name);
    bool cleans_up = objects.ended;
    if constexpr (requires { before(Name{}, arguments...); }) {
      cleans_up = before(Name{}, arguments...) || cleans_up;
    }
    if constexpr (objects.ended) {
      for_each_ended(
          name,
          [&](std::uint64_t handle) {
            if (handle != 0) {
              gone(objects.type, Api::owner(), handle);
            }
          },
          arguments...);
    }
    if constexpr (Api::template can_fail<Result>) {
      if (!Api::proceeds(name)) {
        return Result();
      }
      if (fails(Api::name,
                {.name = std::string(name), .words = Api::words(name), .can_fail_unnoticed = cleans_up})) {
        return Api::template failure<Result>(name, real, arguments...);
      }
    }
    if constexpr (std::is_void_v<Result>) {
      real(arguments...);
      note_made(true, arguments...);
    } else {
      const Result result = real(arguments...);
      if constexpr (objects.made && !Api::template returns_status<Result>) {
        if (result != Result()) {
          made(objects.type, Api::owner(), number(result));
        }
      } else if constexpr (Api::template returns_status<Result>) {
        note_made(result == Result(), arguments...);
      }
      if constexpr (requires { after(Name{}, result, arguments...); }) {
        after(Name{}, result, arguments...);
      }
      return result;
    }
  }

private:
  static void note_made([[maybe_unused]] bool succeeded, [[maybe_unused]] Arguments... arguments) {
    if constexpr (objects_of(Name::text).made) {
      const auto handles = std::get<sizeof...(Arguments) - 1>(std::tuple(arguments...));
      for (std::size_t i = 0; succeeded && i < count_of(arguments...); ++i) {
        made(objects_of(Name::text).type, Api::owner(), number(handles[i]));
      }
    }
  }
};

// Of OpenGL, whose functions libEGL and libOSMesa give out (gl.cpp).

using Address = void (*)();

/// The stand-in that forwards to `real`.
template <typename Here>
Address place(Address real) {
  Here::real = reinterpret_cast<decltype(Here::real)>(real);
  return reinterpret_cast<Address>(&Here::call);
}

/// The stand-in for the function of OpenGL of this name, which forwards to `real`; null where it is to be
/// missing. A name that backends/gl/api.hpp does not have, which would escape the test, is complained about.
[[nodiscard]] Address gl_stand_in(const char* name, Address real);

/// A context is no more; another one may get its address.
void gl_context_gone(const void* context);

/// What a library exports: finds the function of the real one when it is called first, as nothing can be
/// found while the library is being loaded.
template <typename Api, typename Name, typename Pointer>
struct Entry;

template <typename Api, typename Name, typename Result, typename... Arguments>
struct Entry<Api, Name, Result (*)(Arguments...)> {
  static Result call(Arguments... arguments) {
    using Here = StandIn<Api, Name, Result (*)(Arguments...)>;
    Here::real = real_function<Result (*)(Arguments...)>(Api::library, Name::text.data());
    return Here::call(arguments...);
  }
};

} // namespace hdmbench::failing_calls

// A type per function, for its name.
#define FAILING_CALLS_NAME(function)                                                                         \
  struct Name##function {                                                                                    \
    static constexpr std::string_view text = #function;                                                      \
  };

// `function` of the library, resolved to its stand-in when the library is loaded.
#define FAILING_CALLS_EXPORT(Api, function)                                                                  \
  extern "C" {                                                                                               \
  __attribute__((visibility("hidden"))) decltype(&::function) resolve_##function() {                         \
    return &hdmbench::failing_calls::Entry<Api, Name##function, decltype(&::function)>::call;                \
  }                                                                                                          \
  __attribute__((visibility("default"), ifunc("resolve_" #function))) decltype(::function) function;         \
  }
#define EXPORTED extern "C" __attribute__((visibility("default")))
