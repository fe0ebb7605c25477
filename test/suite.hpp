#pragma once

// What suites are written in: GoogleTest and its matchers, texts, containers, algorithms, numbers. A suite
// takes these from here, and from a header of test/ what that header includes.

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <limits>
#include <map>
#include <memory>
#include <numbers>
#include <numeric>
#include <optional>
#include <ostream>
#include <random>
#include <set>
#include <span>
#include <sstream>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

namespace hdmbench {

using testing::AllOf, testing::ContainsRegex, testing::ElementsAre, testing::HasSubstr, testing::IsEmpty,
    testing::Not;

} // namespace hdmbench
