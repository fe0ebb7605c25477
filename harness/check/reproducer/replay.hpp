// A step as its device was told it, for every API: step.inc has it, reproduce.cpp does it again, and
// compared() says whether the bits are as expected.

#pragma once

#include <cstdint>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <functional>
#include <iterator>
#include <stdexcept>
#include <string>
#include <vector>

/// Bytes of an element: floats two by two or four by four, which programs fetch as texels, or words.
enum Kind { pairs = 8, fours = 16, words = 4 };

/// An array of the device, and the file of what it has before the step.
struct Array {
  Kind kind;
  const char* before;
};

/// What the driver's compiler is given.
struct Program {
  const char* file;
  const char* entry;
  std::vector<const char*> options;
  unsigned lanes; // invocations of a work group where the text does not say
};

/// An array at a binding, or in the order of a kernel's arguments; -1: none.
struct Bound {
  unsigned binding;
  int array;
};

/// A program on arrays, told words and floats after them; or where there is no program, the bytes of a file
/// into the first array.
struct Command {
  int program;
  std::vector<Bound> arrays;
  std::vector<std::int32_t> told;
  std::vector<float> steps;
  unsigned step_count;    // of them; the others pad
  std::size_t told_bytes; // of words and floats together
  unsigned groups[3];     // work groups
  bool waits;             // for what the command before it writes
  const char* written;
  std::size_t first; // byte
};

/// Bytes that the step makes, from byte `first` of an array on, and the files of what they should be and of
/// what they were when this was written.
struct Made {
  int array;
  std::size_t first;
  const char* expected;
  const char* found;
};

#include "step.inc"

inline std::string bytes_of(const std::string& name) {
  std::ifstream file(name, std::ios::binary);
  if (!file) {
    throw std::runtime_error(name + " cannot be read: run this in its own folder");
  }
  return {std::istreambuf_iterator<char>(file), {}};
}

/// Words, then floats, as they are told after each other.
inline std::string told_of(const Command& command) {
  std::string bytes(command.told_bytes, '\0');
  const std::size_t first = command.told.size() * 4;
  std::memcpy(bytes.data(), command.told.data(), first);
  std::memcpy(bytes.data() + first, command.steps.data(), command.steps.size() * 4);
  return bytes;
}

/// Compares what the step made with what it should have: read(array, first, bytes). Prints the first words
/// that differ. Returns the exit status: 0 where all are as expected, else 1.
inline int compared(const std::function<std::string(int, std::size_t, std::size_t)>& read) {
  std::size_t numbers = 0, wrong = 0, as_found = 0;
  for (const Made& made : all_made) {
    const std::string expected = bytes_of(made.expected), found = bytes_of(made.found);
    const std::string now = read(made.array, made.first, expected.size());
    for (std::size_t at = 0; at + 4 <= expected.size(); at += 4, ++numbers) {
      std::uint32_t bits[3];
      float value[3];
      const char* const from[] = {&expected[at], &now[at], &found[at]};
      for (int i = 0; i < 3; ++i) {
        std::memcpy(&bits[i], from[i], 4);
        std::memcpy(&value[i], from[i], 4);
      }
      if (bits[0] != bits[1] && (bits[0] | bits[1]) << 1 != 0) { // 0 and -0 are one
        as_found += bits[1] == bits[2];
        if (wrong++ < 5) {
          std::printf("array %d, float %zu: expected %.9g (%08x), computed %.9g (%08x)\n", made.array,
                      (made.first + at) / 4, value[0], bits[0], value[1], bits[1]);
        }
      }
    }
  }
  std::printf("%zu of %zu numbers are not as expected, %zu of these as they were found\n", wrong, numbers,
              as_found);
  return wrong > 0 ? 1 : 0;
}
