#include "test/r300/vector_candidates.hpp"

#include "backends/gl/objects.hpp"

#include <fmt/format.h>
#include <shaders/sweep_fragment.hpp>

#include <stdexcept>
#include <string_view>

namespace hdmbench::test {

namespace {

/// sweep.frag up to its main: textures, uniforms, energy.inc and gather.glsl.
std::string declarations() {
  std::string text = gl::assemble(sources::sweep_fragment, {.rule = 0, .colours = 1, .step_count = 1});
  text.resize(text.find("void main()"));
  return text;
}

constexpr std::string_view site_energy_start = R"(
float energy_at(Site site, float x, float y) {
  site.dx.centre = x;
  site.dy.centre = y;
  return site_energy(site);
}
float energy_at(Site site, vec2 d) { return energy_at(site, d.x, d.y); }
void main() {
  Site site = gather(gl_FragCoord.xy, dimension, penalty);
  vec2 centre = vec2(site.dx.centre, site.dy.centre);
)";

constexpr std::string_view as_printed_start = R"(
vec2 squared(vec2 v) { return v * v; }
vec2 triple(vec2 ds, float ms, vec2 dt, float mt, vec2 du, float mu) {
  return squared(mt / mu * (dt - ds) - (du - dt)) + squared(mt / ms * (dt - du) - (ds - dt));
}
struct Pixel {
  vec2 d;
  float m;
};
Pixel pixel(vec2 at, vec2 offset) {
  vec2 site = neighbour(at, offset, dimension);
  return Pixel(displacement_at(site), texture2DRect(observation, site).b);
}
struct Site3x3 {
  Pixel north_west, north, north_east, west, east, south_west, south, south_east;
  vec2 target, weight;
  float m;
};
float energy_at(Site3x3 site, vec2 d) {
  vec2 horizontal = triple(site.west.d, site.west.m, d, site.m, site.east.d, site.east.m);
  vec2 vertical = triple(site.north.d, site.north.m, d, site.m, site.south.d, site.south.m);
  vec2 falling = triple(site.north_west.d, site.north_west.m, d, site.m, site.south_east.d, site.south_east.m);
  vec2 rising = triple(site.south_west.d, site.south_west.m, d, site.m, site.north_east.d, site.north_east.m);
  return horizontal.x + vertical.y + dot(falling, vec2(1.0)) + dot(rising, vec2(1.0)) +
         dot(site.weight, abs(site.target - d));
}
void main() {
  vec2 at = gl_FragCoord.xy;
  vec2 centre = displacement_at(at);
  vec3 known = observation_at(at);
  Site3x3 site = Site3x3(pixel(at, vec2(-1, -1)), pixel(at, vec2(0, -1)), pixel(at, vec2(1, -1)), pixel(at, vec2(-1, 0)),
                         pixel(at, vec2(1, 0)), pixel(at, vec2(-1, 1)), pixel(at, vec2(0, 1)), pixel(at, vec2(1, 1)),
                         known.xy, penalty * confidence_at(at).xy, known.z);
)";

} // namespace

std::vector<std::string> uniform_steps(int count) {
  std::vector<std::string> steps;
  for (int i = 0; i < count; ++i) {
    steps.push_back(fmt::format("steps[{}]", i));
  }
  return steps;
}

std::vector<std::string> literal_steps(int count) {
  if (count == 4) {
    return {"-1.0", "-0.1", "1.0", "0.1"};
  }
  if (count == 6) {
    return {"-1.0", "-0.1", "-0.01", "1.0", "0.1", "0.01"};
  }
  throw std::invalid_argument("the thesis speaks of 4 and of 6 step sizes");
}

std::vector<Candidate> product_set(std::span<const std::string> steps) {
  std::vector<Candidate> candidates;
  for (const std::string& x : steps) {
    for (const std::string& y : steps) {
      candidates.push_back({x, y});
    }
  }
  return candidates;
}

std::vector<Candidate> diagonal_set(std::span<const std::string> steps) {
  std::vector<Candidate> candidates;
  for (const std::string& step : steps) {
    candidates.push_back({step, step});
  }
  return candidates;
}

std::string vector_candidates_shader(Energy energy, std::span<const Candidate> candidates) {
  std::string text = declarations();
  text += energy == Energy::as_printed ? as_printed_start : site_energy_start;
  text += "  vec2 d = centre;\n  vec2 best = centre;\n  float u = 0.0;\n  float lowest = 1e30;\n";
  for (const auto& [x, y] : candidates) {
    if (energy == Energy::site_energy_on_scalars) {
      text += fmt::format("  d = vec2(centre.x + {0}, centre.y + {1});\n"
                          "  u = energy_at(site, centre.x + {0}, centre.y + {1});\n",
                          x, y);
    } else {
      text += fmt::format("  d = centre + vec2({}, {});\n  u = energy_at(site, d);\n", x, y);
    }
    text += "  best = u < lowest ? d : best;\n  lowest = min(u, lowest);\n";
  }
  const char* const handed_on = energy == Energy::as_printed ? "0.0" : "inverse_modulus_at(gl_FragCoord.xy)";
  return text + fmt::format("  gl_FragColor = vec4(best, {}, 0.0);\n}}\n", handed_on);
}

} // namespace hdmbench::test
