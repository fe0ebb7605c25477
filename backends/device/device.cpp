#include "backends/device/device.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <utility>

namespace hdmbench {

Array::Array(ComputeDevice& device, std::size_t count, Kind kind)
    : device_(device), count_(count), kind_(kind) {
  device_.allocated_ += bytes();
}

Array::~Array() {
  device_.allocated_ -= bytes();
}

std::unique_ptr<Array> ComputeDevice::allocate(std::size_t count, Kind kind) {
  const auto require = [&](std::size_t needed, std::size_t limit, const char* what) {
    if (needed > limit) {
      throw TooLarge(
          fmt::format("{}: {} {} are needed, the device has {}", description().name, needed, what, limit));
    }
  };
  const std::size_t bytes = count * bytes_of(kind);
  if (kind != Kind::words) {
    require(count, limits().elements, "texel buffer elements");
  }
  require(bytes, limits().array_bytes, "bytes in one allocation");
  require(allocated_ + bytes, limits().memory, "bytes of memory");
  return make(count, kind);
}

std::vector<std::unique_ptr<Program>> ComputeDevice::compile_all(std::span<const ProgramKind> kinds) {
  std::vector<std::unique_ptr<Program>> programs;
  std::ranges::transform(kinds, std::back_inserter(programs),
                         [&](const ProgramKind& kind) { return compile(kind); });
  return programs;
}

std::span<std::byte> ComputeDevice::staging() {
  staging_.resize(staging_bytes);
  return staging_;
}

const Program& Programs::operator()(const ProgramKind& kind) {
  auto found = programs_.find(kind);
  if (found == programs_.end()) {
    found = programs_.emplace(kind, device_.compile(kind)).first;
  }
  return *found->second;
}

void Programs::prepare(std::vector<ProgramKind> kinds) {
  std::erase_if(kinds, [&](const ProgramKind& kind) { return programs_.contains(kind); });
  std::vector<std::unique_ptr<Program>> compiled = device_.compile_all(kinds);
  for (std::size_t i = 0; i < kinds.size(); ++i) {
    programs_.emplace(std::move(kinds[i]), std::move(compiled[i]));
  }
}

void make_room(ComputeDevice& device, std::unique_ptr<Array>& array, std::size_t count, Kind kind) {
  if (array == nullptr || array->count() != count || array->kind() != kind) {
    array.reset(); // before the new one, so that both need not fit
    array = device.allocate(count, kind);
  }
}

} // namespace hdmbench
