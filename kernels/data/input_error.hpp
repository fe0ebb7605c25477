#pragma once

#include <stdexcept>

namespace hdmbench {

/// The user's input cannot be computed on: what() says what was wrong, where, and what to do. The command
/// line turns it into exit status 2.
class InputError : public std::runtime_error {
public:
  using std::runtime_error::runtime_error;
};

/// A file that the input refers to, or what is needed to read it, is not on this machine.
class MissingFile : public InputError {
public:
  using InputError::InputError;
};

} // namespace hdmbench
