#pragma once

#include "kernels/data/input_error.hpp"

#include <string>

namespace hdmbench::test {

/// What the error says that `call` throws; "accepted" where there is none.
template <typename Error = InputError, typename Call>
std::string refusal(const Call& call) {
  try {
    call();
  } catch (const Error& error) {
    return error.what();
  }
  return "accepted";
}

} // namespace hdmbench::test
