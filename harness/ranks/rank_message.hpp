#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <type_traits>
#include <vector>

namespace hdmbench {

/// Values one after the other as bytes, for another rank of the same program: numbers, lists of them, texts.
class RankMessage {
public:
  template <typename Value>
  void put(const Value& value) {
    if constexpr (requires { value.data(); }) { // a text or a list
      put(std::uint64_t{value.size()});
      append(value.data(), value.size() * sizeof(*value.data()));
    } else {
      static_assert(std::is_trivially_copyable_v<Value>);
      append(&value, sizeof value);
    }
  }

  template <typename Value>
  [[nodiscard]] Value get() {
    Value value;
    if constexpr (requires { value.data(); }) {
      value.resize(get<std::uint64_t>());
      take(value.data(), value.size() * sizeof(*value.data()));
    } else {
      static_assert(std::is_trivially_copyable_v<Value>);
      take(&value, sizeof value);
    }
    return value;
  }

  std::vector<std::byte> bytes;

private:
  void append(const void* from, std::size_t size) {
    const std::size_t end = bytes.size();
    bytes.resize(end + size);
    std::memcpy(bytes.data() + end, from, size);
  }
  void take(void* to, std::size_t size) {
    if (size > 0) {
      std::memcpy(to, bytes.data() + read_, size);
    }
    read_ += size;
  }

  std::size_t read_ = 0;
};

} // namespace hdmbench
