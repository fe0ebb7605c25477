// libEGL.so.1, libOSMesa.so.8, libvulkan.so.1 and libOpenCL.so.1 as the backends see them under test: copies
// of this one library, which have their own variables each. A stand-in counts a call, lets it fail where it
// is its turn, forwards it otherwise, and keeps the books on what is made and ended.

#include "test/failing_calls/faults.hpp"

#define GL_GLEXT_PROTOTYPES // for decltype only: nothing is linked against the drivers
#define EGL_EGLEXT_PROTOTYPES
#define CL_TARGET_OPENCL_VERSION 120
#ifdef HDMBENCH_REAL_OPENCL
#include <CL/cl.h>
#else
#define HDMBENCH_REAL_OPENCL ""
#endif
#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <GL/gl.h>
#include <GL/glext.h>
#include <GL/osmesa.h>
#include <fmt/format.h>
#include <vulkan/vulkan_core.h>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <utility>

#include <dlfcn.h>

namespace {

using hdmbench::failing_calls::faults;
using Address = void (*)();

std::int64_t egl_error = EGL_SUCCESS; ///< what eglGetError gives next
std::int64_t gl_error = GL_NO_ERROR;  ///< what glGetError gives next
const void* lost = nullptr;           ///< the OpenGL context that is lost

struct Api {
  std::string_view prefix;
  std::string_view name;
  const char* library; ///< the real one
};

constexpr Api api_of(std::string_view function) {
  for (const Api& api :
       {Api{"egl", "EGL", HDMBENCH_REAL_EGL}, Api{"OSMesa", "OSMesa", HDMBENCH_REAL_OSMESA},
        Api{"vk", "Vulkan", HDMBENCH_REAL_VULKAN}, Api{"cl", "OpenCL", HDMBENCH_REAL_OPENCL}}) {
    if (function.starts_with(api.prefix)) {
      return api;
    }
  }
  return {"gl", "OpenGL", nullptr}; // the libraries of EGL and OSMesa give its functions out
}

/// A function of the real library, of which each copy of this one has its own; null where it has none. The
/// library is never closed.
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
  int made = 0;       ///< -1: it ends them
  bool many = false;  ///< as many as its arguments say
  std::string type{}; ///< "glTexture" of glGenTextures and of glDeleteTextures
};

Objects objects_of(std::string_view function) {
  const std::string_view prefix = api_of(function).prefix;
  for (const std::string_view verb : {"Gen", "Create", "Allocate", "Delete", "Destroy", "Free", "Release"}) {
    if (function.substr(prefix.size()).starts_with(verb)) {
      std::string_view type = function.substr(prefix.size() + verb.size());
      for (const std::string_view ending : {"Attribs", "WithSource"}) {
        type.remove_suffix(type.ends_with(ending) ? ending.size() : 0);
      }
      const bool many = type.ends_with("s");
      type.remove_suffix(many ? 1 : 0);
      type = type == "MemObject" ? "Buffer" : type == "ComputePipeline" ? "Pipeline" : type;
      const bool made = verb == "Gen" || verb == "Create" || verb == "Allocate";
      return {made ? 1 : -1, many, fmt::format("{}{}", prefix, type)};
    }
  }
  return {};
}

/// How many objects a call makes or ends that can do so with many.
template <typename... Arguments>
std::int64_t count_of(Arguments... arguments) {
  std::int64_t count = 1;
  [[maybe_unused]] const auto look = [&](auto argument) {
    if constexpr (requires { argument->commandBufferCount; }) {
      count = argument->commandBufferCount;
    } else if constexpr (requires { argument->descriptorSetCount; }) {
      count = argument->descriptorSetCount;
    } else if constexpr (std::is_integral_v<decltype(argument)>) {
      count = static_cast<std::int64_t>(argument);
    }
  };
  (look(arguments), ...);
  return count;
}

/// The context that a function is to make current.
const void* wanted(EGLDisplay, EGLSurface, EGLSurface, EGLContext context) {
  return context;
}
const void* wanted(OSMesaContext context, void*, GLenum, GLsizei, GLsizei) {
  return context;
}

/// False: a call of OpenGL does nothing.
bool has_context(std::string_view name) {
  if (faults().current == nullptr) {
    faults().complain(fmt::format("{} was called without a current context", name));
  }
  return faults().current != nullptr && faults().current != lost;
}

void finish_drawing();

/// The name of a function, as an argument of a template.
template <std::size_t size>
struct Name {
  constexpr Name(const char (&text)[size]) { std::copy_n(text, size, characters); }
  char characters[size]{};
};

template <Name text, typename Pointer>
struct StandIn;

template <Name text, typename Result, typename... Arguments>
struct StandIn<text, Result (*)(Arguments...)> {
  static constexpr std::string_view name = text.characters;
  static constexpr Api api = api_of(name);
  static constexpr bool returns_handle = std::is_pointer_v<Result> || name.starts_with("glCreate");
  static inline Result (*real)(Arguments...) = nullptr;

  /// From now on it forwards to `address`.
  static Address place(Address address) {
    real = reinterpret_cast<Result (*)(Arguments...)>(address);
    return reinterpret_cast<Address>(&call);
  }

  static Result call(Arguments... arguments) {
    find_real();
    faults().called.emplace(name);
    const bool cleans_up = announce(arguments...);
    if constexpr (api.prefix == "gl") {
      if (!has_context(name)) {
        return Result();
      }
    }
    if constexpr (!std::is_void_v<Result> || api.prefix == "gl") {
      if (const auto code = faults().failure(api.name, {std::string(name), cleans_up})) {
        return fail(*code, arguments...);
      }
    }
    if constexpr (std::is_void_v<Result>) {
      real(arguments...);
      note_made(arguments...);
    } else {
      const Result result = real(arguments...);
      if ((result == Result()) != returns_handle) { // it succeeded
        note_made(arguments...);
      }
      if constexpr (name.ends_with("MakeCurrent")) {
        if (result != Result()) {
          faults().current = wanted(arguments...);
          faults().binding_failed = false;
        }
      }
      return result;
    }
  }

  /// Nothing of an exported function can be found while its library is being loaded.
  static void find_real() {
    if (real == nullptr) {
      real = real_function<Result (*)(Arguments...)>(api.library, name.data());
    }
  }

private:
  static const Objects& objects() {
    static const Objects all = objects_of(name);
    return all;
  }

  /// Notes what the call is about to do; returns whether it cleans up.
  static bool announce([[maybe_unused]] Arguments... arguments) {
    if constexpr (name == "eglBindAPI" || name.ends_with("MakeCurrent")) {
      faults().binding_failed = true; // until a context is current
    }
    if constexpr (name.ends_with("MakeCurrent")) {
      return wanted(arguments...) == nullptr;
    }
    if (objects().made >= 0) {
      return false;
    }
    faults().made(objects().type, objects().many ? -count_of(arguments...) : -1);
    if constexpr (api.prefix != "cl" && name.ends_with("DestroyContext")) {
      faults().end_context();
      lost = nullptr; // another one may get its address
    }
    return true;
  }

  /// Says so as the API does.
  static Result fail(std::int64_t code, Arguments... arguments) {
    if constexpr (api.prefix == "cl" && std::is_pointer_v<Result>) {
      *std::get<sizeof...(Arguments) - 1>(std::tuple(arguments...)) = static_cast<std::int32_t>(code);
      return nullptr;
    } else if constexpr (api.prefix == "cl" || api.prefix == "vk") {
      // What cleans up does its work all the same. Waiting that fails leaves the work of the device behind;
      // on a device that is lost it is over.
      if (objects().made < 0 || (name == "vkWaitForFences" && code == VK_ERROR_DEVICE_LOST)) {
        real(arguments...);
      }
      return static_cast<Result>(code);
    } else {
      if constexpr (api.prefix == "egl") {
        egl_error = code;
      } else if constexpr (api.prefix == "gl") {
        if (code != GL_CONTEXT_LOST) {
          gl_error = code;
        } else {
          lost = faults().current;
          finish_drawing(); // what is lost draws no more
        }
      }
      return Result();
    }
  }

  static void note_made(Arguments... arguments) {
    if constexpr (name.starts_with("clEnqueue")) { // an event, where one is wanted
      const bool wants_event = std::get<sizeof...(Arguments) - 1>(std::tuple(arguments...)) != nullptr;
      faults().made("clEvent", wants_event ? 1 : 0);
    }
    if (objects().made > 0) {
      faults().made(objects().type, objects().many ? count_of(arguments...) : 1);
    }
  }
};

void finish_drawing() {
  StandIn<"glFinish", decltype(&::glFinish)>::real();
}

// How the others say that they failed: they cannot fail themselves.

template <>
EGLint StandIn<"eglGetError", EGLint (*)()>::call() {
  find_real();
  return egl_error != EGL_SUCCESS ? static_cast<EGLint>(std::exchange(egl_error, EGL_SUCCESS)) : real();
}

template <>
GLenum StandIn<"glGetError", GLenum (*)()>::call() {
  faults().called.emplace(name);
  if (!has_context(name) && faults().current != nullptr) {
    return GL_CONTEXT_LOST; // every time: whoever waits for the last error waits for ever
  }
  return gl_error != GL_NO_ERROR ? static_cast<GLenum>(std::exchange(gl_error, GL_NO_ERROR)) : real();
}

/// The stand-in for the function of this name, which forwards to `real`; null where it is to be missing, and
/// for what the Vulkan backend does not use: should it begin to, its functions.inc needs a line. A function
/// of OpenGL that would escape the test is complained about. vkDestroyInstance is never missing: nobody could
/// make good for that.
Address stand_in(std::string_view name, Address real) {
  const std::string_view api = api_of(name).prefix == "vk" ? "Vulkan" : "OpenGL";
#define FUNCTION(known)                                                                                      \
  if (name == #known) {                                                                                      \
    const bool can_miss = name != "vkDestroyInstance";                                                       \
    const bool absent = can_miss && faults().failure(api, {.name = #known}, true);                           \
    return real == nullptr || absent ? nullptr : StandIn<#known, decltype(&::known)>::place(real);           \
  }
  FUNCTION(eglGetPlatformDisplayEXT)
  FUNCTION(eglQueryDevicesEXT)
  FUNCTION(glGetError)
#include <given_functions.inc>
#undef FUNCTION
  if (api == "Vulkan" || real == nullptr) {
    return nullptr;
  }
  faults().complain(fmt::format("{} has no stand-in", name));
  return real;
}

} // namespace

#define EXPORTED extern "C" __attribute__((visibility("default")))

EXPORTED Address eglGetProcAddress(const char* name) {
  static const auto real = real_function<decltype(&::eglGetProcAddress)>(HDMBENCH_REAL_EGL, __func__);
  return stand_in(name, real(name));
}

EXPORTED Address OSMesaGetProcAddress(const char* name) {
  static const auto real = real_function<decltype(&::OSMesaGetProcAddress)>(HDMBENCH_REAL_OSMESA, __func__);
  return stand_in(name, real(name));
}

/// The loader's own functions serve every instance and device.
EXPORTED Address vkGetInstanceProcAddr(VkInstance /*instance*/, const char* name) {
  const std::string_view asked = name;
  if (asked == "vkGetInstanceProcAddr") {
    return reinterpret_cast<Address>(&vkGetInstanceProcAddr);
  }
  if (asked == "vkGetDeviceProcAddr") {
    const PFN_vkGetDeviceProcAddr of_device = [](VkDevice, const char* wanted) {
      return vkGetInstanceProcAddr(nullptr, wanted);
    };
    return reinterpret_cast<Address>(of_device);
  }
  return stand_in(asked, real_function<Address>(HDMBENCH_REAL_VULKAN, name));
}

// A function of the library, resolved to its stand-in when it is asked for.
#define FUNCTION(function)                                                                                   \
  extern "C" {                                                                                               \
  __attribute__((visibility("hidden"))) decltype(&::function) resolve_##function() {                         \
    return &StandIn<#function, decltype(&::function)>::call;                                                 \
  }                                                                                                          \
  __attribute__((visibility("default"), ifunc("resolve_" #function))) decltype(::function) function;         \
  }
#include <exported_functions.inc>
