#include "test/failing_calls/faults.hpp"

#include <EGL/egl.h>
#include <GL/gl.h>
#include <GL/glext.h>
#include <fmt/format.h>
#include <vulkan/vulkan_core.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <stdexcept>
#include <tuple>
#include <utility>

namespace hdmbench::failing_calls {

namespace {

constexpr std::array all_kinds{
    Kind{"EGL_BAD_ALLOC", "EGL", Event::egl_call, EGL_BAD_ALLOC, "EGL_BAD_ALLOC"},
    Kind{"EGL_CONTEXT_LOST", "EGL", Event::egl_current, EGL_CONTEXT_LOST, "EGL_CONTEXT_LOST"},
    Kind{"nothing offered", "EGL", Event::egl_answer, 0, "", true},
    Kind{"NULL or false", "OSMesa", Event::osmesa_call, 0, "failed"},
    Kind{"GL_OUT_OF_MEMORY", "OpenGL", Event::gl_call, GL_OUT_OF_MEMORY, "GL_OUT_OF_MEMORY"},
    Kind{"GL_INVALID_OPERATION", "OpenGL", Event::gl_call, GL_INVALID_OPERATION, "GL_INVALID_OPERATION"},
    Kind{"GL_CONTEXT_LOST", "OpenGL", Event::gl_call, GL_CONTEXT_LOST, "GL_CONTEXT_LOST"},
    Kind{"function missing", "OpenGL", Event::look_up, 0, "has no", true},
    Kind{"no name made", "OpenGL", Event::gl_name, 0, "made nothing"},
    Kind{"framebuffer incomplete", "OpenGL", Event::gl_framebuffer, GL_FRAMEBUFFER_UNSUPPORTED, "0x8cdd"},
    Kind{"shader refused", "OpenGL", Event::gl_compilation, 0, "the planted log"},
    Kind{"limit too small", "OpenGL", Event::gl_answer, 0, "", true},
    Kind{"OUT_OF_HOST_MEMORY", "Vulkan", Event::vulkan_call, VK_ERROR_OUT_OF_HOST_MEMORY,
         "ErrorOutOfHostMemory"},
    Kind{"OUT_OF_DEVICE_MEMORY", "Vulkan", Event::vulkan_call, VK_ERROR_OUT_OF_DEVICE_MEMORY,
         "ErrorOutOfDeviceMemory"},
    Kind{"INITIALIZATION_FAILED", "Vulkan", Event::vulkan_call, VK_ERROR_INITIALIZATION_FAILED,
         "ErrorInitializationFailed"},
    Kind{"DEVICE_LOST", "Vulkan", Event::vulkan_call, VK_ERROR_DEVICE_LOST, "ErrorDeviceLost"},
    Kind{"function missing", "Vulkan", Event::look_up, 0, "has no", true},
    Kind{"device too poor", "Vulkan", Event::vulkan_answer, 0, "", true},
    Kind{"CL_OUT_OF_RESOURCES", "OpenCL", Event::opencl_call, -5, "CL_OUT_OF_RESOURCES"},
    Kind{"CL_OUT_OF_HOST_MEMORY", "OpenCL", Event::opencl_call, -6, "CL_OUT_OF_HOST_MEMORY"},
    Kind{"program refused", "OpenCL", Event::opencl_build, 0, "the planted log"},
    Kind{"device too poor", "OpenCL", Event::opencl_answer, 0, "", true},
};

using Object = std::tuple<std::string, const void*, std::uint64_t>; // type, owner, handle

struct State {
  const Kind* kind = nullptr;
  int at = 0;
  std::string only;               ///< name of the call that fails, instead of `at`
  std::vector<std::string> names; ///< that a kind for good could befall, in the order of their first call
  Tally tally;
  std::set<Object> alive;
  const void* current = nullptr;
  bool binding_failed = false; ///< since the last time that it did not
  std::vector<std::string> complaints;

  /// HDMBENCH_FAILING_CALL="OpenGL/GL_OUT_OF_MEMORY/glReadPixels" arms any program.
  State() {
    const char* variable = std::getenv("HDMBENCH_FAILING_CALL");
    const std::string text = variable == nullptr ? "" : variable;
    const auto first = text.find('/');
    const auto second = text.find('/', first + 1);
    if (second != std::string::npos) {
      kind = &kind_of(text.substr(0, first), text.substr(first + 1, second - first - 1));
      only = text.substr(second + 1);
    }
  }
};

State& state() {
  static State instance;
  return instance;
}

/// The number of the call among those that can be struck.
int number_of(const std::string& call) {
  State& s = state();
  if (!s.kind->for_good) {
    return ++s.tally.calls;
  }
  auto found = std::ranges::find(s.names, call);
  if (found == s.names.end()) {
    s.names.push_back(call);
    s.tally.calls = static_cast<int>(s.names.size());
    found = s.names.end() - 1;
  }
  return static_cast<int>(found - s.names.begin()) + 1;
}

} // namespace

std::span<const Kind> kinds() {
  return all_kinds;
}

const Kind& kind_of(std::string_view api, std::string_view name) {
  const auto* const found =
      std::ranges::find_if(all_kinds, [&](const Kind& kind) { return kind.api == api && kind.name == name; });
  if (found == all_kinds.end()) {
    throw std::invalid_argument(fmt::format("{} has no kind of fault \"{}\"", api, name));
  }
  return *found;
}

void arm(const Kind& kind, int at) {
  state().kind = &kind;
  state().at = at;
  state().only.clear();
  state().names.clear();
  state().tally = {};
}

void disarm() {
  state().kind = nullptr;
}

const Tally& tally() {
  return state().tally;
}

bool strikes(Event event, const Call& call) {
  State& s = state();
  if (s.kind == nullptr || s.kind->event != event) {
    return false;
  }
  const int number = number_of(call.name);
  const bool once = !s.tally.struck || s.kind->for_good;
  const bool mine = s.only.empty() ? number == s.at : s.only == call.name && once;
  if (mine) {
    s.tally.struck = true;
    s.tally.call = call;
  }
  return mine;
}

const Kind& armed() {
  return *state().kind;
}

void note_call(std::string_view name) {
  if (!state().tally.called.contains(name)) {
    state().tally.called.emplace(name);
  }
}

void complain(std::string what) {
  state().complaints.push_back(std::move(what));
}

std::vector<std::string> take_complaints() {
  State& s = state();
  for (const auto& [type, owner, handle] : s.alive) {
    complain(fmt::format("{} is left", type));
  }
  s.alive.clear();
  if (s.current != nullptr && !s.binding_failed) {
    complain("a context was left current");
  }
  return std::exchange(s.complaints, {});
}

void made(std::string_view type, const void* owner, std::uint64_t handle) {
  if (!state().alive.emplace(type, owner, handle).second) {
    complain(fmt::format("{} was made again while it was alive", type));
  }
}

void gone(std::string_view type, const void* owner, std::uint64_t handle) {
  if (state().alive.erase({std::string(type), owner, handle}) == 0) {
    complain(fmt::format("{} was destroyed that was not alive", type));
  }
}

void owner_gone(const void* owner) {
  std::erase_if(state().alive, [&](const Object& object) {
    const auto& [type, its_owner, handle] = object;
    if (its_owner == owner && !state().binding_failed) {
      complain(fmt::format("{} was left when its context was destroyed", type));
    }
    return its_owner == owner;
  });
}

void set_current(const void* context) {
  state().current = context;
  state().binding_failed = false;
}

void could_not_set_current() {
  state().binding_failed = true;
}

const void* current() {
  return state().current;
}

} // namespace hdmbench::failing_calls
