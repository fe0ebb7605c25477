#pragma once

#include "kernels/specification/hdm/energy.hpp"

#include <compare>
#include <cstddef>
#include <map>
#include <set>
#include <vector>

/// A scalar to compile an energy and update.inc with that writes down what is computed from what. Of that
/// graph, what the results need is counted.
namespace hdmbench::counted {

/// How far a number is known where the loop over the sites is compiled.
enum class Knowledge {
  constant,  ///< its value
  invariant, ///< that it is the same at every site
  varying    ///< nothing
};

struct Node {
  char operation; ///< + - * a(bs) <, or v: a number that is given
  std::size_t a = 0;
  std::size_t b = 0;
  Knowledge knowledge = Knowledge::varying;
  float value = 0.0F; ///< of a constant; number of what is given

  auto operator<=>(const Node&) const = default;
};

/// Every distinct computation once: what occurs twice is the same node.
class Graph {
public:
  std::size_t add(const Node& node) {
    const auto [found, is_new] = numbers_.try_emplace(node, nodes_.size());
    if (is_new) {
      nodes_.push_back(node);
    }
    return found->second;
  }
  [[nodiscard]] const Node& operator[](std::size_t number) const { return nodes_[number]; }

  /// What has to be known at the end.
  void need(std::size_t number) { needed_.push_back(number); }

  /// Operations at every site that the needed numbers are computed by.
  [[nodiscard]] int operations() const {
    std::set<std::size_t> seen;
    std::vector<std::size_t> open = needed_;
    int count = 0;
    while (!open.empty()) {
      const std::size_t number = open.back();
      open.pop_back();
      const Node& node = nodes_[number];
      if (node.knowledge != Knowledge::varying || !seen.insert(number).second || node.operation == 'v') {
        continue;
      }
      ++count;
      open.push_back(node.a);
      open.push_back(node.b);
    }
    return count;
  }

private:
  std::vector<Node> nodes_;
  std::map<Node, std::size_t> numbers_;
  std::vector<std::size_t> needed_;
};

/// Of the computation that is being written down.
inline Graph graph;

class real {
public:
  real() = default;
  real(int constant) : real(static_cast<float>(constant)) {}
  real(double constant) : real(static_cast<float>(constant)) {}
  real(float constant)
      : node_(graph.add({.operation = 'v', .knowledge = Knowledge::constant, .value = constant})) {}

  /// Given number `which`.
  [[nodiscard]] static real given(int which, Knowledge knowledge) {
    return real(graph.add({.operation = 'v', .knowledge = knowledge, .value = static_cast<float>(which)}),
                Known{});
  }

  [[nodiscard]] std::size_t node() const { return node_; }

  friend real operator+(const real& a, const real& b) {
    return a.is(0.0F) ? b : b.is(0.0F) ? a : operation('+', a, b);
  }
  friend real operator-(const real& a, const real& b) { return b.is(0.0F) ? a : operation('-', a, b); }
  friend real operator*(const real& a, const real& b) {
    if (a.is(0.0F) || b.is(0.0F)) {
      return {0};
    }
    return a.is(1.0F) ? b : b.is(1.0F) ? a : operation('*', a, b);
  }
  friend real abs(const real& a) { return operation('a', a, a); }
  friend real floor(const real& a) { return operation('f', a, a); }
  // Needed whatever comes of it. A smaller candidate is never found: both are there either way.
  friend bool operator<(const real& a, const real& b) {
    graph.need(operation('<', a, b).node_);
    return false;
  }
  friend bool operator>(const real& a, const real& b) { return b < a; }
  friend bool operator<=(const real& a, const real& b) { return a < b; }
  friend bool operator>=(const real& a, const real& b) { return a < b; }
  friend bool operator==(const real& a, const real& b) { return a < b; }

private:
  struct Known {};
  real(std::size_t node, Known /*tag*/) : node_(node) {}

  [[nodiscard]] bool is(float value) const {
    return graph[node_].knowledge == Knowledge::constant && graph[node_].value == value;
  }
  static real operation(char name, const real& a, const real& b) {
    const bool varies =
        graph[a.node_].knowledge == Knowledge::varying || graph[b.node_].knowledge == Knowledge::varying;
    return real(graph.add({.operation = name,
                           .a = a.node_,
                           .b = b.node_,
                           .knowledge = varies ? Knowledge::varying : Knowledge::invariant}),
                Known{});
  }

  std::size_t node_ = 0;
};

} // namespace hdmbench::counted
