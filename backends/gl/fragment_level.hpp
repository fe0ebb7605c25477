#pragma once

#include "backends/gl/objects.hpp"
#include "backends/tiles.hpp"
#include "kernels/pyramid.hpp"

#include <array>
#include <optional>
#include <vector>

namespace hdmbench::gl {

/// A float RGBA rectangle texture that can be fetched from and, once require_target() was called, drawn into.
class Target {
public:
  /// `pixels`: 4 floats each, or null.
  Target(const Api& api, Extent extent, const GLfloat* pixels);

  [[nodiscard]] Extent extent() const { return extent_; }
  void bind(GLint unit) const;
  /// Makes a framebuffer of it. Throws DeviceError if the driver cannot.
  void make_drawable();
  /// make_drawable() must have been called.
  void draw_into() const;
  void upload(const GLfloat* pixels) const;

private:
  const Api* api_;
  Texture texture_;
  std::optional<Framebuffer> framebuffer_;
  Extent extent_;
};

/// Throws DeviceError unless the framebuffer that is bound can be drawn into.
void require_complete(const Api& api);

/// What lets a level's sweeps leave out the tiles in which nothing can change, all of it on the device.
struct Activity {
  Target everything; ///< all tiles awake: for the first sweep
  Target awake;      ///< a texel per tile, 0: nothing can change (wake.frag)
  Target cells;      ///< a texel per cell of a tile (cells.frag)
};

/// What a level has on the device.
class FragmentLevel {
public:
  /// Sites a side of a tile. As large as the bins of Mesa's rasterizer: with 32 a dense sweep of an image all
  /// of whose sites are observed took a third longer there. Older devices' points end at 64 pixels.
  static constexpr int tile_side = 64;
  static constexpr int cells_along_a_tile = 4;

  /// A draw of the tiles of one class: points first ... first + count - 1 of the buffer.
  struct Draw {
    std::size_t tile_class = general_class;
    GLint first = 0;
    GLsizei count = 0;
  };

  /// `header` has the level's extent and strengths; `observation` and `confidence` as sweep.frag has them,
  /// null where they will be drawn. Tiles are those of the level as it samples `full`.
  FragmentLevel(const Api& api, Level header, const Level& full, Alignment alignment,
                const GLfloat* observation, const GLfloat* confidence, bool with_activity);

  /// Attribute 0 is from now on what draw_quad() and draws() need.
  void bind_vertices() const;
  /// One fragment per pixel of the extent.
  void draw_quad(Extent pixels) const;
  /// Points of `side` pixels, on a canvas of whole tiles.
  void prepare_tiles(int side) const;
  void draw_tiles(const Draw& draw) const;
  /// All tiles, whatever their class.
  void draw_all_tiles() const;

  [[nodiscard]] Target& now() { return images_[current_]; }
  [[nodiscard]] Target& other() { return images_[1 - current_]; }
  void swap() { current_ = 1 - current_; }

  const Level header; ///< without its fields
  const Extent grid;  ///< tiles
  Target observation; ///< a: 1 / modulus, for project.frag
  Target confidence;
  std::vector<Draw> draws;
  std::optional<Activity> activity;
  bool all_awake = true; ///< nothing is known of what the sweep before changed

private:
  const Api* api_;
  std::array<Target, 2> images_;
  std::size_t current_ = 0;
  Buffer vertices_;
};

} // namespace hdmbench::gl
