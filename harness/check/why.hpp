#pragma once

#include "harness/check/certificate.hpp"
#include "harness/check/rewritten_real.hpp"

#include <array>
#include <cstddef>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace hdmbench {

/// What a compiler or a device may have done to the arithmetic that its bits are others.
struct Explanation {
  /// Those that make what was found of the sites that were looked at, or the nearest to that.
  std::vector<rewritten::Rewrite> rewrites{};
  std::size_t sites = 0;     ///< that were looked at; about half of them differ
  std::size_t differing = 0; ///< of these
  std::size_t explained = 0; ///< sites, differing or not, that `rewrites` make as they were found
  std::size_t tried = 0;     ///< rewrites
  /// Other single rewrites that make all of them, too.
  std::vector<rewritten::Rewrite> others{};

  [[nodiscard]] bool is_complete() const { return sites > 0 && explained == sites; }
  /// One sentence for people; empty where nothing was looked at.
  [[nodiscard]] std::string text() const;
};

/// "a product is fused into the sum that follows in hdm/energy.inc, line 24".
[[nodiscard]] std::string text_of(const rewritten::Rewrite& rewrite);

/// Sites of steps in which a backend found something else than the specification, and sites beside them.
class Evidence {
public:
  /// Computes a site in the arithmetic of rewritten_real.hpp.
  using AtSite = std::function<SiteAnswer(int x, int y, int z)>;

  /// A step of a kind on a level, for which at_site keeps fields of so many sites.
  struct Step {
    int level = 0;
    int kind = 0;
    std::size_t sites_kept = 0;
    int cost = 1; ///< to compute a site, beside other steps
  };

  /// Whether another such step would tell more and its fields are worth their memory.
  [[nodiscard]] bool wants(const Step& step) const;

  /// Keeps some of the sites of a step that made `found` in place of `expected`; none where at_site, without
  /// rewrites, has not the bits of `expected`. What at_site needs must live as long as this object.
  void add(const Step& step, const VectorField& expected, const VectorField& found, const AtSite& at_site);

  /// Computes the sites again with each rewrite of each line, then with those together that explain more.
  [[nodiscard]] Explanation explain() const;

private:
  struct Sample {
    AtSite at_site;
    std::array<int, 3> at{};
    SiteAnswer found{};
    bool differs = false;
    int cost = 1;
  };

  /// Counts the sites that come out as they were found; 0 where they are fewer than `least`.
  [[nodiscard]] std::size_t explained_by(std::span<const rewritten::Rewrite> rewrites,
                                         std::size_t least) const;
  [[nodiscard]] std::vector<rewritten::Rewrite> possible() const;
  /// A few of the sites.
  [[nodiscard]] Evidence part() const;
  /// Without rewrites.
  [[nodiscard]] Explanation counted() const;
  void keep_complete(Explanation& found, const std::vector<rewritten::Rewrite>& all) const;
  [[nodiscard]] Explanation by_fused_lines(const std::vector<rewritten::Rewrite>& all,
                                           rewritten::Kind kind) const;
  [[nodiscard]] Explanation by_several(const std::vector<rewritten::Rewrite>& all) const;

  /// How many there are, and in which sites they differ, by level and kind.
  std::map<std::pair<int, int>, std::pair<int, std::size_t>> steps_;
  std::size_t sites_kept_ = 0;
  std::vector<Sample> samples_; ///< those that differ first
};

} // namespace hdmbench
