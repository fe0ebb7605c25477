#include <backends/registry.hpp>

#include <iostream>

int main() {
  for (const auto& backend : hdmbench::make_backends()) {
    std::cout << backend->name() << ": " << backend->description() << '\n';
  }
  return hdmbench::make_backends().empty() ? 1 : 0;
}
