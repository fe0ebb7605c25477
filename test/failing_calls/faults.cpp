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

} // namespace

std::span<const Kind> kinds() {
  return all_kinds;
}

Faults& faults() {
  static Faults instance;
  return instance;
}

Faults::Faults() {
  const char* const variable = std::getenv("HDMBENCH_FAILING_CALL");
  const std::string_view text = variable == nullptr ? "" : variable;
  for (const Kind& one : all_kinds) {
    const std::string prefix = fmt::format("{}/{}/", one.api, one.name);
    if (text.starts_with(prefix)) {
      kind_ = &one;
      only_ = text.substr(prefix.size());
    }
  }
  if (kind_ == nullptr && !text.empty()) {
    throw std::invalid_argument(fmt::format("HDMBENCH_FAILING_CALL={} is no API/kind/call", text));
  }
}

void Faults::arm(const Kind& kind, std::size_t at) {
  kind_ = &kind;
  at_ = at;
  only_.clear();
  names.clear();
  struck.reset();
  called.clear();
}

std::optional<std::int64_t> Faults::failure(std::string_view api, const Call& call, bool is_asked_for) {
  if (kind_ == nullptr || kind_->api != api || (kind_->name == missing) != is_asked_for) {
    return {};
  }
  const auto found = is_asked_for && std::ranges::find(names, call.name) != names.end()
                         ? std::ranges::find(names, call.name)
                         : names.insert(names.end(), call.name);
  const bool mine = only_.empty() ? static_cast<std::size_t>(found - names.begin()) + 1 == at_
                                  : only_ == call.name && (is_asked_for || !struck);
  struck = mine ? std::optional(call) : struck;
  return mine ? std::optional(kind_->code) : std::nullopt;
}

std::vector<std::string> Faults::take_complaints() {
  for (const auto& [type, count] : alive_) {
    if (count != 0) {
      complain(fmt::format("{} of {} are left", count, type));
    }
  }
  alive_.clear();
  if (current != 0 && !binding_failed) {
    complain("a context was left current");
  }
  return std::exchange(complaints_, {});
}

void Faults::made(std::string_view type, std::int64_t count) {
  std::int64_t& alive = alive_[std::string(type)];
  alive += count;
  if (alive < 0) {
    complain(fmt::format("{} was destroyed that was not alive", type));
  }
}

void Faults::end_context() {
  std::erase_if(alive_, [&](const auto& objects) {
    const bool in_context = objects.first.starts_with("gl");
    if (in_context && objects.second != 0 && !binding_failed) {
      complain(
          fmt::format("{} of {} were left when their context was destroyed", objects.second, objects.first));
    }
    return in_context;
  });
}

} // namespace hdmbench::failing_calls
