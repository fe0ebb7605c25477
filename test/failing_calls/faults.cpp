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
    Kind{"EGL", "EGL_BAD_ALLOC", EGL_BAD_ALLOC, "EGL_BAD_ALLOC"},
    Kind{"OSMesa", "NULL or false", 0, "failed"},
    Kind{"OpenGL", "GL_OUT_OF_MEMORY", GL_OUT_OF_MEMORY, "GL_OUT_OF_MEMORY"},
    Kind{"OpenGL", "GL_INVALID_OPERATION", GL_INVALID_OPERATION, "GL_INVALID_OPERATION"},
    Kind{"OpenGL", "GL_CONTEXT_LOST", GL_CONTEXT_LOST, "GL_CONTEXT_LOST"},
    Kind{"OpenGL", missing, 0, "has no"},
    Kind{"Vulkan", "OUT_OF_HOST_MEMORY", VK_ERROR_OUT_OF_HOST_MEMORY, "ErrorOutOfHostMemory"},
    Kind{"Vulkan", "OUT_OF_DEVICE_MEMORY", VK_ERROR_OUT_OF_DEVICE_MEMORY, "ErrorOutOfDeviceMemory"},
    Kind{"Vulkan", "INITIALIZATION_FAILED", VK_ERROR_INITIALIZATION_FAILED, "ErrorInitializationFailed"},
    Kind{"Vulkan", "DEVICE_LOST", VK_ERROR_DEVICE_LOST, "ErrorDeviceLost"},
    Kind{"Vulkan", missing, 0, "has no"},
    Kind{"OpenCL", "CL_OUT_OF_RESOURCES", -5, "CL_OUT_OF_RESOURCES"},
    Kind{"OpenCL", "CL_OUT_OF_HOST_MEMORY", -6, "CL_OUT_OF_HOST_MEMORY"},
};

using Object = std::tuple<std::string, const void*, std::uint64_t>; // type, owner, handle

struct State {
  const Kind* kind = nullptr;
  int at = 0;
  std::string only;               ///< name of the call that fails, instead of `at`
  std::vector<std::string> names; ///< of functions that were asked for
  Tally tally;
  std::set<Object> alive;
  const void* current = nullptr;
  bool binding_failed = false; ///< since the last time that it did not
  std::vector<std::string> complaints;

  /// HDMBENCH_FAILING_CALL="OpenGL/GL_OUT_OF_MEMORY/glReadPixels" arms any program.
  State() {
    const char* const variable = std::getenv("HDMBENCH_FAILING_CALL");
    const std::string_view text = variable == nullptr ? "" : variable;
    for (const Kind& one : all_kinds) {
      const std::string prefix = fmt::format("{}/{}/", one.api, one.name);
      if (text.starts_with(prefix)) {
        kind = &one;
        only = text.substr(prefix.size());
      }
    }
    if (kind == nullptr && !text.empty()) {
      throw std::invalid_argument(fmt::format("HDMBENCH_FAILING_CALL={} is no API/kind/call", text));
    }
  }
};

State& state() {
  static State instance;
  return instance;
}

/// The call with this number fails if it is its turn.
bool strikes(int number, const Call& call) {
  State& s = state();
  s.tally.calls = std::max(s.tally.calls, number);
  const bool again = s.kind->name == missing || !s.tally.struck;
  const bool mine = s.only.empty() ? number == s.at : s.only == call.name && again;
  if (mine) {
    s.tally.struck = true;
    s.tally.call = call;
  }
  return mine;
}

} // namespace

std::span<const Kind> kinds() {
  return all_kinds;
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

bool fails(std::string_view api, const Call& call) {
  const Kind* const kind = state().kind;
  if (kind == nullptr || kind->api != api || kind->name == missing) {
    return false;
  }
  state().tally.names.push_back(call.name);
  return strikes(state().tally.calls + 1, call);
}

bool is_missing(std::string_view api, std::string_view name) {
  State& s = state();
  if (s.kind == nullptr || s.kind->api != api || s.kind->name != missing) {
    return false;
  }
  auto found = std::ranges::find(s.names, name);
  if (found == s.names.end()) {
    found = s.names.emplace(s.names.end(), name);
  }
  return strikes(static_cast<int>(found - s.names.begin()) + 1, {.name = std::string(name)});
}

std::int64_t code() {
  return state().kind->code;
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
